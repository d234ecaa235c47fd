"""The wrench of a peg that hangs free as a measurement: what it weighs, and the sensor's bias."""

from math import cos, sin

import numpy as np

from peg_on_hole_ros.estimator.contact import leaning_gravity
from peg_on_hole_ros.estimator.state import BIAS, TILT
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled
from peg_on_hole_ros.record_types import ScratchRecord


@compiled
def balance_free(
    p: SceneScalars,
    x: np.ndarray,
    n: int,
    at: np.ndarray,
    u: np.ndarray,
    noise: np.ndarray,
    bias_map: np.ndarray,
    moved: float,
    turned: float,
    scratch: ScratchRecord,
) -> None:
    """
    Fill in residual, slopes and noise of the balance of a peg that nothing touches.

    How the holder moves it is not measured: that is noise.

    Parameters
    ----------
    p : SceneScalars
    x : ndarray
        Mean of a component.
    n : int
    at, u, noise, bias_map
        As for `contact.straighten`.
    moved, turned : float
        Variances of force [N^2] and couple [N^2 m^2] that the holder's motion leaves.
    scratch : record of SCRATCH
        residual, E and R are filled.

    """
    E, residual, R = scratch.E, scratch.residual, scratch.R
    s, c, sp, cp, sps, cps = sin(x[0]), cos(x[0]), sin(x[2]), cos(x[2]), sin(x[1]), cos(x[1])
    g_x, g_y, g_z = leaning_gravity(p, x, at)
    weight = in_peg_axes(s, c, sp, cp, sps, cps, p.m * g_x, p.m * g_y, p.m * g_z)
    for i in range(6):
        residual[i] = u[i]
        if i < 3:
            residual[i] += weight[i]
        for j in range(n + 3):
            E[i, j] = 0.0
        for j in range(6):
            R[i, j] = noise[i, j]
        R[i, i] += moved if i < 3 else turned
        if at[BIAS] >= 0:
            for j in range(6):
                residual[i] -= bias_map[i, j] * x[at[BIAS] + j]
                E[i, at[BIAS] + j] = -bias_map[i, j]
    if at[TILT] >= 0:
        first = in_peg_axes(s, c, sp, cp, sps, cps, 0.0, p.m * g_z, -p.m * g_y)
        second = in_peg_axes(s, c, sp, cp, sps, cps, -p.m * g_z, 0.0, p.m * g_x)
        for i in range(3):
            E[i, at[TILT]], E[i, at[TILT] + 1] = first[i], second[i]


@compiled
def in_peg_axes(
    s: float, c: float, sp: float, cp: float, sps: float, cps: float, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """Return a vector of the hole's axes in those of the peg."""
    h, e = cps * x + sps * y, cps * y - sps * x
    across = c * h + s * z
    return cp * across + sp * e, cp * e - sp * across, c * z - s * h
