"""
Impossible log times found, and replaced by the messages' stamps.

A log time is taken for wrong where two things hold. Log time less stamp differs from what it is
for most messages about it, and the log time lies farther from most of those about it in the file
than the stamp does. A stamp that is wrong, or a recording that was played again, fails the second.
A log time of 0 was never set: it says nothing of those about it, however many there are.
"""

import numpy as np

# Transport takes less, and clocks that are apart by less cost one message at most [ns].
FAR_NS = 1_000_000_000
# Messages about one that it is compared with, on either side, and the fewest that decide anything:
# of so many more than half are hardly ever wrong where a third of all are.
ABOUT, _FEWEST_NEIGHBOURS = 64, 9
# In a bag that is played slowly they are apart: so many times what half of them span is near.
_WIDTHS = 3.0
# Messages that are looked at together: their neighbours take memory.
_COMPARED_TOGETHER = 4096


class LogTimes:
    """Looks at the messages of a file in its order, some thousands at a time."""

    def __init__(self) -> None:
        self._log = self._stamp = np.empty(0, np.int64)

    def placed(
        self, log_ns: np.ndarray, stamp_ns: np.ndarray, count: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """
        Return which log times are wrong, and what takes their place.

        Parameters
        ----------
        log_ns, stamp_ns : ndarray of int64, shape (n,)
            Of messages with a stamp, in the order of the file [ns].
        count : int
            So many of them are decided. The others come again, and should be ABOUT or more.

        Returns
        -------
        wrong : ndarray of int64, shape (m,)
            Places of those in `log_ns`.
        place_ns : ndarray of int64, shape (m,)
            Their stamps with the distance of log time and stamp of those about them [ns].

        """
        before = len(self._log)
        log, stamp = np.append(self._log, log_ns), np.append(self._stamp, stamp_ns)
        offset = log - stamp
        tells = np.flatnonzero(log) if log.any() else np.arange(len(log))
        suspect = np.flatnonzero(np.abs(offset - _median(offset[tells])) > FAR_NS)
        suspect = suspect[(suspect >= before) & (suspect < before + count)]
        parts = np.split(suspect, range(_COMPARED_TOGETHER, len(suspect), _COMPARED_TOGETHER))
        found = [_out_of_place(part, log, stamp, tells) for part in parts]
        wrong = np.concatenate([at for at, _ in found])
        good = np.ones(before + count, bool)
        good[wrong] = False
        decided = slice(before + count)
        self._log, self._stamp = log[decided][good][-ABOUT:], stamp[decided][good][-ABOUT:]
        return wrong - before, np.concatenate([place for _, place in found])


def _out_of_place(suspect, log, stamp, tells):
    """Return which of some log times are wrong, and their places in time [ns]."""
    # Less what they are about: 64 bits of nanoseconds do not fit a float.
    logged, offset = log[suspect], log - stamp
    seconds, places, near = [], [], []
    before = np.searchsorted(tells, suspect)[:, None] - np.arange(1, ABOUT + 1)
    behind = np.searchsorted(tells, suspect, side="right")[:, None] + np.arange(ABOUT)
    for at in (before, behind):
        there = (at >= 0) & (at < len(tells))
        at = tells[np.clip(at, 0, len(tells) - 1)]
        # Beyond a run that tells nothing those that are farther.
        close = there & (np.abs(at - suspect[:, None]) <= ABOUT)
        there = np.where(close.sum(axis=1, keepdims=True) >= _FEWEST_NEIGHBOURS, close, there)
        about, wide, enough = _most(log[at], there)
        place = stamp[suspect] + _most(offset[at], there)[0]
        # A recorder's own clock may jump: what fits either side is in its place.
        away = np.abs(logged - about).astype(float)
        seconds.append(np.where(enough, [away, away - _WIDTHS * wide], np.inf))
        near.append(np.where(enough, np.abs(place - about).astype(float), np.inf))
        places.append(place)
    away, beyond = np.min(seconds, axis=0)
    side = np.argmin(near, axis=0)
    wrong = (beyond > FAR_NS) & (np.min(near, axis=0) + FAR_NS < away)
    return suspect[wrong], np.where(side, places[1], places[0])[wrong]


def _most(values, there):
    """
    Return the middle of most values of each row, what they span, and whether they are enough.

    Most are the half that lie closest together: what the others are does not matter.
    """
    # Those that are not there come last.
    found = np.where(there, values, np.iinfo(np.int64).max)
    found.sort(axis=1)
    count, rows = there.sum(axis=1), np.arange(len(there))
    last = np.arange(there.shape[1]) + count[:, None] // 2
    inside = last < count[:, None]
    ends = np.take_along_axis(found, np.where(inside, last, 0), axis=1)
    begin = np.argmin(np.where(inside, ends - found, np.iinfo(np.int64).max), axis=1)
    middle = found[rows, begin + count // 4]
    wide = (found[rows, begin + count // 2] - found[rows, begin]).astype(float)
    enough = count >= _FEWEST_NEIGHBOURS
    return np.where(enough, middle, 0), np.where(enough, wide, 0.0), enough


def _median(values):
    return np.partition(values, len(values) // 2)[len(values) // 2] if len(values) else 0
