"""The estimate as monitor and messages read it, filled in by the mean of the mixture."""

from math import sqrt

from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.contact_sets import registry
from peg_on_hole_ros.estimator.estimate import Motion, SceneRecord, Slip
from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.friction_direction import (
    friction_direction_statistics,
    slip_statistics,
)
from peg_on_hole_ros.estimator.hole_geometry import two_point_slip, two_point_tilt
from peg_on_hole_ros.estimator.rim_geometry import Rows, rim_slip
from peg_on_hole_ros.estimator.scene_at_mean import scene_at, within_closed_forms
from peg_on_hole_ros.estimator.state import ACCELERATION, FRICTION, RATE
from peg_on_hole_ros.mechanics.kernel import (
    SceneScalars,
    closed_forms,
    compiled,
    determinant_at,
    scene_of,
    with_friction,
)
from peg_on_hole_ros.typed_record import Floats


@compiled
def fill_estimate(kalman: FilterRecord) -> None:
    """Fill in the record by the mean of the mixture, all but `wrench_noise`."""
    state, places, estimate = kalman.state, kalman.places, kalman.record
    x, C, n = state.mixture_mean, state.mixture_covariance, places.reactions
    scene = scene_of(kalman.scene)
    at_mean = with_friction(scene_at(scene, x, places, state.load), x[FRICTION])
    _fill_scene(estimate.scene, at_mean)
    _fill_motion(estimate.motion, x, C)
    for i in range(6):
        estimate.wrench[i] = kalman.wrench[i]
    for i in range(3):
        estimate.accelerations[i] = x[ACCELERATION + i]
    estimate.bias_load = 0.0
    if places.bias >= 0:
        _subtract_bias(kalman, 2.0 / scene.d)
    # The diameter is what the clearance leaves of the hole's.
    by_log = -(at_mean.D - at_mean.d) if places.clearance >= 0 else 0.0
    k = max(places.clearance, 0)
    estimate.friction_variance = C[FRICTION, FRICTION]
    estimate.diameter_variance = by_log * by_log * C[k, k]
    reactions = estimate.reactions
    for i in range(3):
        reactions.normal[i] = x[n + i]
        for j in range(3):
            reactions.covariance[i, j] = C[n + i, n + j]
    _fill_lasting(reactions.by_friction, C, FRICTION, n, 1.0, estimate.friction_variance)
    _fill_lasting(reactions.by_diameter, C, k, n, by_log, estimate.diameter_variance)
    estimate.contacts = ContactSet.NONE
    if registry.solved_reactions(state.contact_set) > 0:
        estimate.contacts = state.contact_set
    _fill_slips(kalman, at_mean)


@compiled
def _fill_slips(kalman: FilterRecord, at_mean: SceneScalars) -> None:
    """
    Fill in slips, scales of friction's mean direction, and the determinant on the rim.

    A peg without contacts is described as on the rim.
    """
    state, estimate, share = kalman.state, kalman.record, kalman.settings.direction_share
    x, C, scales = state.mixture_mean, state.mixture_covariance, estimate.friction_scales
    tilt = within_closed_forms(at_mean, x[0])
    geo = closed_forms(at_mean.d, at_mean.D, at_mean.H_c, at_mean.gamma0, tilt)
    friction_direction_statistics(at_mean, geo, x, C, share, scales, kalman.scratch.unexplained)
    in_hole = registry.is_in_hole(state.contact_set)
    for i in range(3):
        if in_hole:
            rows = two_point_slip(at_mean, two_point_tilt(at_mean, x[0]), min(i, 1))
            scales[i] = sqrt(slip_statistics(rows, x, C, share)[2])
        else:
            rows = rim_slip(at_mean, geo, i)
        _fill_slip(estimate.slips[i], rows, x, C)
    if not in_hole:
        rates = (x[RATE], x[RATE + 1], x[RATE + 2])
        estimate.determinant = determinant_at(at_mean, scales, tilt, rates, estimate.work)


@compiled
def _fill_scene(scene: SceneRecord, at_mean: SceneScalars) -> None:
    scene.d, scene.D, scene.H_c, scene.gamma0 = at_mean.d, at_mean.D, at_mean.H_c, at_mean.gamma0
    scene.m, scene.Ie, scene.Iz, scene.f = at_mean.m, at_mean.Ie, at_mean.Iz, at_mean.f
    scene.g_x, scene.g_y, scene.g_z = at_mean.g_x, at_mean.g_y, at_mean.g_z


@compiled
def _fill_motion(motion: Motion, x: Floats, C: Floats) -> None:
    motion.gamma, motion.psi, motion.phi = x[0], x[1], x[2]
    motion.gamma_rate, motion.psi_rate, motion.phi_rate = x[RATE], x[RATE + 1], x[RATE + 2]
    for i in range(6):
        for j in range(6):
            motion.covariance[i, j] = C[i, j]


@compiled
def _fill_lasting(out: Floats, C: Floats, of: int, n: int, scale: float, variance: float) -> None:
    """Fill in what a standard deviation of one quantity makes of the reactions."""
    over = 1.0 / sqrt(variance) if variance > 0.0 else 0.0
    for i in range(3):
        out[i] = scale * C[of, n + i] * over


@compiled
def _subtract_bias(kalman: FilterRecord, over_radius: float) -> None:
    """Subtract the bias from the wrench, and fill in the variance of a load that it makes up."""
    estimate, first, bias_map = kalman.record, kalman.places.bias, kalman.bias_map
    x, C = kalman.state.mixture_mean, kalman.state.mixture_covariance
    for i in range(6):
        weight = 1.0 if i < 3 else over_radius * over_radius
        for j in range(6):
            estimate.wrench[i] -= bias_map[i, j] * x[first + j]
            for k in range(6):
                estimate.bias_load += (
                    weight * bias_map[i, j] * C[first + j, first + k] * bias_map[i, k]
                )


@compiled
def _fill_slip(slip: Slip, rows: Rows, x: Floats, C: Floats) -> None:
    """Fill in speed and variance of the peg's material point at one contact, by its Jacobian."""
    speed2, d0, d1, d2 = 0.0, 0.0, 0.0, 0.0
    for a, b, c in rows:
        v = a * x[RATE] + b * x[RATE + 1] + c * x[RATE + 2]
        speed2 += v * v
        d0 += v * a
        d1 += v * b
        d2 += v * c
    speed = sqrt(speed2)
    over = 1.0 / (speed + 1e-300)
    d0, d1, d2 = d0 * over, d1 * over, d2 * over
    k = RATE
    variance = d0 * d0 * C[k, k] + d1 * d1 * C[k + 1, k + 1] + d2 * d2 * C[k + 2, k + 2]
    variance += 2.0 * (d0 * d1 * C[k, k + 1] + d0 * d2 * C[k, k + 2] + d1 * d2 * C[k + 1, k + 2])
    slip.speed, slip.variance = speed, max(variance, 0.0)
