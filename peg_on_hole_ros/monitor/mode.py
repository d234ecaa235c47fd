"""The contact mode that is declared, with dwell and hysteresis, and when contact came and went."""

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.evidence import Shown
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.monitor.states import Mode, Touch
from peg_on_hole_ros.monitor.tuned import MODE_DWELL
from peg_on_hole_ros.typed_record import Record


class DeclaredMode(Record):
    """
    The contact mode, and what it was declared by.

    Attributes
    ----------
    mode : Mode
        As declared.
    candidate : Mode
        Which waits for its dwell.
    candidate_since : float
        Since when it does [s].
    weighed : Mode
        Which wrenches are weighed with: the mode, or what it may become.
    refuted : bool
        Whether orientations have refuted the motion since the mode was declared.
    three_point_tried : bool
        Whether wrenches are weighed with three contacts beside the mode.
    touch : Touch
        As declared.
    last_free, last_touch : float
        When the evidence for air, and that for contact, was strong last [s].
    touch_change : Touch
        Whether contact came last, or went.
    touch_changed, touch_latency : float
        When it did, and from there until it was declared [s].

    """

    mode: Mode
    candidate: Mode
    candidate_since: float
    weighed: Mode
    refuted: bool
    three_point_tried: bool
    touch: Touch
    last_free: float
    last_touch: float
    touch_change: Touch
    touch_changed: float
    touch_latency: float


@compiled
def forget_mode(declared: DeclaredMode) -> None:
    """Forget all evidence."""
    declared.mode = declared.candidate = declared.weighed = Mode.UNKNOWN
    declared.candidate_since = declared.last_free = declared.last_touch = 0.0
    declared.touch = declared.touch_change = Touch.UNKNOWN
    declared.refuted = declared.three_point_tried = False


@compiled
def probability_of(shown: Shown, mode: Mode) -> float:
    """Return the probability of a mode."""
    if mode == Mode.THREE_POINT:
        return shown.three_point + shown.stuck
    if mode == Mode.TWO_POINT:
        return shown.two_point
    if mode == Mode.ELSEWHERE:
        return shown.elsewhere
    return shown.free if mode == Mode.OPEN else shown.opened + shown.other


@compiled
def likeliest(shown: Shown) -> Mode:
    """Return the likeliest mode; of those as likely as each other, the first."""
    best = Mode.THREE_POINT
    for mode in (Mode.TWO_POINT, Mode.OPEN, Mode.UNKNOWN, Mode.ELSEWHERE):
        if probability_of(shown, mode) > probability_of(shown, best):
            best = mode
    return best


@compiled
def declare_mode(
    declared: DeclaredMode, settings: MonitorSettings, t: float, shown: Shown
) -> None:
    """
    Process the probabilities at a time.

    A mode is declared once it is probable enough for a while, and kept until it no longer is.

    Parameters
    ----------
    declared : DeclaredMode
        Changed.
    settings : MonitorSettings
    t : float
        [s].
    shown : Shown

    """
    best = likeliest(shown)
    if probability_of(shown, best) < settings.mode_probability_on:
        kept = probability_of(shown, declared.weighed) >= settings.mode_probability_off
        best = declared.weighed if kept else Mode.UNKNOWN
    if best != declared.candidate:
        declared.candidate, declared.candidate_since = best, t
    waited = t - declared.candidate_since
    if best != declared.weighed and waited >= settings.mode_dwell:
        declared.weighed = best
    dwell = (
        max(settings.mode_dwell, MODE_DWELL.confirmed) if declared.refuted else settings.mode_dwell
    )
    if best != declared.mode and waited >= dwell:
        declared.mode, declared.refuted = best, False
    _follow_touch(declared, settings, t, shown.free)


@compiled
def _follow_touch(
    declared: DeclaredMode, settings: MonitorSettings, t: float, free: float
) -> None:
    # Evidence for the other side begins where that for this side was last strong.
    certain = 1.0 - settings.mode_probability_on
    if free >= 1.0 - certain:
        declared.last_free = t
    if free <= certain:
        declared.last_touch = t
    if declared.touch == Touch.UNKNOWN:
        if declared.mode != Mode.UNKNOWN:
            declared.touch = Touch.TOUCHING if free <= 0.5 else Touch.APART
    elif declared.touch == Touch.TOUCHING and declared.mode == Mode.OPEN:
        declared.touch = declared.touch_change = Touch.APART
        declared.touch_changed = declared.last_touch
        declared.touch_latency = t - declared.last_touch
    elif declared.touch == Touch.APART and free <= certain and declared.mode != Mode.OPEN:
        declared.touch = declared.touch_change = Touch.TOUCHING
        declared.touch_changed = declared.last_free
        declared.touch_latency = t - declared.last_free
