"""Stall: friction stops a peg that is pushed on, by how its tilt follows the push, both ahead."""

from math import exp, sqrt

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.contact_probabilities import normal_cdf
from peg_on_hole_ros.monitor.dangers.situation import (
    Situation,
    horizon_on_rim,
    is_inside,
    on_rim,
)
from peg_on_hole_ros.monitor.trend import (
    Trend,
    begin,
    carry,
    carry_driven,
    correct,
    forget_trend,
)
from peg_on_hole_ros.monitor.tuned import STALL_AHEAD
from peg_on_hole_ros.typed_record import Record

ADVICE = (
    "the push grows while the motion stops: reduce the force on the peg, or turn it about its "
    "axis",
    "the peg stalls against friction: stop pushing, reverse, and try again with less force or "
    "with slip",
)
# A peg on a compliant holder slides where holder and friction balance: its tilt follows the
# holder's program, less what the holder gives way to the push, tilt = program + c push. The push
# is known a hundred times better than the tilt's rate, so c and the push's trend show when the
# closing ends. docs/jamming.md, "Stall", derives it.


class Stall(Record):
    """
    Whether friction stops the peg, and how the tilt follows the push.

    Attributes
    ----------
    probability : float
        Within the horizon; 0 in the hole.
    push : Trend
        Generalised force that closes the peg [N m].
    tilt : Trend
        Its rate is that of the holder's program, and what drives it is c: by how much the tilt
        changes with the push [rad], [rad/s], [rad/(N m)].
    last_push : float
        The push at the last orientation [N m].
    calm : float
        For how long neither has jumped [s].

    """

    probability: float
    push: Trend
    tilt: Trend
    last_push: float
    calm: float


@compiled
def forget(stall: Stall) -> None:
    """Begin anew with the next push and orientation."""
    forget_trend(stall.push)
    forget_trend(stall.tilt)
    stall.probability = stall.last_push = stall.calm = 0.0


@compiled
def assess(stall: Stall, situation: Situation) -> None:
    """Process a wrench, see the package."""
    moving, pushed, passed = situation.moving, situation.pushed, situation.passed
    measured, shown = situation.measured, situation.shown
    if pushed.taken:
        follow_push(stall, pushed.force, pushed.variance, pushed.held, passed.dt)
        if measured.since != 0.0:
            follow_tilt(
                stall, measured.tilt, measured.variance, pushed.held, measured.since, passed.since
            )
            measured.since = 0.0
    probability = 0.0
    # Before the peg has moved in contact nothing grows.
    if pushed.pushes > 0.0 and not is_inside(shown):
        ahead = horizon_on_rim(shown, situation.settings.jamming_horizon)
        stops = stops_ahead(stall, ahead, moving.rest_rate)
        probability = min(moving.closing * stops * pushed.grows + moving.rest * pushed.pushes, 1.0)
    stall.probability = on_rim(shown) * probability


@compiled
def follow_push(stall: Stall, push: float, variance: float, held: float, dt: float) -> None:
    """
    Process a push.

    Parameters
    ----------
    stall : Stall
        Changed.
    push, variance : float
        Generalised force that closes the peg [N m], and its variance.
    held : float
        What friction can hold [N m].
    dt : float
        Since the last push [s].

    """
    acceleration = held / (STALL_AHEAD.changes * STALL_AHEAD.changes)
    if stall.push.p00 == 0.0:
        begin(
            stall.push,
            push,
            variance,
            (held / STALL_AHEAD.changes) ** 2,
            acceleration * acceleration,
        )
        return
    carry(stall.push, dt, acceleration, STALL_AHEAD.memory, 0.0)
    stall.calm += dt
    if correct(
        stall.push, push - stall.push.value, variance, dt, acceleration, STALL_AHEAD.push_jump
    ):
        stall.calm = 0.0


@compiled
def follow_tilt(
    stall: Stall, tilt: float, variance: float, held: float, since: float, ago: float
) -> None:
    """
    Process an orientation, after the push.

    Parameters
    ----------
    stall, held
        As for `follow_push`.
    tilt, variance : float
        As measured [rad], [rad^2].
    since, ago : float
        After the last orientation (below zero: there was none), before the last push [s].

    """
    push = stall.push.value - ago * stall.push.rate
    grown = push - stall.last_push
    stall.last_push = push
    if stall.tilt.p00 == 0.0 or since < 0.0:
        begin(stall.tilt, tilt, variance, 1.0, (STALL_AHEAD.gives_way / held) ** 2)
        return
    carry_driven(stall.tilt, since, grown, STALL_AHEAD.program)
    # A tilt that jumped has another program.
    if correct(stall.tilt, tilt - stall.tilt.value, variance, since, 0.0, STALL_AHEAD.tilt_jump):
        stall.calm = 0.0


@compiled
def stops_ahead(stall: Stall, horizon: float, rest_rate: float) -> float:
    """Return the probability that the tilt stands still now or a horizon [s] ahead."""
    if stall.calm < STALL_AHEAD.calm:
        return 0.0
    push = stall.push
    b = STALL_AHEAD.memory * (1.0 - exp(-horizon / STALL_AHEAD.memory))
    growth = push.rate + b * push.drive
    variance = push.p11 + b * (2.0 * push.p12 + b * push.p22)
    now = _stands(stall.tilt, push.rate, push.p11, rest_rate)
    return normal_cdf(max(now, _stands(stall.tilt, growth, variance, rest_rate)))


@compiled
def _stands(tilt: Trend, growth: float, variance: float, rest_rate: float) -> float:
    """Return by how many standard deviations the tilt is too slow to close the peg."""
    c = tilt.drive
    rate = tilt.rate + c * growth
    spread = tilt.p11 + growth * (2.0 * tilt.p12 + growth * tilt.p22) + c * c * variance
    return (rate + rest_rate) / sqrt(max(spread, 1e-18))
