"""
Many serialised wrenches or joint states at once, as arrays.

CDR puts the same fields of messages with the same texts in the same places. What lies elsewhere,
as in big-endian messages or where names and positions differ in number, is left to a decoder that
reads field by field.
"""

import struct
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.bags.message_places import Rows, gathered
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE

# CDR, little endian; the two bytes behind may be anything.
_LITTLE_ENDIAN = 0x0100
_HEADER = np.dtype(
    [("form", "<u2"), ("options", "<u2"), ("sec", "<i4"), ("nanosec", "<u4"), ("length", "<u4")]
)
_SECOND = 1_000_000_000
_U32 = struct.Struct("<I")
# Distinct texts that are kept at most, and that are looked for among the messages of a stretch.
_MOST_LAYOUTS, _MOST_AT_ONCE = 4096, 16
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


class _Begin(NamedTuple):
    # What joint states of a layout begin with behind the stamp, and which of these bytes count.
    content: np.ndarray
    mask: np.ndarray
    number: int
    # Of those with efforts.
    full: int


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
        self._known: dict[tuple, int] = {}
        # Of joint states, by what stands between stamp and positions, without rubbish in gaps.
        self._latest: dict[bytes, _Begin] = {}

    def columns(self, ros_type: str, rows: Rows) -> Columns:
        """Return messages of WRENCH_TYPE or JOINTS_TYPE as columns."""
        n = len(rows.start)
        layout, t_ns = np.full(n, NO_LAYOUT), np.zeros(n, np.int64)
        whole = np.flatnonzero(rows.end - rows.start >= _HEADER.itemsize)
        head = gathered(rows.data, rows.start[whole], _HEADER)
        fits = (head["form"] == _LITTLE_ENDIAN) & (head["nanosec"] < _SECOND)
        # A text has its final zero.
        fits &= (head["length"] > 0) & (head["length"] < rows.end[whole] - rows.start[whole])
        whole, head = whole[fits], head[fits]
        t_ns[whole] = head["sec"].astype(np.int64) * _SECOND + head["nanosec"]
        fill = {WRENCH_TYPE: self._wrenches, JOINTS_TYPE: self._joints}[ros_type]
        parts = fill(rows, whole, head["length"].astype(np.int64))
        width = max((values.shape[1] for _, _, values in parts), default=0)
        values = np.zeros((n, width))
        for at, number, found in parts:
            layout[at] = number
            values[at, : found.shape[1]] = found
        return Columns(layout, t_ns, values)

    def _number(self, frame: bytes, names: tuple[str, ...], width: int, efforts=False) -> int:
        """Return the place of a layout, or NO_LAYOUT where its texts are none."""
        key = frame, names, width, efforts
        number = self._known.get(key)
        if number is None:
            try:
                layout = Layout(frame[:-1].decode(), names, width, efforts)
            except UnicodeDecodeError:
                return NO_LAYOUT
            if len(self.all) >= _MOST_LAYOUTS:
                return NO_LAYOUT
            number = self._known[key] = len(self.all)
            self.all.append(layout)
        return number

    def _wrenches(self, rows, at, length):
        parts = []
        for size in np.unique(length)[:_MOST_AT_ONCE].tolist():
            places = at[length == size]
            # Offsets count from behind the four bytes of the encapsulation.
            numbers = 4 + (12 + size + 7) // 8 * 8
            places = places[rows.end[places] - rows.start[places] >= numbers + 48]
            start = rows.start[places]
            frames = gathered(rows.data, start + 16, f"V{size}")
            values = gathered(rows.data, start + numbers, "V48").view("<f8").reshape(-1, 6)
            for frame, which in _distinct(frames):
                number = self._number(frame, (), 6)
                if number != NO_LAYOUT:
                    parts.append((places[which], number, values[which]))
        return parts

    def _joints(self, rows, at, length):
        parts, tried = [], 0
        for begin in list(self._latest.values())[: -_MOST_AT_ONCE - 1 : -1]:
            at = self._alike(rows, at, begin, parts)
        while len(at) and tried < _MOST_AT_ONCE:
            tried += 1
            first = rows.data[rows.start[at[0]] : rows.end[at[0]]]
            begin = self._begin(first)
            left = self._alike(rows, at, begin, parts) if begin else at
            at = left[1:] if len(left) == len(at) else left
        return parts

    def _begin(self, payload):
        """Learn how a joint state begins; None: it has not as many positions as names."""
        try:
            texts, mask, positions = _begin_of_joints(payload)
            frame, *names = texts
            names = tuple(name[:-1].decode() for name in names)
        except (struct.error, ValueError):
            return None
        number, full = (self._number(frame, names, len(names), e) for e in (False, self._efforts))
        if positions != len(names) or NO_LAYOUT in (number, full):
            return None
        mask = np.array(mask, np.uint8)
        content = np.frombuffer(payload, np.uint8)[12 : 12 + len(mask)] & mask
        if len(self._latest) >= _MOST_LAYOUTS:
            self._latest.clear()
        begin = self._latest[content.tobytes()] = _Begin(content, mask, number, full)
        return begin

    def _alike(self, rows, at, begin, parts):
        """Take those that begin so; return the places of the others."""
        count, length = self.all[begin.number].width, len(begin.mask)
        numbers = 12 + length
        numbers += -(numbers - 4) % 8 if count else 0
        behind = numbers + 8 * count
        size = rows.end[at] - rows.start[at]
        long = at[size >= behind + 4]
        begins = gathered(rows.data, rows.start[long] + 12, f"V{length}")
        begins = begins.view(np.uint8).reshape(-1, length) & begin.mask
        found = long[(begins == begin.content).all(axis=1)]
        # Velocity has to be there, and is not looked at; effort where it is asked for.
        found, behind, _ = _after_array(rows, found, behind)
        found, behind, efforts = _after_array(rows, found, behind)
        if self._efforts:
            fits = (efforts == count) | (efforts == 0)
            found, behind, efforts = found[fits], behind[fits], efforts[fits]
        has = (efforts == count) & (count > 0) & self._efforts
        for which, more, number in ((~has, 0, begin.number), (has, count, begin.full)):
            if which.any():
                start = rows.start[found[which]]
                values = _doubles(rows.data, start + numbers, count)
                effort = _doubles(rows.data, start + behind[which] - 8 * count, more)
                parts.append((found[which], number, np.hstack([values, effort])))
        return at[~np.isin(at, found)] if len(found) else at


def _distinct(frames):
    """Return pairs of bytes and the places that have them."""
    if not len(frames):
        return []
    texts = frames.view(np.uint8).reshape(len(frames), -1)
    if (texts == texts[0]).all():
        return [(texts[0].tobytes(), slice(None))]
    found, inverse = np.unique(texts, axis=0, return_inverse=True)
    inverse = inverse.reshape(-1)
    return [(found[i].tobytes(), np.flatnonzero(inverse == i)) for i in range(len(found))]


def _doubles(data, start, count):
    """Return so many doubles from each of some places on, shape (n, count)."""
    if not count:
        return np.empty((len(start), 0))
    return gathered(data, start, f"V{8 * count}").view("<f8").reshape(len(start), count)


def _after_array(rows, at, behind):
    """Return those whose array of doubles is whole, where it ends, and how many it has."""
    behind = behind + np.zeros(len(at), np.int64) if np.isscalar(behind) else behind  # type: ignore[operator]
    behind = behind + -behind % 4  # type: ignore[operator]
    size = rows.end[at] - rows.start[at]
    whole = size >= behind + 4
    at, behind, size = at[whole], behind[whole], size[whole]
    count = gathered(rows.data, rows.start[at] + behind, "<u4").astype(np.int64)
    behind = behind + 4
    end = np.where(count > 0, behind + -(behind - 4) % 8 + 8 * count, behind)
    whole = size >= end
    return at[whole], end[whole], count[whole]


def _begin_of_joints(payload):
    """
    Return frame and names of a joint state, a mask over them, and the number of positions.

    The mask begins behind the stamp; it is 0 in gaps, which ROS fills with rubbish.
    """
    mask: list[int] = []
    texts = [_text(payload, mask)]
    names = _count(payload, mask)
    if names > len(payload):
        raise ValueError
    texts += [_text(payload, mask) for _ in range(names)]
    return texts, mask, _count(payload, mask)


def _count(payload, mask):
    mask += [0] * (-len(mask) % 4) + [255] * 4
    return _U32.unpack_from(payload, 8 + len(mask))[0]


def _text(payload, mask):
    length, at = _count(payload, mask), 12 + len(mask)
    if not 0 < length <= len(payload) - at:
        raise ValueError
    mask += [255] * length
    return payload[at : at + length]
