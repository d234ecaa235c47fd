"""
Many serialised wrenches or joint states at once, as arrays.

What has no fixed layout, as where names and positions differ in number, is left to a decoder that
reads field by field.
"""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.bags.storage.message_rows import MessageRows
from peg_on_hole_ros.messages.cdr_layout import MessageLayout
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE

# Distinct layouts that are told apart at most; of bytes, kept at most and looked for in one block.
_MOST_LAYOUTS, _MOST_LEARNT, _MOST_AT_ONCE = 4096, 256, 16
NO_LAYOUT = -1


class Layout(NamedTuple):
    """
    What messages have in common beside their stamps and numbers.

    Attributes
    ----------
    frame_id : str
    names : tuple of str
        Of the joints; of a wrench none.
    width : int
        How many numbers there are: of a wrench six, forces [N] first, then torques [N m], else
        the positions [rad or m].
    efforts : bool
        Whether as many efforts stand behind the positions.

    """

    frame_id: str
    names: tuple[str, ...]
    width: int
    efforts: bool = False


class Columns(NamedTuple):
    """
    Messages of one topic.

    Attributes
    ----------
    layout : ndarray of int, shape (n,)
        Place in `Layouts.all`; NO_LAYOUT: the message does not fit, the rest of its row is void.
    t_ns : ndarray of int64, shape (n,)
        Stamps [ns].
    values : ndarray, shape (n, m)
        As many as the layout has, then as many efforts where it has these; others are 0.

    """

    layout: np.ndarray
    t_ns: np.ndarray
    values: np.ndarray


class _LearntLayout(NamedTuple):
    # A layout of bytes, its place in `Layouts.all`, and which of its numbers are read.
    layout: MessageLayout
    number: int
    places: np.ndarray


class Layouts:
    """
    The layouts that were met.

    Parameters
    ----------
    efforts : bool
        Whether efforts of joint states are read too; one with neither as many as positions nor
        none does not fit.

    Attributes
    ----------
    all : list of Layout

    """

    def __init__(self, efforts: bool = False) -> None:
        self.all: list[Layout] = []
        self._efforts = efforts
        self._numbers: dict[Layout, int] = {}
        # By what their messages have in common, the last used last.
        self._learnt: dict[str, dict[bytes, _LearntLayout]] = {WRENCH_TYPE: {}, JOINTS_TYPE: {}}

    def columns(self, ros_type: str, rows: MessageRows) -> Columns:
        """Return messages of WRENCH_TYPE or JOINTS_TYPE as columns."""
        n = len(rows.start)
        columns = Columns(np.full(n, NO_LAYOUT), np.zeros(n, np.int64), np.zeros((n, 0)))
        left, known = np.arange(n), self._learnt[ros_type]
        for learnt in list(known.values())[: -_MOST_AT_ONCE - 1 : -1]:
            left, columns = _filled(columns, rows, left, learnt)
        for _ in range(_MOST_AT_ONCE):
            if not len(left):
                break
            learnt = self._learn(ros_type, rows.data[rows.start[left[0]] : rows.end[left[0]]])
            if learnt is None:
                left = left[1:]
                continue
            # What it is learnt of may have a stamp that cannot be.
            others, columns = _filled(columns, rows, left, learnt)
            left = left[1:] if len(others) == len(left) else others
        return columns

    def _learn(self, ros_type: str, payload: bytes) -> _LearntLayout | None:
        try:
            layout = MessageLayout(ros_type, payload)
        except ValueError:
            return None
        frame, *names = layout.texts
        if ros_type == WRENCH_TYPE:
            found, places = Layout(frame, (), 6), layout.numbers
        else:
            positions, _, efforts = layout.counts
            has = self._efforts and efforts > 0
            if positions != len(names) or has and efforts != positions:
                return None
            found = Layout(frame, tuple(names), positions, has)
            places = layout.numbers[:positions]
            if has:
                places = np.append(places, layout.numbers[-efforts:])
        number = self._number(found)
        if number == NO_LAYOUT:
            return None
        known = self._learnt[ros_type]
        if len(known) >= _MOST_LEARNT:
            known.clear()
        known.pop(layout.common, None)
        learnt = known[layout.common] = _LearntLayout(layout, number, places)
        return learnt

    def _number(self, layout: Layout) -> int:
        """Return the place of a layout, or NO_LAYOUT where there are too many."""
        number = self._numbers.get(layout)
        if number is None:
            if len(self.all) >= _MOST_LAYOUTS:
                return NO_LAYOUT
            number = self._numbers[layout] = len(self.all)
            self.all.append(layout)
        return number


def _filled(columns, rows, left, learnt):
    """Fill in those messages that are of a layout; return the places of the others, and all."""
    if not len(left):
        return left, columns
    found = learnt.layout.read(rows.data, rows.start[left], rows.end[left], learnt.places)
    at, fits = left[found.fits], found.fits
    if not len(at):
        return left, columns
    columns.layout[at], columns.t_ns[at] = learnt.number, found.t_ns[fits]
    width = found.numbers.shape[1]
    missing = width - columns.values.shape[1]
    if missing > 0:
        columns = columns._replace(values=np.pad(columns.values, ((0, 0), (0, missing))))
    columns.values[at, :width] = found.numbers[fits]
    return left[~fits], columns
