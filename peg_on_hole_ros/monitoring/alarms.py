"""Alarms for the cell, each with its numbers and what can be done."""

from peg_on_hole_ros.options import MonitorOptions
from peg_on_hole_ros.records import CONTACTS, Alarm

OK, WARN, ERROR = 0, 1, 2

# What each level says, for K, B1 and B2 where one of them is meant: built once, chosen often.
JAMMING = (
    "no wedging ahead",
    "friction nears the value at which the peg wedges: add slip, or close more slowly",
    "the peg is wedged, or is about to: reverse, or turn the peg about its axis",
)
CONTACT_LOSS = (
    ("no contact is being lost",) * 3,
    tuple(f"contact {c} opens: press the peg on, or tilt it less" for c in CONTACTS),
    tuple(f"contact {c} is open: the peg no longer rests on three points" for c in CONTACTS),
)
OVERLOAD = (
    ("every contact is within its allowed load",) * 3,
    tuple(f"contact {c} nears its allowed load: reduce the force" for c in CONTACTS),
    tuple(
        f"contact {c} is over its allowed load: reverse, and reduce the force" for c in CONTACTS
    ),
)
_OPEN_NAMES = tuple(f"open_probability_{c}" for c in CONTACTS)
_NORMAL_NAMES = tuple(f"normal_{c}" for c in CONTACTS)
_LIMIT_NAMES = tuple(f"max_normal_{c}" for c in CONTACTS)


class Level:
    """
    A level with hysteresis in value and in time.

    It rises once a value has been at its threshold for `dwell`, and falls by one once the value
    has been a hysteresis below the threshold for `hold`: one bad sample neither raises nor clears.
    """

    def __init__(self, warn: float, error: float, options: MonitorOptions):
        self.thresholds = (warn, error)
        self.hysteresis = options.alarm_hysteresis
        self.dwell, self.hold = options.alarm_dwell, options.alarm_hold
        self.level = OK
        self._above: list[float | None] = [None, None]
        self._below: float | None = None

    def update(self, t: float, value: float) -> int:
        """Take a value at a time [s] and return the level."""
        for i, threshold in enumerate(self.thresholds):
            if value < threshold:
                self._above[i] = None
            elif self._above[i] is None:
                self._above[i] = t
            if self._above[i] is not None and t - self._above[i] >= self.dwell:
                self.level = max(self.level, i + 1)
        if self.level == OK or value >= self.thresholds[self.level - 1] - self.hysteresis:
            self._below = None
        elif self._below is None:
            self._below = t
        elif t - self._below >= self.hold:
            self.level -= 1
            self._below = t
        return self.level


class Alarms:
    """The alarms `jamming`, `contact_loss` and `overload`."""

    def __init__(self, options: MonitorOptions):
        self.options = options
        self._limits = tuple(zip(_LIMIT_NAMES, map(float, options.max_normal)))
        self.restart()

    def restart(self):
        """Clear every alarm."""
        o = self.options
        self._jamming = Level(o.jamming_warn, o.jamming_error, o)
        self._loss = Level(0.5, 0.99, o)
        self._overload = Level(0.8, 1.0, o)

    def update(self, t, mode, risk, determinant, lost, normal) -> tuple[Alarm, ...]:
        """
        Return the three alarms.

        Parameters
        ----------
        t : float
            [s].
        mode : str
            Contact mode.
        risk, determinant : float or None
            Jamming risk and the normalised determinant; None where they do not exist.
        lost : sequence of 3 float
            Probability that K, B1, B2 alone has opened.
        normal : sequence of 3 float
            Reactions [N].

        """
        level = self._jamming.update(t, risk if risk is not None else 0.0)
        values = () if risk is None else (("jamming_risk", risk), ("determinant", determinant))
        jamming = Alarm("jamming", level, JAMMING[level], values)
        highest = max(lost)
        level = self._loss.update(t, highest)
        text = CONTACT_LOSS[level][lost.index(highest)]
        loss = Alarm("contact_loss", level, text, tuple(zip(_OPEN_NAMES, lost)))

        if mode != "three_point":
            level = self._overload.update(t, 0.0)
            return jamming, loss, Alarm("overload", level, OVERLOAD[level][0], ())
        load = [n / limit for n, limit in zip(normal, self.options.max_normal)]
        highest = max(load)
        level = self._overload.update(t, highest)
        text = OVERLOAD[level][load.index(highest)]
        values = (*zip(_NORMAL_NAMES, normal), *self._limits)
        return jamming, loss, Alarm("overload", level, text, values)
