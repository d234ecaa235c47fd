"""
Whether rim and wall can carry a load below gamma0: they cannot carry what a cone carries.

A peg that is tilted touches rim and wall only as deep as its tilt allows, and a load inside of
Whitney's diagram at that depth moves it in. A peg that stands under such a load stands on
something else: on the cone of a chamfer, on a plate, or on the bottom. On the side of K a cone's
load is that of walls to 0.15 d deep, by friction 0.2: a tilt that allows no more tells nothing.
"""

from math import fabs, hypot, sqrt

from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.linear_algebra import peg_rotation, peg_turns
from peg_on_hole_ros.monitor.contact_load import ContactLoad
from peg_on_hole_ros.monitor.place_check import PlaceMisfit, two_point_length
from peg_on_hole_ros.monitor.tuned import EVIDENCE_WEIGHTS, PLACE_CHECK, WALLS_TEST


@compiled
def evidence_against_walls(estimate: Estimate, load: ContactLoad, place: PlaceMisfit) -> float:
    """
    Return log p(load | not walls) - log p(load | rim and wall), 0 where they may carry it.

    Parameters
    ----------
    estimate : Estimate
    load : ContactLoad
        Which has taken the wrench.
    place : PlaceMisfit
        Where it is surely less deep than on two points, one of them keeps no more than its
        friction.

    """
    push = -load.force[2]
    friction, length = most_friction(estimate), _least_length(estimate)
    if load.share <= 0.0 or push <= 0.0 or friction <= 0.0 or length <= 0.0:
        return 0.0
    shallow = place.depth + PLACE_CHECK.sure * place.depth_stddev < length
    p, R, radius = estimate.scene, estimate.wrench_noise, 0.5 * estimate.scene.d
    F_x, F_y, M_x, M_y = _about_the_end(estimate, load)
    margin = push - friction * hypot(F_x, F_y)
    noise = load.share * R[0, 0] + estimate.bias_load + (WALLS_TEST.share * push) ** 2
    if not shallow:
        # Whitney's diagram in two planes, what is outside of it in both together.
        ratio = length / (2.0 * radius * friction)
        by_force = friction * (1.0 + ratio)
        couple = hypot(M_x / radius + by_force * F_x, M_y / radius + by_force * F_y)
        margin = min(margin, push - couple / ratio)
        about = (R[4, 4] + p.H_c * p.H_c * R[0, 0]) / (radius * radius)
        of_couple = load.share * (about + by_force * by_force * R[0, 0])
        of_couple += estimate.bias_load * (1.0 + by_force * by_force)
        noise += of_couple / (ratio * ratio)
    deviations = max(margin / sqrt(noise) - WALLS_TEST.sure, 0.0)
    evidence: float = min(0.5 * deviations * deviations, EVIDENCE_WEIGHTS.most)
    return evidence


@compiled
def most_friction(estimate: Estimate) -> float:
    """Return the friction that keeps most."""
    stddev = sqrt(max(estimate.friction_variance, 0.0))
    friction: float = estimate.scene.f + WALLS_TEST.sure * stddev
    return friction


@compiled
def _least_length(estimate: Estimate) -> float:
    """Return the least length in the hole on two points that tilt and clearance allow [m]."""
    p, motion, sure = estimate.scene, estimate.motion, WALLS_TEST.sure
    tilt = fabs(motion.gamma) + sure * sqrt(max(motion.covariance[0, 0], 0.0))
    d = p.d + sure * sqrt(max(estimate.diameter_variance, 0.0))
    if not 0.0 < tilt < p.gamma0:
        return 0.0
    length: float = two_point_length(d, p.D, tilt)
    return length


@compiled
def _about_the_end(estimate: Estimate, load: ContactLoad) -> tuple[float, float, float, float]:
    """
    Return the side force, and the couple about the lower end that turns towards it.

    The couple's second pair has the signs of a planar diagram: x goes with the force along x.
    """
    p, motion, force = estimate.scene, estimate.motion, load.force
    turns = peg_turns(motion.gamma, motion.psi, motion.phi)
    _, _, z_x, _, _, z_y, _, _, z_z = peg_rotation(turns)
    up_x, up_y, up_z = p.H_c * z_x, p.H_c * z_y, p.H_c * z_z
    about_x = load.couple[0] - load.momentum_rate[0] + up_y * force[2] - up_z * force[1]
    about_y = load.couple[1] - load.momentum_rate[1] + up_z * force[0] - up_x * force[2]
    return force[0], force[1], -about_y, about_x
