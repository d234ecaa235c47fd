"""
Log times that cannot be: messages whose stamp says better than the log time when they came.

A log time is taken for wrong where two things hold. Log time less stamp differs from what it is
for the messages about it, and the log time lies farther from those about it in the file than the
stamp does. A stamp that is wrong, or a recording that was played again, fails the second.
"""

import numpy as np

# Transport takes less, and clocks that are apart by less cost one message at most [ns].
FAR_NS = 1_000_000_000
# Messages about one that it is compared with, on either side; fewer than _FEWEST tell nothing.
_ABOUT, _FEWEST = 16, 9
# In a bag that is played slowly they are apart: so many of their quartile ranges are near.
_WIDTHS = 3.0


class LogTimes:
    """Looks at the messages of a file in its order, some thousands at a time."""

    def __init__(self) -> None:
        self._log = self._stamp = np.empty(0, np.int64)

    def placed(self, log_ns: np.ndarray, stamp_ns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        Return which log times are wrong, and what takes their place.

        Parameters
        ----------
        log_ns, stamp_ns : ndarray of int64, shape (n,)
            Of messages with a stamp, in the order of the file [ns].

        Returns
        -------
        wrong : ndarray of int64, shape (m,)
            Places of those in `log_ns`.
        place_ns : ndarray of int64, shape (m,)
            Their stamps with the median distance of stamp and log time [ns].

        """
        before = len(self._log)
        log, stamp = np.append(self._log, log_ns), np.append(self._stamp, stamp_ns)
        nothing = np.empty(0, np.int64)
        if len(log) < _FEWEST:
            self._log, self._stamp = log, stamp
            return nothing, nothing
        offset = log - stamp
        usual = _median(offset)
        suspect = np.flatnonzero(np.abs(offset - usual) > FAR_NS)
        place = stamp + usual
        wrong = suspect[_wrong(suspect, log, place)]
        good = np.ones(len(log), bool)
        good[wrong] = False
        self._log, self._stamp = log[good][-_ABOUT:], stamp[good][-_ABOUT:]
        wrong = wrong[wrong >= before]
        return wrong - before, place[wrong]


def _wrong(suspect, log, place):
    # In seconds: it is a matter of these, and 64 bits of nanoseconds do not fit a float.
    times, far = log * 1e-9, FAR_NS * 1e-9
    steps = np.arange(1, _ABOUT + 1)
    sides = [_beside(suspect, times, side) for side in (-steps, steps)]

    def away(seconds, widths):
        # A recorder's own clock may jump: what fits either side is in its place.
        return np.min([np.abs(seconds - middle) - widths * wide for middle, wide in sides], axis=0)

    logged = times[suspect]
    out = away(logged, _WIDTHS) > far
    return out & (away(place[suspect] * 1e-9, 0.0) + far < away(logged, 0.0))


def _beside(suspect, times, steps):
    """Return median and quartile range of the times on one side of each; infinite: too few."""
    at = suspect[:, None] + steps
    there = (at >= 0) & (at < len(times))
    # Those that are not there come last.
    found = np.sort(np.where(there, times[np.clip(at, 0, len(times) - 1)], np.inf), axis=1)
    count, rows = there.sum(axis=1), np.arange(len(suspect))
    low, middle, high = (found[rows, np.maximum(count * k // 4 - 1, 0)] for k in (1, 2, 3))
    enough = count >= _FEWEST
    low, high = np.where(enough, low, 0.0), np.where(enough, high, 0.0)
    return np.where(enough, middle, np.inf), high - low


def _median(values):
    return np.partition(values, len(values) // 2)[len(values) // 2]
