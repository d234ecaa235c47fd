"""Alarms for the cell, each with its numbers and what can be done."""

from peg_on_hole_ros.monitoring.mode import normal_probability
from peg_on_hole_ros.options import MonitorOptions
from peg_on_hole_ros.records import CONTACTS, Alarm

OK, WARN, ERROR = 0, 1, 2


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
        text = (
            "no wedging ahead",
            "friction nears the value at which the peg wedges: add slip, or close more slowly",
            "the peg is wedged, or is about to: reverse, or turn the peg about its axis",
        )[level]
        jamming = Alarm("jamming", level, text, tuple(values))

        lost = [normal_probability(-n / max(s, 1e-9)) for n, s in zip(normal, normal_stddev)]
        worst = max(range(3), key=lambda i: lost[i])
        level = self._loss.update(lost[worst] if in_contact else 0.0)
        text = (
            "no contact is being lost",
            f"contact {CONTACTS[worst]} opens: press the peg on, or tilt it less",
            f"contact {CONTACTS[worst]} is open: the peg no longer rests on three points",
        )[level]
        values = tuple((f"open_probability_{c}", p) for c, p in zip(CONTACTS, lost))
        loss = Alarm("contact_loss", level, text, values if in_contact else ())

        limits = self.options.max_normal
        load = [n / limit for n, limit in zip(normal, limits)]
        worst = max(range(3), key=lambda i: load[i])
        level = self._overload.update(load[worst] if in_contact else 0.0)
        text = (
            "every contact is within its allowed load",
            f"contact {CONTACTS[worst]} nears its allowed load: reduce the force",
            f"contact {CONTACTS[worst]} is over its allowed load: reverse, and reduce the force",
        )[level]
        values = tuple((f"normal_{c}", float(n)) for c, n in zip(CONTACTS, normal))
        limit_values = tuple((f"max_normal_{c}", float(x)) for c, x in zip(CONTACTS, limits))
        overload = Alarm("overload", level, text, values + limit_values if in_contact else ())
        return jamming, loss, overload
