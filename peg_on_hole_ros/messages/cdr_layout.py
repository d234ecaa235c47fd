"""
Serialised messages that differ in stamp and numbers alone: read and written, one or many at once.

CDR puts the same fields of messages with the same texts and lengths in the same places. So of a
message whose definition has been walked once, all others of its layout are that one with other
numbers in it. What has no such layout, as big-endian messages, is left to the libraries.
"""

import struct
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from peg_on_hole_ros.messages.definitions import fields

# CDR, little endian; the last two bytes may be anything.
ENCAPSULATION = b"\0\1\0\0"
_LITTLE_ENDIAN = ENCAPSULATION[:2]
# The stamp of a header is the first that a message has.
_STAMP, _STAMP_END = len(ENCAPSULATION), len(ENCAPSULATION) + 8
_BEGIN_OF_HEADER = ENCAPSULATION + bytes(8)
SECOND_NS = 1_000_000_000
U32 = struct.Struct("<I")
_STAMP_FIELDS, _BIG_ENDIAN_STAMP = struct.Struct("<iI"), struct.Struct(">iI")
_TIME = "builtin_interfaces/Time"
_DOUBLE_SIZE = 8
# In place of a stamp: the message is of another layout. No stamp reaches it.
_OTHER_LAYOUT = np.iinfo(np.int64).min
# A longer message has no layout: what is kept of it takes several times as much.
_MOST_MESSAGE_BYTES = 1 << 14


class Template:
    """
    Bytes in which stamps and numbers are written anew: a message, or several of one stamp.

    Parameters
    ----------
    whole : bytes
    stamps : sequence of int
        Where a stamp lies.
    numbers : sequence of int, length k
        Where each float64 lies.

    Attributes
    ----------
    whole : bytes
    stamps, numbers : ndarray of int

    """

    def __init__(self, whole: bytes, stamps: Sequence[int], numbers: Sequence[int]) -> None:
        self.whole = whole
        self.stamps, self.numbers = np.array(stamps, np.int64), np.array(numbers, np.int64)
        self._bytes = np.frombuffer(whole, np.uint8)
        self._one = np.empty((1, len(whole)), np.uint8)

    def write(self, t_ns: np.ndarray, numbers: np.ndarray) -> np.ndarray:
        """
        Return the bytes for each stamp, shape (n, bytes).

        Parameters
        ----------
        t_ns : ndarray of int64, shape (n,)
            Stamps [ns].
        numbers : ndarray, shape (n, k)
            All float64 of each, in the order of the message.

        """
        found = np.empty((len(t_ns), len(self.whole)), np.uint8)
        self._write(t_ns, np.ascontiguousarray(numbers, np.float64), found)
        return found

    def write_one(self, t_ns: int, numbers: np.ndarray) -> bytes:
        """Return the bytes for one stamp [ns] and its numbers, shape (k,)."""
        self._write(np.array([t_ns]), numbers[None], self._one)
        return self._one.tobytes()

    def _write(self, t_ns, numbers, found):
        _write(self._bytes, self.stamps, self.numbers, t_ns, numbers.view(np.uint64), found)


def joined(templates: Sequence[Template]) -> tuple[Template, list[slice]]:
    """Return a template of all messages, one behind the other, and where each of them lies."""
    ends = np.cumsum([len(each.whole) for each in templates]).tolist()
    begins = [0, *ends[:-1]]
    stamps, numbers = (
        [begin + at for begin, each in zip(begins, templates) for at in places(each).tolist()]
        for places in (lambda each: each.stamps, lambda each: each.numbers)
    )
    whole = b"".join(each.whole for each in templates)
    return Template(whole, stamps, numbers), list(map(slice, begins, ends))


class MessageLayout(Template):
    """
    What messages of one type have in common beside their stamp and their numbers.

    Parameters
    ----------
    ros_type : str
        As in `sensor_msgs/msg/JointState`: a header, then texts and float64 alone.
    payload : bytes
        Any message of the layout, in CDR; what stands behind it is left out.

    Attributes
    ----------
    texts : tuple of str
        In the order of the message: the frame first.
    counts : tuple of int
        Lengths of the arrays of float64 of no fixed length, likewise.
    common : bytes
        All that messages of the layout have in common, zeros elsewhere: two with the same are one.

    Raises
    ------
    ValueError
        The payload does not hold what the definition says, is not little endian, or too long.

    """

    def __init__(self, ros_type: str, payload: bytes) -> None:
        walk = _MessageWalk(payload)
        walk.message(ros_type.replace("/msg/", "/"))
        super().__init__(payload[: walk.at], [_STAMP], walk.numbers)
        self.texts = tuple(text.decode() for text in walk.texts)
        self.counts = tuple(walk.counts)
        self._same = np.array(walk.same, np.int64)
        common = np.zeros(walk.at, np.uint8)
        common[self._same] = self._bytes[self._same]
        self.common = common.tobytes()
        # Of one message: begin, end, stamp, numbers.
        none = np.zeros(1, np.int64)
        self._buffers = none, none.copy(), none.copy(), np.zeros((1, len(self.numbers)), np.uint64)

    def read(
        self, data: bytes, start: np.ndarray, end: np.ndarray, numbers: np.ndarray
    ) -> "ReadMessages":
        """
        Read messages.

        Parameters
        ----------
        data : bytes
        start, end : ndarray of int64, shape (n,)
            Of each message in `data`.
        numbers : ndarray of int, shape (k,)
            Which are read: some of `self.numbers`.

        """
        t_ns = np.empty(len(start), np.int64)
        words = np.zeros((len(start), len(numbers)), np.uint64)
        bytes_ = np.frombuffer(data, np.uint8)
        _read(bytes_, start, end, self._same, self._bytes, numbers, t_ns, words)
        return ReadMessages(t_ns != _OTHER_LAYOUT, t_ns, words.view(np.float64))

    def read_one(self, payload: bytes) -> tuple[int, list[float]] | None:
        """Return stamp [ns] and all numbers of a message; None: it is of another layout."""
        start, end, t_ns, words = self._buffers
        end[0] = len(payload)
        bytes_ = np.frombuffer(payload, np.uint8)
        _read(bytes_, start, end, self._same, self._bytes, self.numbers, t_ns, words)
        stamp = int(t_ns[0])
        return None if stamp == _OTHER_LAYOUT else (stamp, words.view(np.float64)[0].tolist())


class ReadMessages(NamedTuple):
    """
    Stamps and numbers of messages.

    Attributes
    ----------
    fits : ndarray of bool, shape (n,)
        Which messages are of the layout; of the others the rest is void.
    t_ns : ndarray of int64, shape (n,)
        Stamps [ns].
    numbers : ndarray, shape (n, k)

    """

    fits: np.ndarray
    t_ns: np.ndarray
    numbers: np.ndarray


def stamps(data: bytes, start: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Return which messages that begin with a header have a stamp that can be, and stamps [ns].

    Parameters
    ----------
    data : bytes
    start, end : ndarray of int64, shape (n,)
        Of each message in `data`.

    """
    bytes_, header = (np.frombuffer(each, np.uint8) for each in (data, _BEGIN_OF_HEADER))
    same, none = np.arange(len(_LITTLE_ENDIAN)), np.empty(0, np.int64)
    t_ns, no_words = np.empty(len(start), np.int64), np.zeros((len(start), 0), np.uint64)
    _read(bytes_, start, end, same, header, none, t_ns, no_words)
    return t_ns != _OTHER_LAYOUT, t_ns


def stamp_ns(payload: bytes) -> int:
    """Return the stamp [ns] of a message that begins with a header; 0 for a stump."""
    if len(payload) < _STAMP_END:
        return 0
    stamp = _STAMP_FIELDS if payload[1] & 1 else _BIG_ENDIAN_STAMP
    sec, nanosec = stamp.unpack_from(payload, _STAMP)
    return sec * SECOND_NS + nanosec


class _MessageWalk:
    """Through the bytes of a message, by its definition: what recurs, and where numbers lie."""

    def __init__(self, payload):
        if payload[:2] != _LITTLE_ENDIAN or len(payload) > _MOST_MESSAGE_BYTES:
            raise ValueError(f"not in little endian, or longer than {_MOST_MESSAGE_BYTES} bytes")
        self._payload, self.at = payload, len(ENCAPSULATION)
        self.same, self.numbers = [0, 1], []
        self.texts: list[bytes] = []
        self.counts: list[int] = []

    def message(self, name):
        for kind, _, _ in fields(name):
            base, _, length = kind.removesuffix("]").partition("[")
            if not kind.endswith("]"):
                self._part(base, 1)
            elif length:
                self._part(base, int(length))
            else:
                count = self._u32()
                if base == "float64":
                    self.counts.append(count)
                self._part(base, count)

    def _part(self, base, count):
        if base == "float64":
            first = self._begin(_DOUBLE_SIZE if count else 1, _DOUBLE_SIZE * count)
            self.numbers += range(first, self.at, _DOUBLE_SIZE)
            return
        if base == _TIME:
            self._begin(4, 8 * count)
            return
        # A text or a message takes four bytes at least: so many may be there at most.
        if count > len(self._payload):
            raise ValueError("more parts than bytes")
        for _ in range(count):
            if base == "string":
                self._text()
            else:
                self.message(base)

    def _text(self):
        length = self._u32()
        first = self._begin(1, length)
        if not length:
            raise ValueError("a text without its final zero")
        self.same += range(first, self.at)
        self.texts.append(self._payload[first : self.at - 1])

    def _u32(self):
        first = self._begin(4, 4)
        self.same += range(first, self.at)
        return U32.unpack_from(self._payload, first)[0]

    def _begin(self, size, length):
        """Go on to the next place of a size, and past a length; return that place."""
        first = self.at + (len(ENCAPSULATION) - self.at) % size
        if first + length > len(self._payload):
            raise ValueError("a message ends before what it has to hold")
        self.at = first + length
        return first


@njit(cache=True)
def _read(data, start, end, same, whole, numbers, t_ns, words):
    """
    Read stamps and numbers of messages.

    A stamp is _OTHER_LAYOUT where a message is shorter than `whole`, differs from it in one of the
    bytes that are the `same` in all, or has no stamp that can be.
    """
    for i in range(len(start)):
        at = start[i]
        fits = end[i] - at >= len(whole)
        k = 0
        while fits and k < len(same):
            fits = data[at + same[k]] == whole[same[k]]
            k += 1
        if fits:
            seconds = np.int64(np.int32(np.uint32(_word(data, at + _STAMP, 4))))
            nanoseconds = np.int64(_word(data, at + _STAMP + 4, 4))
            fits = nanoseconds < SECOND_NS
        if not fits:
            t_ns[i] = _OTHER_LAYOUT
            continue
        t_ns[i] = seconds * SECOND_NS + nanoseconds
        for k in range(len(numbers)):
            words[i, k] = _word(data, at + numbers[k], _DOUBLE_SIZE)


@njit(cache=True)
def _word(data, at, size):
    word = np.uint64(0)
    for i in range(size):
        word |= np.uint64(data[at + i]) << np.uint64(8 * i)
    return word


@njit(cache=True)
def _write(whole, stamps, places, t_ns, words, out):
    """Fill in a row for each stamp."""
    for i in range(len(t_ns)):
        for k in range(len(whole)):
            out[i, k] = whole[k]
        seconds = t_ns[i] // SECOND_NS
        nanoseconds = t_ns[i] - seconds * SECOND_NS
        for at in stamps:
            # Seconds are signed: before 1970 they wrap.
            _put(out, i, at, np.uint64(seconds), 4)
            _put(out, i, at + 4, np.uint64(nanoseconds), 4)
        for k in range(len(places)):
            _put(out, i, places[k], words[i, k], _DOUBLE_SIZE)


@njit(cache=True)
def _put(out, i, at, word, size):
    for k in range(size):
        out[i, at + k] = np.uint8((word >> np.uint64(8 * k)) & np.uint64(0xFF))
