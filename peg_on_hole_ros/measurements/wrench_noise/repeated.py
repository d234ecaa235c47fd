"""Repeated: a driver sends one value several times under fresh stamps, or stands still."""

from math import sqrt

from peg_on_hole_ros.measurements.angles import turn_between
from peg_on_hole_ros.measurements.freshness import Oriented
from peg_on_hole_ros.measurements.repeats import Repeats, describe, held, notice
from peg_on_hole_ros.measurements.tuned import REPEATED_VALUES
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
    stands_still : bool
        Whether the peg has turned while the value stayed.
    stood_still : float
        The longest time for which it did [s].

    """

    repeats: Repeats
    latest: Vector6
    held_since: Oriented
    stands_still: bool
    stood_still: float


@compiled
def forget(state: Repeated) -> None:
    """Forget nothing: a driver repeats values in every motion alike."""


@compiled
def follow(state: Repeated, received: Received) -> None:
    """
    Process a wrench, see the package.

    At rest, and without noise, one value is true for long; while the peg turns it is not.
    """
    t = received.t_ns * 1e-9
    if notice(state.repeats, t, received.values, state.latest) == 1:
        state.held_since = received.oriented
        state.stands_still = False
    elif not state.stands_still and t - state.repeats.since > REPEATED_VALUES.reported:
        now, then = received.oriented, state.held_since
        noise = REPEATED_VALUES.turned * sqrt(now.variance + then.variance)
        one_by_one = held(state.repeats) == 1 and then.variance > 0.0
        if one_by_one and turn_between(now.q, then.q) > noise:
            state.stands_still = True
    if state.stands_still:
        state.stood_still = max(state.stood_still, t - state.repeats.since)


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
    """Return whether the wrench stands still while the peg turns."""
    return state.stands_still


def causes(state: Repeated, variance: Floats) -> list[str]:
    """Return what is reported to a user: a line, or none."""
    if repeats := describe(state.repeats):
        return [f"wrench: {repeats}"]
    if state.stood_still <= REPEATED_VALUES.reported:
        return []
    return [
        f"wrench: wrenches that do not change for {state.stood_still:.2f} s while the peg "
        "turns: the sensor or its driver stands still; they are not used"
    ]
