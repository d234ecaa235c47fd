"""Wedging: a motion on three contacts leads to where friction makes the equations singular."""

from math import fabs, inf, isfinite, sqrt

from peg_on_hole_ros.estimator.estimate import Estimate, scene_of
from peg_on_hole_ros.mechanics.kernel import compiled, determinant_at, with_friction
from peg_on_hole_ros.monitor.contact_probabilities import normal_cdf
from peg_on_hole_ros.monitor.dangers.situation import Situation, is_inside, on_rim
from peg_on_hole_ros.monitor.motion_now import Moving
from peg_on_hole_ros.monitor.tuned import PUSH_MEANS, WEDGING_AHEAD
from peg_on_hole_ros.typed_record import Record

ADVICE = (
    "the peg nears the tilt at which friction wedges it: do not continue this closing",
    "the peg wedges, or is about to: stop pushing and reverse the tilt",
)


class Wedging(Record):
    """
    Whether friction wedges the peg.

    Attributes
    ----------
    probability : float
        Within the horizon; 0 in the hole.
    determinant : float
        Of the six equations now, over its frictionless value; 0 below gamma0.

    """

    probability: float
    determinant: float


@compiled
def forget(found: Wedging) -> None:
    """Begin anew with the next wrench."""
    found.probability = found.determinant = 0.0


@compiled
def assess(found: Wedging, situation: Situation) -> None:
    """Process a wrench, see the package."""
    estimate, moving, shown = situation.estimate, situation.moving, situation.shown
    path = determinant = 0.0
    if estimate.motion.gamma > estimate.scene.gamma0 * (1.0 + PUSH_MEANS.edge):
        horizon = situation.settings.jamming_horizon
        path, determinant = wedging_ahead(estimate, moving, horizon)
    moves = 1.0 - moving.rest if moving.known else 0.0
    probability = on_rim(shown) * path * (moves + (1.0 - moves) * situation.pushed.pushes)
    found.probability = 0.0 if is_inside(shown) else probability
    found.determinant = determinant


@compiled
def wedging_ahead(estimate: Estimate, moving: Moving, horizon: float) -> tuple[float, float]:
    """
    Return the probability of wedging on the way of a horizon, and the determinant now.

    A peg at rest counts as one that is closed without turning: so a jammed one is pushed.
    """
    p, motion, work = scene_of(estimate), estimate.motion, estimate.work
    rate, C = moving.rate if moving.known else 0.0, motion.covariance
    ratio = p.d / p.D
    along = motion.psi_rate + ratio * motion.phi_rate
    variance = C[4, 4] + ratio * (2.0 * C[4, 5] + ratio * C[5, 5])
    # psi' and phi' alone are hardly known at a small tilt; they count where their slip is known.
    dpsi = motion.psi_rate if along * along > 9.0 * variance else 0.0
    # A holder that does not turn the peg does not turn it by the noise of an estimate either, and
    # so little would take much of the friction away.
    turn = moving.turn
    swing = turn if turn * turn > 9.0 * moving.turn_variance else 0.0
    gamma = motion.gamma
    dgamma = rate
    end = gamma
    if fabs(rate) < moving.rest_rate:
        dgamma = -moving.rest_rate
    elif rate < 0.0:
        end = max(gamma + horizon * rate, min(p.gamma0 * (1.0 + WEDGING_AHEAD.end), gamma))
    uncertain = sqrt(max(estimate.friction_variance, 0.0))
    shifted = with_friction(p, p.f + uncertain)
    rates = (dgamma, dpsi, (swing - dpsi) / ratio)
    scales = _same(WEDGING_AHEAD.presliding_slip)
    least, where = inf, gamma
    # Dense towards gamma0, where the determinant bends.
    first = gamma - p.gamma0
    step = ((end - p.gamma0) / first) ** (1.0 / (WEDGING_AHEAD.points - 1))
    for i in range(WEDGING_AHEAD.points):
        at = p.gamma0 + first * step**i
        d = determinant_at(p, scales, at, rates, work)
        if isfinite(d) and d < least:
            least, where = d, at
        if end == gamma:
            break
    worst = 0.0
    # A peg that opens is not wedged where it is, and leaves what is singular behind.
    if least < inf and rate < moving.rest_rate:
        spread = WEDGING_AHEAD.determinant_stddev
        if uncertain > 0.0:
            slope = determinant_at(shifted, scales, where, rates, work) - least
            if isfinite(slope):
                spread = sqrt(spread * spread + slope * slope)
        worst = normal_cdf(-least / spread)
    now = determinant_at(p, _same(WEDGING_AHEAD.dry_slip), gamma, rates, work)
    return worst, now if isfinite(now) else 0.0


@compiled
def _same(slip: float) -> tuple[float, float, float]:
    return slip, slip, slip
