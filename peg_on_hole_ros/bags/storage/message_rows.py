"""The messages of a stretch of MCAP records, as arrays of where they lie."""

import struct
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from mcap.opcode import Opcode
from numba import njit

from peg_on_hole_ros.bags.storage.unpacking import ZSTD_MAGIC, check_size, message_content

HEAD = struct.Struct("<BQ")
# What stands before a message's payload.
_MESSAGE = np.dtype([("channel", "<u2"), ("sequence", "<u4"), ("log", "<u8"), ("publish", "<u8")])
# No recorder's clock is beyond this (the year 2116), and sums of two fit 64 bits [ns].
LATEST = 1 << 62
# Kind, and length of the content.
_HEAD_SIZE = HEAD.size


class MessageRows(NamedTuple):
    """
    Messages in the order of the file.

    Attributes
    ----------
    data : bytes
        What holds them.
    channel : ndarray of int, shape (n,)
    log_ns : ndarray of int64, shape (n,)
        [ns], at most LATEST.
    start, end : ndarray of int64, shape (n,)
        Of each payload in `data`.

    """

    data: bytes
    channel: np.ndarray
    log_ns: np.ndarray
    start: np.ndarray
    end: np.ndarray

    def of(self, wanted: np.ndarray) -> "MessageRows":
        """Return some of them, by a mask or by places."""
        return MessageRows(self.data, *(each[wanted] for each in self[1:]))


def gathered(data: bytes, start: np.ndarray, dtype: np.dtype | str) -> np.ndarray:
    """Return what lies at each of some places, as an array of a dtype; all must be within."""
    dtype = np.dtype(dtype)
    if not len(start):
        return np.empty(0, dtype)
    if start.max() + dtype.itemsize > len(data) or start.min() < 0:
        raise ValueError("a record ends before what it has to hold")
    raw = np.dtype(f"V{dtype.itemsize}")
    shifted = np.ndarray((len(data) - dtype.itemsize + 1,), raw, data, strides=(1,))
    return shifted[start].view(dtype)


def nothing_else(opcode: int, start: int, end: int) -> None:
    """Take a record that is no message, and do nothing."""


def rows_in(data: bytes, other: Callable[[int, int, int], None] = nothing_else) -> MessageRows:
    """
    Return the messages among records, and give every other record to `other`.

    Parameters
    ----------
    data : bytes
    other : callable
        Takes opcode, start and end of the content.

    Raises
    ------
    ValueError
        A record is longer than what holds it.

    """
    kind, start, end = walk(np.frombuffer(data, np.uint8))
    message = kind == Opcode.MESSAGE.value
    for i in np.flatnonzero(~message).tolist():
        if end[i] <= len(data):
            other(int(kind[i]), int(start[i]), int(end[i]))
    if len(end) and end[-1] > len(data):
        raise ValueError("a record is longer than what holds it")
    start, end = start[message], end[message]
    if (end - start < _MESSAGE.itemsize).any():
        raise ValueError("a message is shorter than its head")
    head = gathered(data, start, _MESSAGE)
    log_ns = np.minimum(head["log"], np.uint64(LATEST)).astype(np.int64)
    return MessageRows(
        data, head["channel"].astype(np.int64), log_ns, start + _MESSAGE.itemsize, end
    )


def unpacked(rows: MessageRows, most: int) -> MessageRows:
    """
    Return the same messages with those unpacked that the recorder packed one by one.

    Told by their first bytes: no message in CDR begins as a zstd frame does. What cannot be
    unpacked stays, and cannot be decoded.

    Raises
    ------
    ValueError
        Together they take more than `most` bytes.

    """
    magic = np.frombuffer(ZSTD_MAGIC, "<u4")[0]
    long = np.flatnonzero(rows.end - rows.start >= len(ZSTD_MAGIC))
    packed = long[gathered(rows.data, rows.start[long], "<u4") == magic]
    if not len(packed):
        return rows
    start, end = rows.start.copy(), rows.end.copy()
    parts, size = [rows.data], len(rows.data)
    for i in packed.tolist():
        try:
            part = message_content(rows.data[start[i] : end[i]], most)
        except ValueError:
            continue
        parts.append(part)
        start[i], size = size, size + len(part)
        end[i] = size
        check_size(size - len(rows.data), most)
    return rows._replace(data=b"".join(parts), start=start, end=end)


@njit(cache=True)
def walk(data: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Return kind, begin and end of the content of each record.

    Parameters
    ----------
    data : ndarray of uint8

    Returns
    -------
    kind : ndarray of uint8, shape (n,)
    start, end : ndarray of int64, shape (n,)
        The last end is beyond `data` where its record is not whole.

    """
    size = len(data)
    # Records are counted first: their places take more than what the shortest of them does.
    count = at = 0
    while at < size:
        at = _end(data, at, size)
        count += 1
    kind = np.empty(count, np.uint8)
    start, end = np.empty(count, np.int64), np.empty(count, np.int64)
    at = 0
    for i in range(count):
        kind[i], start[i] = data[at], at + _HEAD_SIZE
        at = end[i] = _end(data, at, size)
    return kind, start, end


@njit(cache=True)
def _end(data, at, size):
    if at + _HEAD_SIZE > size:
        return size + 1
    length = np.uint64(0)
    for i in range(8):
        length |= np.uint64(data[at + 1 + i]) << np.uint64(8 * i)
    left = size - at - _HEAD_SIZE
    return at + _HEAD_SIZE + np.int64(length) if length <= np.uint64(left) else size + 1
