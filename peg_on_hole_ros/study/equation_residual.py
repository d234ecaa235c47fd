"""By how much the six equations do not hold at a state with its reactions."""

import numpy as np

from peg_on_hole_ros.estimator.state import ACCELERATION, ANGLE, FRICTION, OPEN_BEGIN, RATE
from peg_on_hole_ros.mechanics.kernel import (
    R_AT,
    SceneScalars,
    compiled,
    equations,
    pose_of,
    small_forms,
    with_friction,
)

# Friction is Coulomb's: what is not known of its direction is for the method to find [m/s].
_SHARP = 1e-6
_NEAREST = 1e-5


@compiled
def unbalance(
    p: SceneScalars, x: np.ndarray, u: np.ndarray, small: bool, work: np.ndarray, out: np.ndarray
) -> None:
    """
    Fill in the six equations, left side minus right side.

    Parameters
    ----------
    p : SceneScalars
    x : ndarray, shape (13,)
        As a component of the estimator's state: angles, rates, accelerations, friction, N.
    u : ndarray, shape (6,)
        Force and moment about the mass centre, peg axes [N], [N m].
    small : bool
        With the lengths of a small tilt.
    work : ndarray
        From `kernel.workspace`; its first 18 are what the reactions are multiplied by.
    out : ndarray, shape (6,)

    """
    gamma = max(x[ANGLE], p.gamma0 + _NEAREST)
    pose = np.array([gamma, x[ANGLE + 1], x[ANGLE + 2]])
    geo, wrench = pose_of(p, pose, u, work)
    if small:
        geo = small_forms(p.d, p.D, p.H_c, p.gamma0, gamma)
    scales = (_SHARP, _SHARP, _SHARP)
    rates = (x[RATE], x[RATE + 1], x[RATE + 2])
    sliding = with_friction(p, max(x[FRICTION], 0.0))
    equations(sliding, scales, geo, rates, wrench, work)
    s, c, h_c, dh_c, dz_c = geo.s, geo.c, geo.h_c, geo.dh_c, geo.dz_c
    g, a, b = x[ACCELERATION], x[ACCELERATION + 1], x[ACCELERATION + 2]
    out[0] = (p.m * (dh_c**2 + dz_c**2) + p.Ie) * g
    out[1] = (p.m * h_c**2 + p.Ie * s**2 + p.Iz * c**2) * a + p.Iz * c * b
    out[2] = p.Iz * (c * a + b)
    out[3], out[4], out[5] = p.m * dh_c * g, p.m * h_c * a, p.m * dz_c * g
    for i in range(6):
        out[i] -= work[R_AT + i]
        for j in range(3):
            out[i] -= work[3 * i + j] * x[OPEN_BEGIN + j]


@compiled
def unbalanced(
    p: SceneScalars, points: np.ndarray, u: np.ndarray, small: bool, work: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return `unbalance` of several states, shape (k, 6), and by N of each, shape (k, 6, 3)."""
    count = len(points)
    out, contacts = np.empty((count, 6)), np.empty((count, 6, 3))
    for k in range(count):
        unbalance(p, points[k], u, small, work, out[k])
        for i in range(6):
            for j in range(3):
                contacts[k, i, j] = work[3 * i + j]
    return out, contacts


@compiled
def wrench_noise(
    p: SceneScalars,
    x: np.ndarray,
    u: np.ndarray,
    covariance: np.ndarray,
    small: bool,
    work: np.ndarray,
) -> np.ndarray:
    """Return what the noise of a wrench makes of `unbalance`, shape (6, 6): it is linear in it."""
    slopes, at, moved = np.empty((6, 6)), np.empty(6), u.copy()
    unbalance(p, x, u, small, work, at)
    for i in range(6):
        moved[i] += 1.0
        unbalance(p, x, moved, small, work, slopes[i])
        moved[i] = u[i]
        slopes[i] -= at
    return slopes.T @ covariance @ slopes
