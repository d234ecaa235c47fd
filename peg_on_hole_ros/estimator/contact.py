"""The six equations of a peg on three contacts as a measurement of the wrench."""

from math import atan2, cos, exp, sin, sqrt

import numpy as np

from peg_on_hole_ros.estimator.direction import add_unknown_direction, direction_moments
from peg_on_hole_ros.estimator.state import (
    ACCELERATION,
    BIAS,
    CLEARANCE,
    COMPLIANCE,
    FRICTION,
    FRICTION_K,
    RATE,
    TILT,
)
from peg_on_hole_ros.mechanics.kernel import (
    SceneScalars,
    closed_forms,
    compiled,
    derivatives,
    equations,
)
from peg_on_hole_ros.record_types import ScratchRecord

# The equations are taken no nearer to the tilt at which three contacts become two, and for no peg
# that lies, where the closed forms end [rad].
NEAREST, STEEPEST = 1e-5, 1.5
# A clearance is learnt within a factor of e^3 of the stated one.
MOST_LOG = 3.0
LEAST_CLEARANCE = 1e-7


@compiled
def scene_at(p: SceneScalars, x: np.ndarray, at: np.ndarray, load: float) -> SceneScalars:
    """Return the scene with the clearance of a component: as learnt, less what a load takes."""
    if at[CLEARANCE] < 0 and at[COMPLIANCE] < 0:
        return p
    clearance = p.D - p.d
    if at[CLEARANCE] >= 0:
        clearance *= exp(min(max(x[at[CLEARANCE]], -MOST_LOG), MOST_LOG))
    if at[COMPLIANCE] >= 0:
        clearance = max(clearance - x[at[COMPLIANCE]] * load, LEAST_CLEARANCE)
    d = p.D - clearance
    gamma0 = atan2(sqrt(clearance * (p.D + d)), d)
    return SceneScalars(d, p.D, p.H_c, gamma0, p.m, p.Ie, p.Iz, p.f, p.g_x, p.g_y, p.g_z)


@compiled
def leaning_gravity(p: SceneScalars, x: np.ndarray, at: np.ndarray) -> tuple[float, float, float]:
    """Return gravity in the axes of the hole as it is taken to lie [m/s^2], three values."""
    if at[TILT] < 0:
        return p.g_x, p.g_y, p.g_z
    t_x, t_y = x[at[TILT]], x[at[TILT] + 1]
    return p.g_x - t_y * p.g_z, p.g_y + t_x * p.g_z, p.g_z + t_y * p.g_x - t_x * p.g_y


@compiled
def applied_forces(
    p: SceneScalars, x: np.ndarray, at: np.ndarray, u: np.ndarray, bias_map: np.ndarray, s: float,
    c: float, columns: np.ndarray,
) -> tuple[float, float, float, float, float, float]:  # fmt: skip
    """
    Return the applied wrench, weight included, about the mass centre in (h, e, z), six values.

    Parameters
    ----------
    p, x, at, u, bias_map
        As for `straighten`.
    s, c : float
        Sine and cosine of the tilt at which the contacts are taken.
    columns : ndarray, shape (6, 11)
        Filled with how that wrench moves with gamma, psi, phi, with u (6), and with a tilt of the
        hole (2).

    """
    u0, u1, u2, u3, u4, u5 = u[0], u[1], u[2], u[3], u[4], u[5]
    if at[BIAS] >= 0:
        b = x[at[BIAS] : at[BIAS] + 6]
        u0 -= _row(bias_map, 0, b)
        u1 -= _row(bias_map, 1, b)
        u2 -= _row(bias_map, 2, b)
        u3 -= _row(bias_map, 3, b)
        u4 -= _row(bias_map, 4, b)
        u5 -= _row(bias_map, 5, b)
    g_x, g_y, g_z = leaning_gravity(p, x, at)
    sp, cp, sps, cps = sin(x[2]), cos(x[2]), sin(x[1]), cos(x[1])
    r00, r01, r02 = c * cp, -c * sp, -s
    r10, r11 = sp, cp
    r20, r21, r22 = s * cp, -s * sp, c
    F_h, F_e, F_z = r00 * u0 + r01 * u1 + r02 * u2, r10 * u0 + r11 * u1, r20 * u0 + r21 * u1
    F_z += r22 * u2
    M_h, M_e, M_z = r00 * u3 + r01 * u4 + r02 * u5, r10 * u3 + r11 * u4, r20 * u3 + r21 * u4
    M_z += r22 * u5
    g_h, g_e = p.m * (cps * g_x + sps * g_y), p.m * (cps * g_y - sps * g_x)
    for i in range(6):
        columns[i, 0] = columns[i, 2] = 0.0
    _put(columns, 1, g_e, -g_h, 0.0, 0.0, 0.0, 0.0)
    turn(columns, s, c, F_h, F_e, F_z, M_h, M_e, M_z)
    for j in range(2):
        _put(columns, 3 + 3 * j, r00, r10, r20, r00, r10, r20)
        _put(columns, 4 + 3 * j, r01, r11, r21, r01, r11, r21)
        _put(columns, 5 + 3 * j, r02, 0.0, r22, r02, 0.0, r22)
        for i in range(3):
            for k in range(3 + 3 * j, 6 + 3 * j):
                columns[3 * (1 - j) + i, k] = 0.0
    # Gravity leans by -g_z t_y, g_z t_x in the hole's axes.
    l_y, l_x = p.m * p.g_z, -p.m * p.g_z
    _put(columns, 9, sps * l_y, cps * l_y, -p.m * p.g_y, 0.0, 0.0, 0.0)
    _put(columns, 10, cps * l_x, -sps * l_x, p.m * p.g_x, 0.0, 0.0, 0.0)
    return F_h + g_h, F_e + g_e, F_z + p.m * g_z, M_h, M_e, M_z


@compiled
def turn(
    columns: np.ndarray, s: float, c: float, F_h: float, F_e: float, F_z: float, M_h: float,
    M_e: float, M_z: float,
) -> None:  # fmt: skip
    """Add how a wrench turns with its peg: with gamma about -e, with phi about the peg's axis."""
    for i, h, e, z in ((0, F_h, F_e, F_z), (3, M_h, M_e, M_z)):
        columns[i, 0] -= z
        columns[i + 2, 0] += h
        columns[i, 2] -= c * e
        columns[i + 1, 2] += c * h + s * z
        columns[i + 2, 2] -= s * e


@compiled
def _put(columns, j, F_h, F_e, F_z, M_h, M_e, M_z):
    columns[0, j], columns[1, j], columns[2, j] = F_h, F_e, F_z
    columns[3, j], columns[4, j], columns[5, j] = M_h, M_e, M_z


@compiled
def applied_slopes(
    columns: np.ndarray, at: np.ndarray, bias_map: np.ndarray, E: np.ndarray
) -> None:
    """Take the slopes of an applied wrench, which stands on the right, into the residual's."""
    for i in range(6):
        for j in range(3):
            E[i, j] -= columns[i, j]
        if at[BIAS] >= 0:
            for j in range(6):
                t = 0.0
                for k in range(6):
                    t += columns[i, 3 + k] * bias_map[k, j]
                E[i, at[BIAS] + j] = t
        if at[TILT] >= 0:
            E[i, at[TILT]], E[i, at[TILT] + 1] = -columns[i, 9], -columns[i, 10]


@compiled
def clearance_slopes(
    p: SceneScalars, x: np.ndarray, at: np.ndarray, load: float, i: int, by_diameter: float,
    E: np.ndarray,
) -> None:  # fmt: skip
    """Fill in a row's slopes by clearance and compliance, from that by the peg's diameter."""
    if at[CLEARANCE] >= 0:
        # To the diameter, of which the clearance is what is left.
        grown = (p.D - p.d) + (x[at[COMPLIANCE]] * load if at[COMPLIANCE] >= 0 else 0.0)
        E[i, at[CLEARANCE]] -= by_diameter * grown
    if at[COMPLIANCE] >= 0:
        E[i, at[COMPLIANCE]] += by_diameter * load


@compiled
def _reduce(geo, columns):
    """Turn wrenches into the right side of the six equations, column by column."""
    s, c, h_c, dh_c, dz_c = geo[0], geo[1], geo[8], geo[10], geo[11]
    for j in range(columns.shape[1]):
        F_h, F_e, F_z = columns[0, j], columns[1, j], columns[2, j]
        M_h, M_e, M_z = columns[3, j], columns[4, j], columns[5, j]
        _put(columns, j, F_h * dh_c + F_z * dz_c - M_e, F_e * h_c + M_z, c * M_z - s * M_h,
             F_h, F_e, F_z)  # fmt: skip


@compiled
def straighten(
    p: SceneScalars, x: np.ndarray, P: np.ndarray, n: int, at: np.ndarray, u: np.ndarray,
    noise: np.ndarray, bias_map: np.ndarray, load: float, share: float, inertia: float,
    friction_force2: np.ndarray, scratch: ScratchRecord,
) -> float:  # fmt: skip
    """
    Fill in residual, slopes and noise of the six equations at the mean of a component.

    Parameters
    ----------
    p : SceneScalars
        The scene as stated.
    x, P : ndarray
        Mean and covariance of the component.
    n : int
        How many values stand before the reactions.
    at : ndarray, shape (6,)
        Places of the open quantities, see `places`.
    u : ndarray, shape (6,)
        The wrench on the peg about its mass centre, peg axes [N], [N m].
    noise : ndarray, shape (6, 6)
        Its covariance.
    bias_map : ndarray, shape (6, 6)
        What one unit of the sensor's bias adds to u.
    load : float
        [N].
    share, inertia : float
        `direction_share` and `inertia`.
    friction_force2 : ndarray, shape (3,)
        Mean square of the friction at each contact [N^2].
    scratch : record of SCRATCH
        residual, E, R, unknown and by_friction are filled.

    Returns
    -------
    turned : float
        See `direction_moments`.

    """
    p = scene_at(p, x, at, load)
    work, columns, E, residual = scratch.work, scratch.columns, scratch.E, scratch.residual
    gamma = min(max(x[0], p.gamma0 + NEAREST), STEEPEST)
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, gamma)
    turned = direction_moments(p, geo, x, P, share, scratch.scales, scratch.left)
    s, c, h_c, dh_c, dz_c = geo[0], geo[1], geo[8], geo[10], geo[11]
    wrench = applied_forces(p, x, at, u, bias_map, s, c, columns)
    rates = (x[RATE], x[RATE + 1], x[RATE + 2])
    scales = (scratch.scales[0], scratch.scales[1], scratch.scales[2])
    for i in range(6):
        for j in range(n):
            E[i, j] = 0.0
    E[0, 6] = inertia * (p.m * (dh_c * dh_c + dz_c * dz_c) + p.Ie)
    E[1, 7] = inertia * (p.m * h_c * h_c + p.Ie * s * s + p.Iz * c * c)
    E[1, 8] = E[2, 7] = inertia * p.Iz * c
    E[2, 8] = inertia * p.Iz
    E[3, 6] = inertia * p.m * dh_c
    E[4, 7] = inertia * p.m * h_c
    E[5, 6] = inertia * p.m * dz_c
    f, f_K = x[FRICTION], x[FRICTION]
    if at[FRICTION_K] >= 0:
        f_K += x[at[FRICTION_K]]
        # They are linear in each reaction.
        equations(p.m, p.Ie, p.Iz, f_K, p.d, p.D, scales, geo, rates, wrench, work)
        for i in range(6):
            scratch.step[i] = work[3 * i]
    equations(p.m, p.Ie, p.Iz, f, p.d, p.D, scales, geo, rates, wrench, work)
    for i in range(6):
        if at[FRICTION_K] >= 0:
            work[3 * i] = scratch.step[i]
        residual[i] = -work[18 + i]
        for j in range(3):
            E[i, n + j] = -work[3 * i + j]
            residual[i] += E[i, ACCELERATION + j] * x[ACCELERATION + j]
            residual[i] += E[i, n + j] * x[n + j]
    wrench = _expect(geo, wrench, residual, columns)
    a = ACCELERATION
    y = (inertia * x[a], inertia * x[a + 1], inertia * x[a + 2], x[n], x[n + 1], x[n + 2])
    if at[FRICTION_K] >= 0:
        _slopes_apart(p, at, scales, geo, rates, wrench, y, f, f_K, scratch)
    else:
        derivatives(
            p.m, p.Ie, p.Iz, f, p.d, p.D, scales, geo, rates, wrench, y, work[24:60]
        )  # fmt: skip
    for i in range(6):
        E[i, FRICTION] = work[24 + 6 * i + 4]
        for j in range(3):
            E[i, RATE + j] = work[24 + 6 * i + 1 + j]
        E[i, 0], E[i, 1], E[i, 2] = work[24 + 6 * i], 0.0, 0.0
        clearance_slopes(p, x, at, load, i, work[24 + 6 * i + 5], E)
    _reduce(geo, columns)
    applied_slopes(columns, at, bias_map, E)
    see_noise(columns, noise, scratch.root, scratch.R)
    add_unknown_direction(
        p, geo, x, scratch.scales, scratch.left, friction_force2, scratch.unknown,
        scratch.by_friction,
    )  # fmt: skip
    return turned


@compiled
def _expect(geo, wrench, residual, columns):
    """
    Return the wrench with which the equations hold, and let the slopes by the angles be its own.

    Slopes that the wrench's own noise has a part in would make that noise a measurement.
    """
    s, c, h_c, dh_c, dz_c = geo[0], geo[1], geo[8], geo[10], geo[11]
    F_h, F_e, F_z = residual[3], residual[4], residual[5]
    M_e = F_h * dh_c + F_z * dz_c - residual[0]
    M_z = residual[1] - F_e * h_c
    M_h = (c * M_z - residual[2]) / s
    turn(columns, s, c, F_h, F_e, F_z, M_h, M_e, M_z)
    w = wrench
    return w[0] + F_h, w[1] + F_e, w[2] + F_z, w[3] + M_h, w[4] + M_e, w[5] + M_z


@compiled
def _row(matrix, i, b):
    t = 0.0
    for j in range(6):
        t += matrix[i, j] * b[j]
    return t


@compiled
def see_noise(columns: np.ndarray, noise: np.ndarray, product: np.ndarray, R: np.ndarray) -> None:
    """Fill R with the wrench's noise as the equations see it."""
    for i in range(6):
        for j in range(6):
            t = 0.0
            for k in range(6):
                t += columns[i, 3 + k] * noise[k, j]
            product[i, j] = t
    for i in range(6):
        for j in range(i + 1):
            t = 0.0
            for k in range(6):
                t += product[i, k] * columns[j, 3 + k]
            R[i, j] = t
            R[j, i] = t


@compiled
def _slopes_apart(p, at, scales, geo, rates, wrench, y, f, f_K, scratch):
    """Fill in the slopes where friction at K differs: they are linear in each reaction."""
    slopes, total = scratch.work[24:60], scratch.gain.reshape(scratch.gain.size)
    total[:36] = 0.0
    # K alone with its friction, less what does not depend on K, and both others.
    parts = ((f_K, y[3], 0.0, 0.0, 1.0), (f_K, 0.0, 0.0, 0.0, -1.0), (f, 0.0, y[4], y[5], 1.0))
    for friction, N_K, N_B1, N_B2, sign in parts:
        derivatives(
            p.m, p.Ie, p.Iz, friction, p.d, p.D, scales, geo, rates, wrench,
            (y[0], y[1], y[2], N_K, N_B1, N_B2), slopes,
        )  # fmt: skip
        for i in range(36):
            total[i] += sign * slopes[i]
        if N_K != 0.0:
            for i in range(6):
                scratch.E[i, at[FRICTION_K]] = slopes[6 * i + 4]
    for i in range(36):
        slopes[i] = total[i]
