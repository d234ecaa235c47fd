"""Repeated: a driver sends one value several times under fresh stamps, or stands still."""

from math import sqrt

from peg_on_hole_ros.measurements.angles import turn_between
from peg_on_hole_ros.measurements.freshness import Oriented
from peg_on_hole_ros.measurements.repeats import Repeats, describe, held, notice
from peg_on_hole_ros.measurements.tuned import REPEATED_VALUES, STANDING_WRENCH
from peg_on_hole_ros.measurements.wrench_noise.received import Received
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.typed_record import Floats, Record, Vector6


class Repeated(Record):
    """
    How often the values of the wrench come.

    Attributes
    ----------
    repeats : Repeats
    latest : shape (6,)
        The latest wrench as received [N], [N m].
    begun
        Stamp of the first wrench [s].
    longest, usual
        The two longest runs of one value that have ended, but for those that stood still
        [wrenches]: a driver that repeats values does so more than once.
    held_since : Oriented
        Orientation at which the present value came first.
    turned_away : bool
        Whether the peg has turned while the value stayed.
    pauses : bool
        Whether the value has come so often that it is no measurement.
    off_ns
        Stamp of the last wrench that was not used [ns].
    stood_still, stood_from : float
        The longest time for which a value was reported as standing still [s], and its first
        stamp [s].
    all_zero : bool
        Whether that value was zero in every component.

    """

    repeats: Repeats
    latest: Vector6
    begun: float
    longest: int
    usual: int
    held_since: Oriented
    turned_away: bool
    pauses: bool
    off_ns: int
    stood_still: float
    stood_from: float
    all_zero: bool


@compiled
def forget(state: Repeated) -> None:
    """Forget the stamp alone: a driver repeats values in every motion alike."""
    state.off_ns = 0


@compiled
def follow(state: Repeated, received: Received) -> None:
    """
    Process a wrench, see the package.

    A sensor has noise, so one value that stays in all six components is no measurement, unless
    this sensor usually repeats values for as long. While the peg turns it is none much sooner.
    """
    t, repeats = received.t_ns * 1e-9, state.repeats
    if repeats.run == 0:
        state.begun = t
    ended, lasted = repeats.run, t - repeats.since
    if notice(repeats, t, received.values, state.latest) == 1:
        if not (state.pauses and lasted > STANDING_WRENCH.reported):
            _note_run(state, ended)
        state.held_since = received.oriented
        state.turned_away = state.pauses = False
        return
    seconds = t - repeats.since
    if not state.turned_away and seconds > REPEATED_VALUES.reported:
        now, then = received.oriented, state.held_since
        noise = REPEATED_VALUES.turned * sqrt(now.variance + then.variance)
        one_by_one = held(repeats) == 1 and then.variance > 0.0
        if one_by_one and turn_between(now.q, then.q) > noise:
            state.turned_away = True
    few = max(STANDING_WRENCH.fewest, STANDING_WRENCH.longer * state.usual)
    state.pauses = repeats.run > few
    if is_off(state):
        state.off_ns = received.t_ns
    reported = state.pauses and seconds > STANDING_WRENCH.reported
    if (state.turned_away or reported) and seconds > state.stood_still:
        state.stood_still, state.stood_from = seconds, repeats.since
        state.all_zero = True
        for i in range(6):
            state.all_zero = state.all_zero and state.latest[i] == 0.0


@compiled
def _note_run(state: Repeated, ended: int) -> None:
    """Note how often a value has come in a row that ended."""
    if ended > state.longest:
        state.longest, state.usual = ended, state.longest
    elif ended > state.usual:
        state.usual = ended


@compiled
def is_news(state: Repeated) -> bool:
    """Return whether the last wrench differs from the one before it."""
    return state.repeats.run == 1


@compiled
def factor(state: Repeated) -> float:
    """Return of how many messages each value is one: n of them inform as much as one does."""
    return float(held(state.repeats))


@compiled
def is_off(state: Repeated) -> bool:
    """Return whether the wrench stands still."""
    return state.turned_away or state.pauses


def causes(state: Repeated, variance: Floats) -> list[str]:
    """Return what is reported to a user, a line each."""
    lines = []
    if repeats := describe(state.repeats):
        lines.append(f"wrench: {repeats}")
    if state.stood_still > 0.0:
        zero = " (all six components are zero)" if state.all_zero else ""
        lines.append(
            f"wrench: wrenches that do not change for {state.stood_still:.2f} s, from "
            f"{state.stood_from - state.begun:.3f} s after the first on{zero}: the sensor or its "
            "driver stands still, as in an emergency stop, a reconnect or a start; they are not "
            "used, and no setting is tested by them"
        )
    return lines
