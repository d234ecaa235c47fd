"""How deep a peg on two points is in the hole, and how fast, by its tilt and the clearance."""

from math import cos, nan, sin, sqrt

import numpy as np

from peg_on_hole_ros.estimator.insertion_depth import depth_at
from peg_on_hole_ros.estimator.record import RATES, REACTIONS, SCENE, SPREAD, P, X, Y
from peg_on_hole_ros.mechanics.kernel import compiled

# Tilt and reactions have to be surely above zero, by so many standard deviations: a peg that
# leans on one wall may be at any depth.
SURE = 3.0
# No diameter is that of two loaded surfaces to better than this [m].
SURFACE = 1e-6


@compiled
def insertion_depth(f: np.ndarray) -> tuple[float, float]:
    """Return depth and standard deviation [m], by the record of an estimate; NaN: not told."""
    gamma, variance = f[X], f[P]
    at = REACTIONS + 21
    # N_B1 and N_B2 are halves of one reaction.
    rim, wall = f[Y + 3] / sqrt(max(f[at], 1e-18)), f[Y + 4] / sqrt(max(f[at + 7], 1e-18))
    if not min(rim, wall, gamma / sqrt(max(variance, 1e-18))) > SURE:
        return nan, nan
    depth, by_tilt, by_diameter = depth_at(f[SCENE], f[SCENE + 1], gamma)
    diameter = max(f[SPREAD + 3], 0.0) + SURFACE * SURFACE
    return depth, sqrt(by_tilt * by_tilt * variance + by_diameter * by_diameter * diameter)


@compiled
def insertion_speed(f: np.ndarray) -> tuple[float, float]:
    """Return speed into the hole and standard deviation [m/s], where the depth is told."""
    d, D, gamma, rate = f[SCENE], f[SCENE + 1], f[X], f[X + 3]
    by_rate = depth_at(d, D, gamma)[1]
    by_tilt, by_diameter = _slope_slopes(d, D, gamma)
    by_tilt, by_diameter = by_tilt * rate, by_diameter * rate
    variance = by_rate * (by_rate * f[RATES] + 2.0 * by_tilt * f[P + 3])
    variance += by_tilt * by_tilt * f[P]
    variance += by_diameter * by_diameter * (max(f[SPREAD + 3], 0.0) + SURFACE * SURFACE)
    return by_rate * rate, sqrt(max(variance, 0.0))


@compiled
def _slope_slopes(d: float, D: float, gamma: float) -> tuple[float, float]:
    """Return the derivatives by gamma and by d of the depth's slope by gamma; see `depth_at`."""
    s, c = sin(gamma), cos(gamma)
    room, steep = D - d * c, c * c / (s * s)
    by_tilt = 2.0 * room * c / (s * s * s) - d * s * (1.5 + steep)
    return by_tilt, c * (1.5 + steep)
