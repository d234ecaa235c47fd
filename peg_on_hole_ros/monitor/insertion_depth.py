"""How deep a peg on two points is in the hole, and how fast, by its tilt and the clearance."""

from math import cos, nan, sin, sqrt

from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.estimator.hole_geometry import depth_at
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.tuned import INSERTION_DEPTH


@compiled
def insertion_depth(estimate: Estimate) -> tuple[float, float]:
    """Return depth and standard deviation [m] by an estimate's record; NaN: not determined."""
    gamma, variance = estimate.motion.gamma, estimate.motion.covariance[0, 0]
    N, C = estimate.reactions.normal, estimate.reactions.covariance
    # N_B1 and N_B2 are halves of one reaction.
    rim, wall = N[0] / sqrt(max(C[0, 0], 1e-18)), N[1] / sqrt(max(C[1, 1], 1e-18))
    if not min(rim, wall, gamma / sqrt(max(variance, 1e-18))) > INSERTION_DEPTH.sure:
        return nan, nan
    depth, by_tilt, by_diameter = depth_at(estimate.scene.d, estimate.scene.D, gamma)
    diameter = (
        max(estimate.diameter_variance, 0.0) + INSERTION_DEPTH.surface * INSERTION_DEPTH.surface
    )
    return depth, sqrt(by_tilt * by_tilt * variance + by_diameter * by_diameter * diameter)


@compiled
def insertion_speed(estimate: Estimate) -> tuple[float, float]:
    """Return speed into the hole and standard deviation [m/s], where the depth is determined."""
    d, D = estimate.scene.d, estimate.scene.D
    gamma, rate, C = estimate.motion.gamma, estimate.motion.gamma_rate, estimate.motion.covariance
    by_rate = depth_at(d, D, gamma)[1]
    by_tilt, by_diameter = _slope_slopes(d, D, gamma)
    by_tilt, by_diameter = by_tilt * rate, by_diameter * rate
    variance = by_rate * (by_rate * C[3, 3] + 2.0 * by_tilt * C[0, 3])
    variance += by_tilt * by_tilt * C[0, 0]
    diameter = (
        max(estimate.diameter_variance, 0.0) + INSERTION_DEPTH.surface * INSERTION_DEPTH.surface
    )
    variance += by_diameter * by_diameter * diameter
    return by_rate * rate, sqrt(max(variance, 0.0))


@compiled
def _slope_slopes(d: float, D: float, gamma: float) -> tuple[float, float]:
    """Return the derivatives by gamma and by d of the depth's slope by gamma; see `depth_at`."""
    s, c = sin(gamma), cos(gamma)
    room, steep = D - d * c, c * c / (s * s)
    by_tilt = 2.0 * room * c / (s * s * s) - d * s * (1.5 + steep)
    return by_tilt, c * (1.5 + steep)
