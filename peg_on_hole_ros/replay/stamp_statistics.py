"""Statistics of the stamps of a recorded topic, and what of them is trouble."""

import math
from copy import deepcopy

import numpy as np

from peg_on_hole_ros.replay.by_stamp import ByStamp

# Log time against stamp: farther apart than a transport takes, two clocks differ.
OFFSET_LIMIT = 1.0  # [s]
# Stamps against log times: faster or slower than any playback that was recorded anew.
_PACE = 50.0
_PACE_FROM = 0.5  # [s]
_RESERVOIR = 4096


class StampStatistics:
    """
    Collects stamps in the order of a bag, in bounded memory.

    Parameters
    ----------
    max_gap : float
        Silence above which it counts as a gap [s].

    Attributes
    ----------
    span : tuple of int or None
        Least and greatest stamp [ns]; None: no message yet.
    repeated : int
        Messages with the stamp of the one before.

    """

    def __init__(self, max_gap: float) -> None:
        self._max_gap_ns = round(max_gap * 1e9)
        self.span: tuple[int, int] | None = None
        self._logged: tuple[int, int] | None = None
        self._last: int | None = None
        self._count = self._backwards = self._zeros = 0
        self.repeated = 0
        self._by_stamp, self._periods = ByStamp(), _Periods(self._max_gap_ns)
        self._least, self._greatest, self._sum = math.inf, -math.inf, 0.0

    def add(self, t_ns: np.ndarray | int, log_ns: np.ndarray | int) -> None:
        """Count messages, in their order, by their stamps and their log times [ns]."""
        t_ns, log_ns = (np.atleast_1d(np.asarray(times, np.int64)) for times in (t_ns, log_ns))
        if not len(t_ns):
            return
        self.span = _widened(self.span, t_ns)
        self._logged = _widened(self._logged, log_ns)
        self._zeros += int((t_ns == 0).sum())
        offset = (log_ns - t_ns) * 1e-9
        self._least = min(self._least, float(offset.min()))
        self._greatest = max(self._greatest, float(offset.max()))
        self._sum += float(offset.sum())
        step = np.diff(t_ns, prepend=t_ns[0] - 1 if self._last is None else self._last)
        self._count += len(t_ns)
        self._last = int(t_ns[-1])
        self._backwards += int((step < 0).sum())
        self.repeated += int((step == 0).sum())
        in_order, _ = self._by_stamp.take(t_ns, np.empty((len(t_ns), 0)))
        self._periods.add(np.diff(in_order))

    def summary(self) -> dict:
        """Return counts, times in seconds, and in `trouble` what a user has to look at."""
        if not self._count:
            return {"stamps": 0, "trouble": []}
        periods = deepcopy(self._periods)
        periods.add(np.diff(self._by_stamp.rest[0]))
        return {
            "stamps": self._count,
            "median_period": periods.median,
            "gaps": {
                "limit": self._max_gap_ns * 1e-9,
                "count": periods.gaps,
                "longest": None if periods.longest is None else periods.longest * 1e-9,
            },
            "backwards": self._backwards,
            "repeated": self.repeated,
            "log_minus_stamp": {
                "least": self._least,
                "greatest": self._greatest,
                "mean": self._sum / self._count,
            },
            "trouble": self._trouble(periods.gaps),
        }

    def _trouble(self, gaps):
        trouble = []
        if self._backwards:
            trouble.append(
                f"{self._backwards} stamps go backwards: what is later than filter.late_window is "
                "dropped; a driver without time order, or two publishers on one topic"
            )
        if self.repeated:
            trouble.append(
                f"{self.repeated} stamps repeat the one before: a replay uses the first; a "
                "driver that stamps in whole milliseconds, or sends twice"
            )
        if gaps:
            trouble.append(
                f"{gaps} gaps over {self._max_gap_ns * 1e-9:g} s (filter.max_gap): over one "
                "of the wrench the peg is predicted without contact, over one of the joint "
                "states it is not corrected"
            )
        stamped, logged = ((b - a) * 1e-9 for a, b in (self.span, self._logged))
        if (
            self._count > 2
            and min(stamped, logged) > 0.0
            and max(stamped, logged) > max(_PACE_FROM, _PACE * min(stamped, logged))
        ):
            trouble.append(
                f"stamps advance by {stamped:.6g} s while {logged:.6g} s were recorded: the "
                "driver's clock counts in another unit (a stamp has seconds and nanoseconds), or "
                "jumps"
            )
        if max(abs(self._least), abs(self._greatest)) > OFFSET_LIMIT:
            trouble.append(
                f"log time and stamp differ by {self._least:.3f} to {self._greatest:.3f} s: the "
                "clocks of driver and recorder are not the same; only stamps are used"
            )
        if self._zeros:
            trouble.append(f"{self._zeros} stamps are zero: the driver does not set them")
        return trouble


class _Periods:
    """From one stamp to the next: a sample of them, gaps, and the longest [ns]."""

    def __init__(self, max_gap_ns):
        self._max_gap_ns, self.gaps, self.longest = max_gap_ns, 0, None
        self._some, self._stride, self._count = [], 1, 0

    def __len__(self):
        return len(self._some)

    def add(self, period):
        if not len(period):
            return
        number = self._count + np.arange(len(period))
        self._count += len(period)
        self.gaps += int((period > self._max_gap_ns).sum())
        longest = int(period.max())
        self.longest = longest if self.longest is None else max(self.longest, longest)
        self._some += period[number % self._stride == 0].tolist()
        while len(self._some) >= _RESERVOIR:
            # Every second one is kept, and of those to come as well.
            del self._some[1::2]
            self._stride *= 2

    @property
    def median(self):
        forward = sorted(period for period in self._some if period > 0)
        return forward[len(forward) // 2] * 1e-9 if forward else None


def _widened(span, times):
    first, last = int(times.min()), int(times.max())
    return (first, last) if span is None else (min(span[0], first), max(span[1], last))
