"""Alarms for the cell, each with its numbers and what can be done."""

from peg_on_hole_ros.options import MonitorOptions
from peg_on_hole_ros.records import CONTACTS, Alarm

OK, WARN, ERROR = 0, 1, 2
# From here on the six equations' reactions are numbers to trust, a quarter of those frictionless.
SAFE_DETERMINANT = 0.25

# What each level says, for K, B1 and B2 where one of them is meant: built once, chosen often.
NO_JAMMING = "nothing jams the peg ahead"
# By cause, WARN and ERROR; the first is chosen where the mechanics shows that slip removes it.
WEDGING_SLIP = (
    "the peg nears the tilt at which friction wedges it: turn it about its axis as it closes, "
    "slip takes the singularity away",
    "the peg wedges, or is about to: stop pushing, reverse the tilt, and turn it about its axis "
    "as it closes again, slip takes the singularity away",
)
WEDGING = (
    "the peg nears the tilt at which friction wedges it, and turning does not help: close with "
    "less friction, or from another tilt",
    "the peg wedges, or is about to: stop pushing and reverse the tilt",
)
STALL = (
    "the push grows and the motion dies: reduce the force on the peg, or turn it about its axis",
    "the peg stalls against friction: stop pushing, reverse, and try again with less force or "
    "with slip",
)
LOAD = (
    "a contact's load nears its limit: reduce the force",
    "a contact's load passes its limit, or is about to: reduce the force, or reverse",
)
IN_HOLE = (
    "in the hole the load leaves what slides, by Whitney's diagram: push along the hole, take "
    "side force and moment away",
    "the peg is stuck in the hole: stop pushing, take side force and moment away, pull back",
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
_RISK_NAMES = (
    "jamming_wedging", "jamming_stall", "jamming_load", "jamming_risk", "determinant",
    "determinant_with_slip", "insertion_ratio", "whitney_margin",
)  # fmt: skip
_OPEN_NAMES = tuple(f"open_probability_{c}" for c in CONTACTS)
_NORMAL_NAMES = tuple(f"normal_{c}" for c in CONTACTS)
_LIMIT_NAMES = tuple(f"max_normal_{c}" for c in CONTACTS)


def jamming_cause(risk) -> tuple[str, str]:
    """Return what is said of a risk at WARN and at ERROR: its likeliest cause, and the remedy."""
    if risk.load >= max(risk.wedging, risk.stall):
        return LOAD
    if risk.insertion:
        return IN_HOLE
    if risk.stall > risk.wedging:
        return STALL
    return WEDGING_SLIP if risk.with_slip > SAFE_DETERMINANT else WEDGING


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
        self._cause = STALL
        self._jamming = Level(o.jamming_warn, o.jamming_error, o)
        self._loss = Level(0.5, 0.99, o)
        self._overload = Level(0.8, 1.0, o)

    def update(self, t, mode, risk, lost, normal) -> tuple[Alarm, ...]:
        """
        Return the three alarms.

        Parameters
        ----------
        t : float
            [s].
        mode : str
            Contact mode.
        risk : Risk
            Of jamming, with its causes.
        lost : sequence of 3 float
            Probability that K, B1, B2 alone has opened.
        normal : sequence of 3 float
            Reactions [N].

        """
        level = self._jamming.update(t, risk.risk)
        if risk.risk >= self.options.jamming_warn:
            # The cause is kept while the alarm is held.
            self._cause = jamming_cause(risk)
        text = self._cause[level - 1] if level else NO_JAMMING
        jamming = Alarm("jamming", level, text, tuple(zip(_RISK_NAMES, risk)))
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
