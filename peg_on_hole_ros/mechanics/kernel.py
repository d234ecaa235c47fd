"""The six equations compiled: accelerations, reactions and their derivatives as scalar code."""

from math import cos, sin
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics import generated, geometry
from peg_on_hole_ros.mechanics.compiling import compiled, inlined
from peg_on_hole_ros.mechanics.geometry import ClosedForms
from peg_on_hole_ros.mechanics.linear_algebra import hez_rotation
from peg_on_hole_ros.mechanics.scene import SceneScalars

closed_forms = compiled(geometry.closed_forms)
small_forms = compiled(geometry.small_forms)
equations = compiled(generated.equations)
derivatives = compiled(generated.derivatives)

# Columns of the derivatives: six of the state, six of the wrench in peg axes, then friction and
# peg diameter.
JACOBIAN_WIDTH = 14


class Wrench(NamedTuple):
    """Force [N] and moment about the mass centre [N m], along (h, e, z)."""

    F_h: float
    F_e: float
    F_z: float
    M_h: float
    M_e: float
    M_z: float


class AppliedLoad(NamedTuple):
    """What acts on the peg beside the contacts, along (h, e, z), about the mass centre."""

    applied: Wrench
    weight_h: float
    weight_e: float
    weight_z: float


@inlined
def _wrench_with_weight(load):
    F_h, F_e, F_z, M_h, M_e, M_z = load.applied
    return Wrench(F_h + load.weight_h, F_e + load.weight_e, F_z + load.weight_z, M_h, M_e, M_z)


@compiled
def scene_of(values: np.ndarray) -> SceneScalars:
    """Return the scene whose fields are the first entries of an array."""
    v = values
    return SceneScalars(v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8], v[9], v[10])


@inlined
def with_friction(p: SceneScalars, f: float) -> SceneScalars:
    """Return a scene with another coefficient of friction."""
    return SceneScalars(p.d, p.D, p.H_c, p.gamma0, p.m, p.Ie, p.Iz, f, p.g_x, p.g_y, p.g_z)


def workspace() -> np.ndarray:
    """Return the scratch memory that every call of the kernel needs."""
    return np.zeros(_COLUMNS + 6 * JACOBIAN_WIDTH)


# Places in the scratch memory, so that the hot path allocates nothing: of what `equations` fills,
# and of the rows of `derivatives` with their columns.
G_AT, W_AT, R_AT = 0, 9, 18
DERIVATIVES_AT = 24
BY_GAMMA, BY_RATES, BY_FRICTION, BY_PEG_DIAMETER = 0, 1, 4, 5
_INVERSE = 60
_WEIGHTS = 69
_ROTATION = 78
# Right sides of the derivatives, (6, JACOBIAN_WIDTH) by rows, and then the derivatives.
_COLUMNS = 87


@compiled
def _eliminate(p, geo, work):
    """
    Factor the six equations: invert the 3x3 matrix of the reactions.

    Returns the determinant over its frictionless value.
    """
    s, h_c, dh_c, dz_c = geo.s, geo.h_c, geo.dh_c, geo.dz_c
    inertia_gamma = p.m * (dh_c * dh_c + dz_c * dz_c) + p.Ie
    inertia_psi = p.m * h_c * h_c + p.Ie * s * s
    along_h = p.m * dh_c / inertia_gamma
    along_e = p.m * h_c / inertia_psi
    along_z = p.m * dz_c / inertia_gamma
    for i in range(3):
        G_gamma = work[G_AT + i]
        G_psi = work[G_AT + 3 + i] - geo.c * work[G_AT + 6 + i]
        work[_WEIGHTS + i] = work[W_AT + i] - along_h * G_gamma
        work[_WEIGHTS + 3 + i] = work[W_AT + 3 + i] - along_e * G_psi
        work[_WEIGHTS + 6 + i] = work[W_AT + 6 + i] - along_z * G_gamma
    k00, k01, k02 = work[_WEIGHTS], work[_WEIGHTS + 1], work[_WEIGHTS + 2]
    k10, k11, k12 = work[_WEIGHTS + 3], work[_WEIGHTS + 4], work[_WEIGHTS + 5]
    k20, k21, k22 = work[_WEIGHTS + 6], work[_WEIGHTS + 7], work[_WEIGHTS + 8]
    c00, c10, c20 = k11 * k22 - k12 * k21, k12 * k20 - k10 * k22, k10 * k21 - k11 * k20
    determinant = k00 * c00 + k01 * c10 + k02 * c20
    over = 1.0 / determinant
    work[_INVERSE] = c00 * over
    work[_INVERSE + 1] = (k02 * k21 - k01 * k22) * over
    work[_INVERSE + 2] = (k01 * k12 - k02 * k11) * over
    work[_INVERSE + 3] = c10 * over
    work[_INVERSE + 4] = (k00 * k22 - k02 * k20) * over
    work[_INVERSE + 5] = (k02 * k10 - k00 * k12) * over
    work[_INVERSE + 6] = c20 * over
    work[_INVERSE + 7] = (k01 * k20 - k00 * k21) * over
    work[_INVERSE + 8] = (k00 * k11 - k01 * k10) * over
    a1, a2, b = geo.a1, geo.a2, geo.b
    frictionless = 2.0 * b * a2 / (0.25 * p.D * p.D + a1 * a1)
    return determinant / frictionless


@inlined
def _factors(p, geo, work):
    """Return what one solution of the factored six equations takes; divisions are done here."""
    s, c, h_c, dh_c, dz_c = geo.s, geo.c, geo.h_c, geo.dh_c, geo.dz_c
    inertia_gamma = p.m * (dh_c * dh_c + dz_c * dz_c) + p.Ie
    inertia_psi = p.m * h_c * h_c + p.Ie * s * s
    inverse = _nine(work, _INVERSE)
    G = _nine(work, G_AT)
    scalars = (1.0 / inertia_gamma, 1.0 / inertia_psi, 1.0 / p.Iz, c)
    return scalars, (p.m * dh_c, p.m * h_c, p.m * dz_c), inverse, G


@inlined
def _nine(work, at):
    return (
        work[at], work[at + 1], work[at + 2], work[at + 3], work[at + 4], work[at + 5],
        work[at + 6], work[at + 7], work[at + 8],
    )  # fmt: skip


@inlined
def _solve(factors, r_gamma, r_psi, r_phi, r_h, r_e, r_z):
    """Return the six equations' answer to one right side: 3 accelerations, 3 reactions."""
    (over_gamma, over_psi, over_phi, c), (m_dh, m_h, m_dz), inverse, G = factors
    free_gamma = r_gamma * over_gamma
    free_psi = (r_psi - c * r_phi) * over_psi
    k0 = m_dh * free_gamma - r_h
    k1 = m_h * free_psi - r_e
    k2 = m_dz * free_gamma - r_z
    N_K = inverse[0] * k0 + inverse[1] * k1 + inverse[2] * k2
    N_B1 = inverse[3] * k0 + inverse[4] * k1 + inverse[5] * k2
    N_B2 = inverse[6] * k0 + inverse[7] * k1 + inverse[8] * k2
    Q_gamma = r_gamma + G[0] * N_K + G[1] * N_B1 + G[2] * N_B2
    Q_psi = r_psi + G[3] * N_K + G[4] * N_B1 + G[5] * N_B2
    Q_phi = r_phi + G[6] * N_K + G[7] * N_B1 + G[8] * N_B2
    psi = (Q_psi - c * Q_phi) * over_psi
    return Q_gamma * over_gamma, psi, Q_phi * over_phi - c * psi, N_K, N_B1, N_B2


@compiled
def _wrench_in_hez(p, geo, x, u, work):
    """Turn the applied wrench to (h, e, z), with gravity; the rotation stays in the workspace."""
    s, c = geo.s, geo.c
    sp, cp = sin(x[2]), cos(x[2])
    spsi, cpsi = sin(x[1]), cos(x[1])
    r = _ROTATION
    r00, r01, r02, r10, r11, r20, r21, r22 = hez_rotation(s, c, sp, cp)
    work[r], work[r + 1], work[r + 2] = r00, r01, r02
    work[r + 3], work[r + 4], work[r + 5] = r10, r11, 0.0
    work[r + 6], work[r + 7], work[r + 8] = r20, r21, r22
    F_h = work[r] * u[0] + work[r + 1] * u[1] + work[r + 2] * u[2]
    F_e = work[r + 3] * u[0] + work[r + 4] * u[1]
    F_z = work[r + 6] * u[0] + work[r + 7] * u[1] + work[r + 8] * u[2]
    M_h = work[r] * u[3] + work[r + 1] * u[4] + work[r + 2] * u[5]
    M_e = work[r + 3] * u[3] + work[r + 4] * u[4]
    M_z = work[r + 6] * u[3] + work[r + 7] * u[4] + work[r + 8] * u[5]
    weight_h = p.m * (cpsi * p.g_x + spsi * p.g_y)
    weight_e = p.m * (cpsi * p.g_y - spsi * p.g_x)
    return AppliedLoad(Wrench(F_h, F_e, F_z, M_h, M_e, M_z), weight_h, weight_e, p.m * p.g_z)


@compiled
def pose_of(
    p: SceneScalars,
    x: np.ndarray | tuple[float, float, float],
    u: np.ndarray,
    work: np.ndarray,
) -> tuple[ClosedForms, Wrench]:
    """Return what the six equations take from angles and wrench."""
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, x[0])
    return geo, _wrench_with_weight(_wrench_in_hez(p, geo, x, u, work))


@compiled
def accelerate(
    p: SceneScalars,
    scales: np.ndarray | tuple[float, float, float],
    x: np.ndarray,
    u: np.ndarray,
    work: np.ndarray,
    y: np.ndarray,
) -> float:
    """
    Solve the six equations at one state.

    Parameters
    ----------
    p : SceneScalars
    scales : ndarray or tuple, shape (3,)
        Velocity scales of friction at K, B1, B2 [m/s].
    x : ndarray, shape (6,)
        gamma, psi, phi [rad] and their rates [rad/s].
    u : ndarray, shape (6,)
        Applied force and moment about the mass centre, peg axes [N], [N m].
    work : ndarray
        From `workspace`.
    y : ndarray, shape (6,)
        Filled with gamma'', psi'', phi'' [rad/s^2], N_K, N_B1, N_B2 [N]; NaN at gamma <= gamma0.

    Returns
    -------
    float
        Determinant over its frictionless value; see `reference.ContactSolution`.

    """
    geo, wrench = pose_of(p, x, u, work)
    rates = (x[3], x[4], x[5])
    equations(p, scales, geo, rates, wrench, work)
    determinant = _eliminate(p, geo, work)
    factors, r = _factors(p, geo, work), R_AT
    y[0], y[1], y[2], y[3], y[4], y[5] = _solve(
        factors, work[r], work[r + 1], work[r + 2], work[r + 3], work[r + 4], work[r + 5]
    )
    return determinant


@compiled
def determinant_at(
    p: SceneScalars,
    scales: np.ndarray | tuple[float, float, float],
    gamma: float,
    rates: tuple[float, float, float],
    work: np.ndarray,
) -> float:
    """Return the determinant over its frictionless value, as of `accelerate`; no wrench enters."""
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, gamma)
    nothing = Wrench(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    equations(p, scales, geo, rates, nothing, work)
    return _eliminate(p, geo, work)


@compiled
def accelerate_with_derivatives(
    p: SceneScalars,
    scales: np.ndarray | tuple[float, float, float],
    x: np.ndarray,
    u: np.ndarray,
    work: np.ndarray,
    y: np.ndarray,
    dy: np.ndarray,
) -> float:
    """
    Solve the six equations at one state, with exact derivatives.

    Parameters
    ----------
    p, scales, x, u, work, y
        As for `accelerate`.
    dy : ndarray, shape (6, 14)
        Filled with dy/d(gamma, psi, phi, gamma', psi', phi'), dy/d(wrench in peg axes) and
        dy/d(friction, peg diameter).

    Returns
    -------
    float
        As for `accelerate`.

    """
    determinant = accelerate(p, scales, x, u, work, y)
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, x[0])
    load = _wrench_in_hez(p, geo, x, u, work)
    answer, rates = (y[0], y[1], y[2], y[3], y[4], y[5]), (x[3], x[4], x[5])
    _fill_slopes(p, scales, rates, geo, load, answer, work, dy)
    return determinant


@inlined
def _fill_slopes(p, scales, rates, geo, load, answer, work, dy):
    """Fill in dy = inv(A) (dr - dA y) of the six equations A y = r at their answer y."""
    F_h, F_e, F_z, M_h, M_e, M_z = load.applied
    wrench, factors = _wrench_with_weight(load), _factors(p, geo, work)
    slopes = work[DERIVATIVES_AT : DERIVATIVES_AT + 36]
    derivatives(p, scales, geo, rates, wrench, answer, slopes)

    s, c = geo.s, geo.c
    # The wrench turns with gamma about eps = -e: (F_h, F_e, F_z) -> (-F_z, 0, F_h).
    _wrench_column(geo, (-F_z, 0.0, F_h, -M_z, 0.0, M_h), work, 0)
    # Only gravity depends on psi.
    _wrench_column(geo, (load.weight_e, -load.weight_h, 0.0, 0.0, 0.0, 0.0), work, 1)
    # The wrench turns with phi about zeta = (-s, 0, c).
    by_phi = (
        -c * F_e, c * F_h + s * F_z, -s * F_e,
        -c * M_e, c * M_h + s * M_z, -s * M_e,
    )  # fmt: skip
    _wrench_column(geo, by_phi, work, 2)
    for i in range(6):
        row = _COLUMNS + JACOBIAN_WIDTH * i
        work[row] -= slopes[6 * i + BY_GAMMA]
        for j in range(3):
            work[row + 3 + j] = -slopes[6 * i + BY_RATES + j]
        work[row + 12] = -slopes[6 * i + BY_FRICTION]
        work[row + 13] = -slopes[6 * i + BY_PEG_DIAMETER]
    for j in range(3):
        r_h, r_e, r_z = work[_ROTATION + j], work[_ROTATION + 3 + j], work[_ROTATION + 6 + j]
        _wrench_column(geo, (r_h, r_e, r_z, 0.0, 0.0, 0.0), work, 6 + j)
        _wrench_column(geo, (0.0, 0.0, 0.0, r_h, r_e, r_z), work, 9 + j)
    for j in range(JACOBIAN_WIDTH):
        at = _COLUMNS + j
        (
            work[at], work[at + 14], work[at + 28], work[at + 42], work[at + 56], work[at + 70],
        ) = _solve(
            factors,
            work[at], work[at + 14], work[at + 28], work[at + 42], work[at + 56], work[at + 70],
        )  # fmt: skip
    for i in range(6):
        for j in range(JACOBIAN_WIDTH):
            dy[i, j] = work[_COLUMNS + JACOBIAN_WIDTH * i + j]


@inlined
def _wrench_column(geo, wrench, work, column):
    """Put the six equations' right side for a wrench in (h, e, z) into a column."""
    F_h, F_e, F_z, M_h, M_e, M_z = wrench
    s, c, h_c, dh_c, dz_c = geo.s, geo.c, geo.h_c, geo.dh_c, geo.dz_c
    at = _COLUMNS + column
    work[at] = F_h * dh_c + F_z * dz_c - M_e
    work[at + JACOBIAN_WIDTH] = F_e * h_c + M_z
    work[at + 2 * JACOBIAN_WIDTH] = c * M_z - s * M_h
    work[at + 3 * JACOBIAN_WIDTH] = F_h
    work[at + 4 * JACOBIAN_WIDTH] = F_e
    work[at + 5 * JACOBIAN_WIDTH] = F_z
