"""How deep a peg on two points is in the hole, by its tilt and the clearance."""

from math import cos, nan, sin, sqrt

import numpy as np

from peg_on_hole_ros.estimator.record import REACTIONS, SCENE, SPREAD, P, X, Y
from peg_on_hole_ros.mechanics.kernel import compiled

# Tilt and reactions have to be surely above zero, by so many standard deviations: a peg that
# leans on one wall may be at any depth.
SURE = 3.0
# No diameter is that of two loaded surfaces to better than this [m].
SURFACE = 1e-6


@compiled
def depth_at(d: float, D: float, gamma: float) -> tuple[float, float, float]:
    """
    Return how deep two points let the lower end's centre be, with its slopes.

    Source: T1, l cos(gamma) - d sin(gamma) / 2.

    Parameters
    ----------
    d, D : float
        Diameters [m].
    gamma : float
        Tilt, above 0 [rad].

    Returns
    -------
    depth : float
        Below the rim [m].
    by_tilt, by_diameter : float
        Its derivatives by gamma [m/rad] and by d [-].

    """
    s, c = sin(gamma), cos(gamma)
    room = D - d * c
    by_tilt = 0.5 * d * c - room - room * c * c / (s * s)
    return room * c / s - 0.5 * d * s, by_tilt, -c * c / s - 0.5 * s


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
