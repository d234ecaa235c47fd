"""Step from record to record, compiled: each one's length tells where the next begins."""

import numpy as np
from numba import njit

# Kind, and length of the content.
_HEAD = 9


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
        kind[i], start[i] = data[at], at + _HEAD
        at = end[i] = _end(data, at, size)
    return kind, start, end


@njit(cache=True)
def _end(data, at, size):
    if at + _HEAD > size:
        return size + 1
    length = np.uint64(0)
    for i in range(8):
        length |= np.uint64(data[at + 1 + i]) << np.uint64(8 * i)
    left = size - at - _HEAD
    return at + _HEAD + np.int64(length) if length <= np.uint64(left) else size + 1
