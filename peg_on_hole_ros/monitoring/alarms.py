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
# OK, WARN, ERROR; K, B1 or B2 where it is known which, then any of them, then the whole peg.
_LOST_WHICH = tuple(f"contact {c}" for c in CONTACTS)
CONTACT_LOSS = (
    ("no contact is being lost",) * 5,
    (
        *(f"{c} opens: press the peg on, or tilt it less" for c in _LOST_WHICH),
        "a contact opens: press the peg on, or tilt it less",
        "the peg leaves the rim: press it on, or let the program go on without contact",
    ),
    (
        *(f"{c} is open: press the peg on, or tilt it less" for c in _LOST_WHICH),
        "a contact is open, the peg no longer rests on three points: press it on, or begin anew",
        "the peg has left the rim: begin anew from free air, or press it on",
    ),
)
_ANY, _ALL = 3, 4
OVERLOAD = (
    ("every contact is within its allowed load",) * 3,
    tuple(f"contact {c} nears its allowed load: reduce the force" for c in CONTACTS),
    tuple(
        f"contact {c} is over its allowed load, or is about to be: reduce the force, or reverse"
        for c in CONTACTS
    ),
)
# Before what an alarm said, while it is held without a value at its threshold.
HELD = "no longer above its threshold, and held for a while; it was: "
_RISK_NAMES = ("jamming_wedging", "jamming_stall", "jamming_load", "jamming_risk")
_ABOVE_NAMES = (*_RISK_NAMES, "determinant", "determinant_with_slip")
_HOLE_NAMES = (*_RISK_NAMES, "insertion_ratio", "whitney_margin")
_LOSS_NAMES = (
    *(f"open_probability_{c}" for c in CONTACTS), "opened_probability", "free_probability",
)  # fmt: skip
_LOAD_NAMES = (
    "jamming_load", *(f"normal_{c}" for c in CONTACTS), *(f"max_normal_{c}" for c in CONTACTS),
)  # fmt: skip
_LOSS_WARN, _LOSS_ERROR = 0.5, 0.95
# A peg has rested on three contacts once that has been the mode for so long [s].
_RESTED = 0.05
# One contact is named if it holds this share of the probability that any has opened.
_CLEARLY = 0.7
# A contact that opens sooner than so before gamma0 [s] opens on the way into the hole.
_ENTERING = 0.03


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
        self.retune(warn, error, options)
        self.level = OK
        # Since when each threshold has been passed, and since when the level has had no cause.
        self._warns: float | None = None
        self._errs: float | None = None
        self._below: float | None = None

    def retune(self, warn: float, error: float, options: MonitorOptions):
        """Take other thresholds and times from here on."""
        self.thresholds = (warn, error)
        self.hysteresis = options.alarm_hysteresis
        self.dwell, self.hold = options.alarm_dwell, options.alarm_hold
        self._lowest = min(warn, error)

    @property
    def has_cause(self) -> bool:
        """Whether the last value was at the level's threshold, or a first: else it is held."""
        if self.level == ERROR:
            return self._errs is not None
        return self._warns is not None or self._errs is not None

    def update(self, t: float, value: float) -> int:
        """Take a value at a time [s] and return the level."""
        if self.level == OK and value < self._lowest:
            self._warns = self._errs = None
            return OK
        warn, error = self.thresholds
        self._warns = _since(self._warns, value >= warn, t)
        self._errs = _since(self._errs, value >= error, t)
        if self._errs is not None and t - self._errs >= self.dwell:
            self.level = ERROR
        elif self._warns is not None and t - self._warns >= self.dwell:
            self.level = max(self.level, WARN)
        if self.level == OK or value >= self.thresholds[self.level - 1] - self.hysteresis:
            self._below = None
        elif self._below is None:
            self._below = t
        elif t - self._below >= self.hold:
            self.level -= 1
            self._below = t
        return self.level


def _since(begun, holds, t):
    """Return since when something holds, None if it does not."""
    if not holds:
        return None
    return t if begun is None else begun


def _said(level, text):
    """Return what is said at a level, as past where it is held without a cause."""
    return HELD + text if level.level and not level.has_cause else text


class Alarms:
    """
    The alarms `jamming`, `contact_loss` and `overload`.

    While a level is held without a cause, the alarm says what its cause was.
    """

    def __init__(self, options: MonitorOptions):
        self.options = options
        self._limits = tuple(map(float, options.max_normal))
        self.restart()

    def retune(self, options: MonitorOptions):
        """Take other thresholds and times from here on; a level stays until they change it."""
        self.options = options
        self._limits = tuple(map(float, options.max_normal))
        for level in (self._jamming, self._loss, self._overload):
            warn_error = level.thresholds
            if level is not self._loss:
                warn_error = options.jamming_warn, options.jamming_error
            level.retune(*warn_error, options)

    def restart(self):
        """Clear every alarm."""
        o = self.options
        self._cause = STALL
        self._jamming = Level(o.jamming_warn, o.jamming_error, o)
        self._loss = Level(_LOSS_WARN, _LOSS_ERROR, o)
        self._overload = Level(o.jamming_warn, o.jamming_error, o)
        self._rested = False
        self._resting: float | None = None
        self._aloft: float | None = None
        self._risk: tuple[tuple, tuple] = (), ()
        # Which contact was at fault, and the numbers, when a level last had a cause.
        self._lost: tuple[int, tuple] = _ALL, ()
        self._loaded: tuple[int, tuple] = 0, ()

    def update(self, t, mode, risk, shown, normal) -> tuple[Alarm, ...]:
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
        shown : Shown
            Probabilities of the contacts, and the time to gamma0.
        normal : sequence of 3 float
            Reactions [N].

        """
        level = self._jamming.update(t, risk.risk)
        if self._jamming.has_cause:
            # The cause is kept while the alarm is held.
            self._cause = jamming_cause(risk)
        text = _said(self._jamming, self._cause[level - 1] if level else NO_JAMMING)
        causes = risk.wedging, risk.stall, risk.load, risk.risk
        if risk.insertion:
            names, numbers = _HOLE_NAMES, (*causes, risk.insertion, risk.margin)
        else:
            names, numbers = _ABOVE_NAMES, (*causes, risk.determinant, risk.with_slip)
        if not level or self._jamming.has_cause:
            self._risk = names, numbers
        # What it was is told with the numbers that it had.
        names, numbers = self._risk
        jamming = Alarm("jamming", level, text, names, numbers)
        return jamming, self._contact_loss(t, mode, shown), self._over(t, mode, risk, normal)

    def _over(self, t, mode, risk, normal):
        """Return the alarm: the load of a contact passes its limit."""
        there = mode == "three_point"
        level = self._overload.update(t, risk.load if there else 0.0)
        numbers = (risk.load, *normal, *self._limits) if there else ()
        if self._overload.has_cause:
            self._loaded = int(risk.loaded), numbers
        which, numbers = self._loaded if level else (0, numbers)
        text = _said(self._overload, OVERLOAD[level][which])
        return Alarm("overload", level, text, _LOAD_NAMES if numbers else (), numbers)

    def _contact_loss(self, t, mode, shown):
        """Return the alarm: three contacts that were there are no longer, other than by entry."""
        if mode != "open":
            self._aloft = None
        elif self._aloft is None:
            self._aloft = t
        if mode != "three_point":
            self._resting = None
        elif self._resting is None:
            self._resting = t
        elif t - self._resting >= _RESTED:
            self._rested = True
        if mode == "two_point" or (self._aloft is not None and self._gone(t)):
            # In the hole, or in the air for long enough to be a state and no event.
            self._rested = False
        entering = 0.0 <= shown.time < _ENTERING
        # The reactions of a peg that jams are not determined, and say nothing of its contacts.
        jams = self._jamming.level and self._cause is not LOAD
        opened = 0.0 if entering or jams else shown.opened
        lost = shown.lost_K, shown.lost_B1, shown.lost_B2
        level = self._loss.update(t, opened + shown.free if self._rested else 0.0)
        numbers = (*lost, shown.opened, shown.free)
        if self._loss.has_cause:
            which = _ALL
            if opened > shown.free:
                which = lost.index(max(lost)) if max(lost) > _CLEARLY * opened else _ANY
            self._lost = which, numbers
        which, numbers = self._lost if level else (_ALL, numbers)
        text = _said(self._loss, CONTACT_LOSS[level][which])
        return Alarm("contact_loss", level, text, _LOSS_NAMES, numbers)

    def _gone(self, t):
        return t - self._aloft >= self.options.alarm_hold
