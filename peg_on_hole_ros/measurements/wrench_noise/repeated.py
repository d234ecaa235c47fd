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
    held_since : Oriented
        Orientation at which the present value came first.
    turned_away : bool
        Whether the peg has turned while the value stayed.
    loaded : bool
        Whether the wrench is of zeros that are not those of a free peg: a weight hangs there.
    longest, usual
        The two longest runs of one value that have ended, but for those that stood still
        [wrenches]: a driver that repeats values does so more than once.
    step : shape (6,)
        From one value to the next, at the last one that was new [N], [N m].
    restless : float
        Share of the latest new values whose steps turn back, as noise has it [-].
    dead : bool
        Whether the value has come so often that it is no measurement.
    zeros : bool
        Whether the value is zero in every component.
    off_ns
        Stamp of the last wrench that was not used [ns].

    """

    repeats: Repeats
    latest: Vector6
    held_since: Oriented
    turned_away: bool
    loaded: bool
    longest: int
    usual: int
    step: Vector6
    restless: float
    dead: bool
    zeros: bool
    off_ns: int


@compiled
def forget(state: Repeated) -> None:
    """Forget the stamp alone: a driver repeats values in every motion alike."""
    state.off_ns = 0


@compiled
def follow(state: Repeated, received: Received) -> None:
    """
    Process a wrench, see the package.

    At rest, and without noise, one value is true for long. While the peg turns it is not; nor is
    it of a sensor that has shown noise, nor are zeros where a weight hangs at the sensor.
    """
    t, repeats = received.t_ns * 1e-9, state.repeats
    ended, stood = repeats.run, is_off(state)
    _follow_noise(state, received)
    if notice(repeats, t, received.values, state.latest) == 1:
        if not stood:
            _note_run(state, ended)
        state.held_since = received.oriented
        state.turned_away = state.dead = False
        state.zeros = True
        for i in range(6):
            state.zeros = state.zeros and received.values[i] == 0.0
        return
    seconds = t - repeats.since
    if not state.turned_away and seconds > REPEATED_VALUES.reported:
        now, then = received.oriented, state.held_since
        noise = REPEATED_VALUES.turned * sqrt(now.variance + then.variance)
        one_by_one = held(repeats) == 1 and then.variance > 0.0
        if one_by_one and turn_between(now.q, then.q) > noise:
            state.turned_away = True
    noisy = state.restless > STANDING_WRENCH.noisy and seconds > STANDING_WRENCH.lasts
    many = repeats.run > max(STANDING_WRENCH.fewest, STANDING_WRENCH.longer * state.usual)
    state.dead = many and (noisy or state.loaded)
    if is_off(state):
        state.off_ns = received.t_ns


@compiled
def _follow_noise(state: Repeated, received: Received) -> None:
    """Note whether steps from value to value turn back: those of noise do two times in three."""
    turns, new = 0, False
    for i in range(6):
        step = received.values[i] - state.latest[i]
        change = step - state.step[i]
        least = STANDING_WRENCH.least_noise
        back = step * state.step[i] < 0.0
        turns += back and change * change > least * least * received.variance[i]
        new = new or step != 0.0
    if not new:
        return
    for i in range(6):
        state.step[i] = received.values[i] - state.latest[i]
    shown = 1.0 if turns >= STANDING_WRENCH.turns else 0.0
    state.restless += (shown - state.restless) / STANDING_WRENCH.kept


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
    """Return whether the wrench stands still: `diagnosis.suspected.standing_wrench` reports it."""
    return state.turned_away or state.dead


def causes(state: Repeated, variance: Floats) -> list[str]:
    """Return what is reported to a user: a line, or none."""
    repeats = describe(state.repeats)
    return [f"wrench: {repeats}"] if repeats else []
