"""The risk that the peg jams within a short time, by its causes: wedging, stall, load."""

from collections.abc import Sequence
from math import fabs
from typing import Annotated

from peg_on_hole_ros.estimator.record import Estimate
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.contacts import below
from peg_on_hole_ros.monitor.down_the_hole import DepthTrend
from peg_on_hole_ros.monitor.evidence import Shown
from peg_on_hole_ros.monitor.load_ahead import NOTHING, follow_load, over_limit
from peg_on_hole_ros.monitor.motion import MotionTrend
from peg_on_hole_ros.monitor.moving import Passed, moving_now
from peg_on_hole_ros.monitor.push import EDGE, Push, forget_push, pushed_on
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.monitor.stuck import BeyondDiagram, forget_stuck, stuck_in_hole
from peg_on_hole_ros.monitor.trend import Trend, forget_trend, is_number
from peg_on_hole_ros.monitor.wedging_ahead import wedging_ahead
from peg_on_hole_ros.typed_record import Record

# docs/jamming.md has the definition and its derivation.

# A trend of the load takes this long to part from its begin [s].
_LOADED = 0.015
# The sum of the reactions is its mean over this time [s].
_TOTAL_OVER = 0.01


class Risk(Record):
    """
    The risk and its causes.

    Attributes
    ----------
    wedging, stall, load : float
        Probability of each within the horizon.
    risk : float
        That of any, as if they were independent.
    determinant : float
        Of the six equations now, over its frictionless value; 0 below gamma0.
    insertion : float
        l/d in two-point contact; 0 elsewhere.
    margin : float
        Of `whitney.jamming_margin` in two-point contact [N]; 0 elsewhere.
    loaded : int
        Which contact `load` is of: 0 K, 1 B1, 2 B2.

    """

    wedging: float
    stall: float
    load: float
    risk: float
    determinant: float
    insertion: float
    margin: float
    loaded: int


class Jamming(Record):
    """
    What has been seen of loads and pushes.

    Attributes
    ----------
    total : float
        Running mean of the sum of the reactions [N]; 0: not seen.
    unbroken : float
        For how long they were seen without a break [s].
    push : Push
    loads : sequence of Trend
        Of the reactions at K, B1, B2 [N].
    beyond : BeyondDiagram
    risk : Risk
        At the last wrench.

    """

    total: float
    unbroken: float
    push: Push
    loads: Annotated[Sequence[Trend], (3,)]
    beyond: BeyondDiagram
    risk: Risk


@compiled
def forget_jamming(jamming: Jamming) -> None:
    """Begin anew with the next wrench."""
    risk = jamming.risk
    risk.wedging = risk.stall = risk.load = risk.risk = 0.0
    risk.determinant = risk.insertion = risk.margin = 0.0
    risk.loaded = 0
    jamming.total = 0.0
    forget_push(jamming.push)
    forget_stuck(jamming.beyond)
    break_course(jamming)


@compiled
def break_course(jamming: Jamming) -> None:
    """
    Let the course of the reactions begin anew: they are no numbers to use, or jump.

    They do where the peg does not move as predicted: what changes reactions and motion at once,
    as another friction does, is no trend to go on.
    """
    jamming.unbroken = 0.0
    for i in range(3):
        forget_trend(jamming.loads[i])


@compiled
def assess_risk(
    estimate: Estimate,
    jamming: Jamming,
    motion: MotionTrend,
    depth: DepthTrend,
    shown: Shown,
    settings: MonitorSettings,
    passed: Passed,
) -> None:
    """
    Fill in the risk.

    Parameters
    ----------
    estimate : Estimate
    jamming : Jamming
        Changed.
    motion : MotionTrend
        Its last orientation is taken.
    depth : DepthTrend
    shown : Shown
        By the same wrench.
    settings : MonitorSettings
    passed : Passed

    """
    scene, risk = estimate.scene, jamming.risk
    contact, under, time = 1.0 - shown.free, shown.below, shown.time
    horizon = settings.jamming_horizon
    moving = moving_now(motion, scene.D, passed.since, settings)
    determinant = path = 0.0
    if estimate.motion.gamma > scene.gamma0 * (1.0 + EDGE):
        path, determinant = wedging_ahead(estimate, moving, horizon)
    over = stall = pushed = 0.0
    loaded = 0
    if contact < 0.5:
        forget_jamming(jamming)
    else:
        # What is foreseen ends with three-point contact.
        over, loaded = _overload(estimate, jamming, settings, shown, passed.dt)
        ahead = min(horizon, time) if time >= 0.0 else horizon
        found = pushed_on(
            estimate, jamming.push, motion.measured, moving, passed, jamming.total, ahead
        )
        pushed = max(found.grows, found.more)
        stall = min(moving.closing * found.stops * found.grows + moving.rest * pushed, 1.0)
    # Below gamma0, or clear of everything, this is not about three contacts.
    above = contact * (1.0 - under)
    moves = 1.0 - moving.rest if moving.known else 0.0
    wedging = above * path * (moves + (1.0 - moves) * pushed)
    stall *= above
    load = above * over
    insertion = margin = 0.0
    if under > 0.5:
        threshold = settings.contact_force_threshold
        stuck = stuck_in_hole(estimate, jamming.beyond, depth, threshold, passed.dt)
        insertion, margin = stuck.insertion, stuck.margin
        wedging = contact * under * stuck.wedged
        # Of a peg that is not wedged, so that the risk is that it is stuck.
        stall = (contact * under * stuck.stuck - wedging) / max(1.0 - wedging, 1e-9)
    risk.wedging, risk.stall, risk.load = wedging, stall, load
    risk.risk = 1.0 - (1.0 - wedging) * (1.0 - stall) * (1.0 - load)
    risk.determinant, risk.insertion, risk.margin = determinant, insertion, margin
    risk.loaded = loaded


@compiled
def _overload(
    estimate: Estimate, jamming: Jamming, settings: MonitorSettings, shown: Shown, dt: float
) -> tuple[float, int]:
    """Return the probability that a reaction passes its limit, and which: 0 K, 1 B1, 2 B2."""
    normal, covariance, usable = estimate.reactions.normal, estimate.reactions.covariance, True
    for i in range(3):
        usable = usable and is_number(normal[i]) and is_number(covariance[i, i])
    if not (usable and shown.usable):
        break_course(jamming)
        return 0.0, 0
    total = 0.0
    jamming.unbroken += dt
    for i in range(3):
        N, variance = normal[i], covariance[i, i]
        total += fabs(N)
        if follow_load(jamming.loads[i], N, variance, settings.max_normal[i], dt):
            jamming.unbroken = 0.0
    share = min(dt / _TOTAL_OVER, 1.0) if jamming.total > 0.0 else 1.0
    jamming.total += share * (total - jamming.total)
    # A load that jumps shows no course, but it is there.
    horizon = 0.0
    if jamming.unbroken > _LOADED:
        horizon = settings.load_horizon
        if shown.time >= 0.0:
            horizon = min(horizon, shown.time)
    most, which = NOTHING, 0
    for i in range(3):
        over = over_limit(jamming.loads[i], covariance[i, i], settings.max_normal[i], horizon)
        if over > most:
            most, which = over, i
    return below(most), which
