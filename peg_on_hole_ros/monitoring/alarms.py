"""Alarms for the cell, each with its numbers and what can be done."""

from peg_on_hole_ros.monitoring.mode import normal_probability
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
    """A level that rises at its thresholds and falls only a hysteresis below them."""

    def __init__(self, warn: float, error: float, hysteresis: float):
        self.thresholds = (warn, error)
        self.hysteresis = hysteresis
        self.level = OK

    def update(self, value: float) -> int:
        """Take a value and return the level."""
        for level, threshold in ((WARN, self.thresholds[0]), (ERROR, self.thresholds[1])):
            if value >= threshold:
                self.level = max(self.level, level)
            elif value < threshold - self.hysteresis and self.level >= level:
                self.level = level - 1
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
        self._jamming = Level(o.jamming_warn, o.jamming_error, o.alarm_hysteresis)
        self._loss = Level(0.5, 0.99, o.alarm_hysteresis)
        self._overload = Level(0.8, 1.0, o.alarm_hysteresis)

    def update(self, mode, risk, determinant, normal, normal_stddev) -> tuple[Alarm, ...]:
        """
        Return the three alarms.

        Parameters
        ----------
        mode : str
            Contact mode.
        risk, determinant : float or None
            Jamming risk and the normalised determinant; None where they do not exist.
        normal, normal_stddev : sequence of 3 float
            Reactions [N].

        """
        in_contact = mode == "three_point"
        level = self._jamming.update(risk if risk is not None else 0.0)
        values = () if risk is None else (("jamming_risk", risk), ("determinant", determinant))
        jamming = Alarm("jamming", level, JAMMING[level], values)
        if not in_contact:
            level = self._loss.update(0.0)
            loss = Alarm("contact_loss", level, CONTACT_LOSS[level][0], ())
            level = self._overload.update(0.0)
            return jamming, loss, Alarm("overload", level, OVERLOAD[level][0], ())

        lost = [normal_probability(-n / max(s, 1e-9)) for n, s in zip(normal, normal_stddev)]
        highest = max(lost)
        level = self._loss.update(highest)
        text = CONTACT_LOSS[level][lost.index(highest)]
        loss = Alarm("contact_loss", level, text, tuple(zip(_OPEN_NAMES, lost)))

        load = [n / limit for n, limit in zip(normal, self.options.max_normal)]
        highest = max(load)
        level = self._overload.update(highest)
        text = OVERLOAD[level][load.index(highest)]
        values = (*zip(_NORMAL_NAMES, normal), *self._limits)
        return jamming, loss, Alarm("overload", level, text, values)
