"""A peg on two points in the hole, K and B, as a measurement of the wrench."""

from math import cos, fabs, sin

import numpy as np

from peg_on_hole_ros.estimator.contact import (
    applied_forces,
    applied_slopes,
    clearance_slopes,
    scene_at,
    see_noise,
    turn,
)
from peg_on_hole_ros.estimator.direction import along_slip, slip_moments
from peg_on_hole_ros.estimator.state import ACCELERATION, FRICTION, FRICTION_K, RATE
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled
from peg_on_hole_ros.record_types import ScratchRecord

# Newton's and Euler's equations about the mass centre in (h, e, z): rows F_h, F_e, F_z, M_h, M_e,
# M_z. Unknown are N_K and N_B; the force along e that holds B in the plane of the tilt (T4) is a
# noise as wide as the load, so that what it tells of friction is not taken twice.


@compiled
def length_slope(p: SceneScalars, gamma: float) -> float:
    """Return dl/dgamma, the length in the hole by the tilt [m/rad]. Source: T1."""
    s = sin(gamma)
    return (p.d - p.D * cos(gamma)) / (s * s)


@compiled
def two_point_tilt(p: SceneScalars, gamma: float) -> float:
    """Return the tilt, kept where two points touch: below gamma0, l no longer than the peg."""
    return min(max(fabs(gamma), 0.5 * (p.D - p.d) / p.H_c), p.gamma0)


@compiled
def two_point_slip(
    p: SceneScalars, gamma: float, contact: int
) -> tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]:
    """
    Return the slip's components (h, e, z) by the rates at K (0) or B (1), three rows of three.

    The tilt alone tells how fast the peg goes in, by l(gamma).
    """
    s, c = sin(gamma), cos(gamma)
    way = length_slope(p, gamma)
    if contact == 0:
        return (s * way, 0.0, 0.0), (0.0, -0.5 * p.D, -0.5 * p.d), (-c * way, 0.0, 0.0)
    return (0.0, 0.0, 0.0), (0.0, 0.5 * p.D, 0.5 * p.d), (p.D - c * way, 0.0, 0.0)


@compiled
def two_point_arms(
    p: SceneScalars, gamma: float
) -> tuple[tuple[float, float, float, float], tuple[float, float, float, float]]:
    """
    Return K and B from the mass centre, and both by the tilt: h, z each [m], [m/rad].

    Source: T1; B lies l cos(gamma) - d sin(gamma) below the rim.
    """
    s, c = sin(gamma), cos(gamma)
    length = (p.D - p.d * c) / s
    deep, deeper = length * c - p.d * s, length_slope(p, gamma) * c - length * s - p.d * c
    B_h, B_z = 0.5 * p.d * c + p.H_c * s, 0.5 * p.d * s - p.H_c * c
    by_h, by_z = p.H_c * c - 0.5 * p.d * s, 0.5 * p.d * c + p.H_c * s
    return (B_h - p.D, B_z + deep, by_h, by_z + deeper), (B_h, B_z, by_h, by_z)


@compiled
def straighten_two_points(
    p: SceneScalars, x: np.ndarray, P: np.ndarray, n: int, at: np.ndarray, u: np.ndarray,
    noise: np.ndarray, bias_map: np.ndarray, load: float, share: float, inertia: float,
    level: float, friction_force2: np.ndarray, scratch: ScratchRecord,
) -> float:  # fmt: skip
    """
    Fill in residual, slopes and noise of two-point contact at the mean of a component.

    N_B stands in the mean as two halves, in the places of N_B1 and N_B2. The way of the slip is
    that at the mean tilt.

    Parameters
    ----------
    p, x, P, n, at, u, noise, bias_map, load, share, inertia, friction_force2, scratch
        As for `contact.straighten`.
    level : float
        Of accelerations [rad/s^2]: along the hole the peg speeds up by as much over its height,
        twice that of the mass centre.

    Returns
    -------
    turned : float
        See `direction.direction_moments`.

    """
    # Contacts that give let the hole be wider, where above gamma0 they let the peg be thicker.
    p = scene_at(p, x, at, -load)
    E, residual, unknown, columns = scratch.E, scratch.residual, scratch.unknown, scratch.columns
    gamma = two_point_tilt(p, x[0])
    s, c = sin(gamma), cos(gamma)
    wrench = applied_forces(p, x, at, u, bias_map, s, c, columns)
    for i in range(6):
        residual[i] = -wrench[i]
        for j in range(n + 3):
            E[i, j] = 0.0
        for j in range(6):
            unknown[i, j] = 0.0
    _inertia(p, x, s, c, inertia, residual, E)
    K, B = two_point_arms(p, gamma)
    f = x[FRICTION]
    f_K = f + (x[at[FRICTION_K]] if at[FRICTION_K] >= 0 else 0.0)
    turned, left_K, scale2_K = slip_moments(two_point_slip(p, gamma, 0), x, P, share)
    other, left_B, scale2_B = slip_moments(two_point_slip(p, gamma, 1), x, P, share)
    _press(p, x, n, at, 0, x[n], f_K, gamma, K, scale2_K, (c, s, -s, c), load, scratch)
    _press(p, x, n, at, 1, x[n + 1] + x[n + 2], f, gamma, B, scale2_B, (-1.0, 0.0, 0.0, 0.0), load,
           scratch)  # fmt: skip
    # What the residual lacks is no part of the slopes, see `contact.straighten`.
    turn(
        columns, s, c, residual[0], residual[1], residual[2], residual[3], residual[4], residual[5]
    )
    applied_slopes(columns, at, bias_map, E)
    see_noise(columns, noise, scratch.root, scratch.R)
    scratch.R[2, 2] += (2.0 * p.m * p.H_c * level) ** 2
    amount_K = 0.5 * left_K * friction_force2[0]
    amount_B = 0.5 * left_B * (friction_force2[1] + friction_force2[2]) * 2.0
    _add(unknown, amount_K, (0.0, 1.0, 0.0, -K[1], 0.0, K[0]))
    _add(unknown, amount_K, (-s, 0.0, c, 0.0, -K[1] * s - K[0] * c, 0.0))
    _add(unknown, amount_B, (0.0, 1.0, 0.0, -B[1], 0.0, B[0]))
    _add(unknown, amount_B, (0.0, 0.0, 1.0, 0.0, -B[0], 0.0))
    # The axes cross in the middle between K and B, seen along e.
    O_h, O_z = 0.5 * (K[0] + B[0]), 0.5 * (K[1] + B[1])
    _add(scratch.R, load * load, (0.0, 1.0, 0.0, -O_z, 0.0, O_h))
    return 0.5 * (turned + other)


@compiled
def _inertia(p, x, s, c, inertia, residual, E):
    """Add what accelerations take; those of the place along the hole are noise."""
    h_c = 0.5 * (p.D - p.d * c) - p.H_c * s
    rows = (
        (0, 0, p.m * (0.5 * p.d * s - p.H_c * c)),
        (1, 1, p.m * h_c),
        (3, 2, -s * p.Iz),
        (4, 0, -p.Ie),
        (5, 1, p.Ie * s * s + p.Iz * c * c),
        (5, 2, p.Iz * c),
        (3, 1, (p.Ie - p.Iz) * s * c),
    )
    for i, j, amount in rows:
        E[i, ACCELERATION + j] = inertia * amount
        residual[i] += inertia * amount * x[ACCELERATION + j]


@compiled
def _press(p, x, n, at, contact, N, f, gamma, arm, scale2, normal, load, scratch):
    """Take one contact's force off the residual, and fill in its slopes."""
    E, residual = scratch.E, scratch.residual
    rows = two_point_slip(p, gamma, contact)
    v_h, v_e, v_z = along_slip(rows[0], x), along_slip(rows[1], x), along_slip(rows[2], x)
    over = 1.0 / (v_h * v_h + v_e * v_e + v_z * v_z + scale2) ** 0.5
    d_h, d_e, d_z = v_h * over, v_e * over, v_z * over
    r_h, r_z, by_h, by_z = arm
    n_h, n_z, turned_h, turned_z = normal
    w = _wrench(n_h - f * d_h, -f * d_e, n_z - f * d_z, r_h, r_z)
    by_f = _wrench(-d_h, -d_e, -d_z, r_h, r_z)
    # Force turned with the tilt, and arm moved by it.
    by_tilt = _wrench(turned_h, 0.0, turned_z, r_h, r_z)
    moved = _moved(w, by_h, by_z)
    first = n + contact
    for i in range(6):
        residual[i] -= N * w[i]
        E[i, first] = -w[i]
        if contact == 1:
            E[i, first + 1] = -w[i]
        E[i, 0] -= N * (by_tilt[i] + moved[i])
        E[i, FRICTION] -= N * by_f[i]
        scratch.by_friction[i, contact] = by_f[i]
        # N_B is two halves.
        if contact == 1:
            scratch.by_friction[i, 2] = by_f[i]
        if contact == 0 and at[FRICTION_K] >= 0:
            E[i, at[FRICTION_K]] = -N * by_f[i]
    for j in range(3):
        g_h, g_e, g_z = rows[0][j] * over, rows[1][j] * over, rows[2][j] * over
        with_v = g_h * d_h + g_e * d_e + g_z * d_z
        by_rate = _wrench(g_h - with_v * d_h, g_e - with_v * d_e, g_z - with_v * d_z, r_h, r_z)
        for i in range(6):
            E[i, RATE + j] += N * f * by_rate[i]
    s, c = sin(gamma), cos(gamma)
    # By the diameter: the peg's radius moves both, its length in the hole moves K.
    thicker = _moved(w, 0.5 * c, 0.5 * s - (1.0 / s if contact == 0 else 0.0))
    for i in range(6):
        clearance_slopes(p, x, at, -load, i, -N * thicker[i], E)


@compiled
def _wrench(F_h, F_e, F_z, r_h, r_z):
    """Return a force with its moment, at an arm in the plane of the tilt."""
    return F_h, F_e, F_z, -r_z * F_e, r_z * F_h - r_h * F_z, r_h * F_e


@compiled
def _moved(w, by_h, by_z):
    """Return how a wrench changes where its force stays and its arm moves."""
    return 0.0, 0.0, 0.0, -by_z * w[1], by_z * w[0] - by_h * w[2], by_h * w[1]


@compiled
def _add(unknown, amount, w):
    for i in range(6):
        for j in range(6):
            unknown[i, j] += amount * w[i] * w[j]
