"""Statistics of one topic's stamps: period, gaps, order, distance from the recorder's clock."""

import math

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

    def __init__(self, max_gap: float):
        self._max_gap_ns = round(max_gap * 1e9)
        self.span: tuple[int, int] | None = None
        self._logged: tuple[int, int] | None = None
        self._last: int | None = None
        self._count = self._backwards = self._gaps = self._zeros = 0
        self.repeated = 0
        self._longest: int | None = None
        self._periods: list[int] = []
        self._stride = 1
        self._least, self._greatest, self._sum = math.inf, -math.inf, 0.0

    def add(self, t_ns: int, log_ns: int) -> None:
        """Count one message by its stamp and its log time [ns]."""
        least, greatest = self.span or (t_ns, t_ns)
        self.span = min(least, t_ns), max(greatest, t_ns)
        least, greatest = self._logged or (log_ns, log_ns)
        self._logged = min(least, log_ns), max(greatest, log_ns)
        self._count += 1
        self._zeros += t_ns == 0
        offset = (log_ns - t_ns) * 1e-9
        self._least, self._greatest = min(self._least, offset), max(self._greatest, offset)
        self._sum += offset
        if self._last is not None:
            period = t_ns - self._last
            self._backwards += period < 0
            self.repeated += period == 0
            self._gaps += period > self._max_gap_ns
            self._longest = period if self._longest is None else max(self._longest, period)
            if self._count % self._stride == 0:
                self._periods.append(period)
                if len(self._periods) == _RESERVOIR:
                    # Every second one is kept, and of those to come as well.
                    del self._periods[::2]
                    self._stride *= 2
        self._last = t_ns

    def summary(self) -> dict:
        """Return counts, times in seconds, and in `trouble` what a user has to look at."""
        if not self._count:
            return {"stamps": 0, "trouble": []}
        return {
            "stamps": self._count,
            "median_period": self._median(),
            "gaps": {
                "limit": self._max_gap_ns * 1e-9,
                "count": self._gaps,
                "longest": None if self._longest is None else self._longest * 1e-9,
            },
            "backwards": self._backwards,
            "repeated": self.repeated,
            "log_minus_stamp": {
                "least": self._least,
                "greatest": self._greatest,
                "mean": self._sum / self._count,
            },
            "trouble": self._trouble(),
        }

    def _median(self):
        forward = sorted(period for period in self._periods if period > 0)
        return forward[len(forward) // 2] * 1e-9 if forward else None

    def _trouble(self):
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
        if self._gaps:
            trouble.append(
                f"{self._gaps} gaps over {self._max_gap_ns * 1e-9:g} s (filter.max_gap): over one "
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
