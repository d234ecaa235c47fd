"""Wrenches that come in order among orientations that come late: what has to be taken again."""

from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.engine.history import Run, Unit
from peg_on_hole_ros.engine.state import ORIENTATION
from peg_on_hole_ros.records import AngleMeasurement


class Stretch(NamedTuple):
    """
    Wrenches in order, the first of which have been processed, with all orientations among them.

    Attributes
    ----------
    t_ns, wrenches, ends, placed, stamps, orientations : ndarray
        See `engine.advance.advance`.
    begin : int
        How many of the wrenches have been processed.
    taken : int
        How many of the orientations have been.
    back : int
        How many wrenches the orientation that comes latest reaches back.

    """

    t_ns: np.ndarray
    wrenches: np.ndarray
    ends: np.ndarray
    placed: np.ndarray
    stamps: np.ndarray
    orientations: np.ndarray
    begin: int = 0
    taken: int = 0
    back: int = 0

    def had(self, i: int, k: int) -> int:
        """Return how many orientations there are for wrench k once wrench i has come."""
        return int(min(self.ends[i], self.placed[k]))

    def since(self, t_ns: int) -> int:
        """Return how many of the wrenches are of a stamp [ns] or after it."""
        return len(self.t_ns) - int(np.searchsorted(self.t_ns, t_ns))

    def measurements(self, begin: int, end: int) -> deque[AngleMeasurement]:
        """Return orientations by their places."""
        some = slice(begin, end)
        return deque(map(AngleMeasurement.of_row, self.stamps[some], self.orientations[some]))

    def run(
        self, first: int, last: int, taken: int, before: object, begin_ns: int, begin: int = 0
    ) -> Run:
        """
        Return wrenches by their places as a run.

        Parameters
        ----------
        first, last : int
        taken : int
            How many orientations of the stretch have been taken with them.
        before : object
            Snapshot before the first one.
        begin_ns : int
            Stamp that the estimate had come to before the stretch [ns].
        begin : int
            How many orientations had been taken before the first one.

        """
        begin = max(begin, int(self.placed[first - 1]) if first else 0)
        some, own = slice(first, last), slice(begin, taken)
        ends = np.clip(self.placed[some], begin, taken) - begin
        began = int(self.t_ns[first - 1]) if first else begin_ns
        return Run(
            self.t_ns[some],
            self.wrenches[some],
            ends,
            self.stamps[own],
            self.orientations[own],
            before,
            began,
        )


def stretch_of(
    units: Sequence[Unit],
    waiting: Sequence[AngleMeasurement],
    of_wrench: np.ndarray,
    new_ns: np.ndarray,
    wrenches: np.ndarray,
    orientations: np.ndarray,
) -> Stretch:
    """
    Return messages in order behind what has been processed.

    Parameters
    ----------
    units : sequence of Unit
        That have been processed, as far as an orientation may reach back.
    waiting : sequence of AngleMeasurement
        Orientations that wait for the wrench of their time.
    of_wrench, new_ns, wrenches, orientations : ndarray
        See `Arrivals`; stamps of the wrenches rise, and so do those of the orientations.

    """
    at, behind = np.flatnonzero(of_wrench), np.cumsum(of_wrench)[~of_wrench]
    joint_ns, m = new_ns[~of_wrench], len(units)
    # An orientation of a wrench's own stamp that came after it is the next one's.
    had, where, held = [], [], []
    for k, unit in enumerate(units):
        had += [*unit.joints, *unit.after]
        where += [k] * len(unit.joints) + [k + 1] * len(unit.after)
        held.append([*unit.wrench.force, *unit.wrench.torque])
    taken = len(had)
    had += waiting
    # An empty list is one of floats, which have no room for a stamp.
    t_ns = np.concatenate([np.array([u.wrench.t_ns for u in units], np.int64), new_ns[at]])
    stamps = np.concatenate([np.array([each.t_ns for each in had], np.int64), joint_ns])
    belongs = np.searchsorted(t_ns, stamps)
    belongs[:taken] = where
    own = slice(len(had), None)
    if len(t_ns):
        same = t_ns[np.minimum(belongs[own], len(t_ns) - 1)] == joint_ns
        belongs[own] += same & (belongs[own] + 1 == m + behind)
    placed = np.searchsorted(belongs, np.arange(len(t_ns)), "right")
    ends = np.concatenate([placed[:m], len(had) + at - np.arange(len(at))])
    late = m + behind - belongs[own]
    return Stretch(
        t_ns,
        np.concatenate([np.reshape(held, (-1, 6)), wrenches]),
        ends,
        placed,
        stamps,
        np.concatenate([np.reshape([each.row for each in had], (-1, ORIENTATION)), orientations]),
        m,
        taken,
        int(max(late, default=0)),
    )
