"""
The rungs: six models of the peg on three contacts, from cheapest to full, compiled.

All answer one question through one call, `answer(rung, p, scales, x, u, work, y)`: accelerations
and reactions at a state under a wrench. Rungs that leave a freedom out hold its rate: its
acceleration is zero. The numpy twins, made of the six equations by taking rows and columns away,
are in `ladder.reference`.

Parameters of every rung
------------------------
p : SceneScalars
scales : ndarray, shape (3,)
    Velocity scales of friction at K, B1, B2 [m/s].
x : ndarray, shape (6,)
    gamma, psi, phi [rad] and their rates [rad/s].
u : ndarray, shape (6,)
    Applied force and moment about the mass centre, peg axes [N], [N m].

Each returns gamma'', psi'', phi'' [rad/s^2], N_K, N_B1, N_B2 [N]; not finite where gamma is not
above gamma0, or where the rung's own equations are singular.
"""

from math import cos, fabs, sin, sqrt

from peg_on_hole_ros.ladder.opened import open_contacts
from peg_on_hole_ros.mechanics import geometry
from peg_on_hole_ros.mechanics.kernel import accelerate, compiled, inlined

SMALL_ANGLE, QUASI_STATIC, ALIGN, ALIGN_SLIP, DYNAMIC, MODES = range(6)
RUNGS = ("small_angle", "quasi_static", "align", "align_slip", "dynamic", "modes")

# Inlined, what a rung does not use of the geometry is not computed.
_closed_forms = inlined(geometry.closed_forms)


@inlined
def _force(p, x, u, s, c):
    """Return applied force and weight in (h, e, z), and the sine and cosine of phi."""
    sphi, cphi = sin(x[2]), cos(x[2])
    across = cphi * u[0] - sphi * u[1]
    F_h = c * across - s * u[2]
    F_e = sphi * u[0] + cphi * u[1]
    F_z = s * across + c * u[2] + p.m * p.g_z
    # A vertical hole, the common case, needs no psi.
    if p.g_x != 0.0 or p.g_y != 0.0:
        spsi, cpsi = sin(x[1]), cos(x[1])
        F_h += p.m * (cpsi * p.g_x + spsi * p.g_y)
        F_e += p.m * (cpsi * p.g_y - spsi * p.g_x)
    return F_h, F_e, F_z, sphi, cphi


@inlined
def _over(scale, v_h, v_e, v_z, f):
    """Return the friction coefficient over the regularised slip speed."""
    return f / sqrt(scale * scale + v_h * v_h + v_e * v_e + v_z * v_z)


@inlined
def _solve(k00, k01, k02, k10, k11, k12, k20, k21, k22, r0, r1, r2):
    """Return the solution of three equations, by cofactors."""
    c00, c01, c02 = k11 * k22 - k12 * k21, k12 * k20 - k10 * k22, k10 * k21 - k11 * k20
    over = 1.0 / (k00 * c00 + k01 * c01 + k02 * c02)
    return (
        over * (c00 * r0 + (k02 * k21 - k01 * k22) * r1 + (k01 * k12 - k02 * k11) * r2),
        over * (c01 * r0 + (k00 * k22 - k02 * k20) * r1 + (k02 * k10 - k00 * k12) * r2),
        over * (c02 * r0 + (k01 * k20 - k00 * k21) * r1 + (k00 * k11 - k01 * k10) * r2),
    )


@inlined
def force_columns(p, scales, x, s, c, a1, S1, S2, b, over_OB):
    """Return the forces of unit reactions with their friction, rows h, e, z, columns K, B1, B2."""
    dgamma, dpsi, dphi = x[3], x[4], x[5]
    rise, spin = 2.0 * a1 * dgamma, b * dphi
    v_h, v_e, v_z = rise, -0.5 * (p.D * dpsi + p.d * dphi), -rise * c / s
    t = _over(scales[0], v_h, v_e, v_z, p.f)
    K_h, K_e, K_z = c - t * v_h, -t * v_e, s - t * v_z
    around, up = S1 * dpsi + S2 * dphi, 2.0 * S1 * dgamma
    v_h, v_z = rise + b * dpsi + c * spin, up + s * spin
    t = _over(scales[1], v_h, around, v_z, p.f)
    n_h, n_e, n_z = -S1 * over_OB, b * over_OB, a1 * over_OB
    P_h, P_e, P_z = n_h - t * v_h, n_e - t * around, n_z - t * v_z
    v_h, v_z = rise - b * dpsi - c * spin, up - s * spin
    t = _over(scales[2], v_h, around, v_z, p.f)
    Q_h, Q_e, Q_z = n_h - t * v_h, -n_e - t * around, n_z - t * v_z
    return K_h, P_h, Q_h, K_e, P_e, Q_e, K_z, P_z, Q_z


@inlined
def _carrying(W, F_h, F_e, F_z):
    """Return the reactions that carry a force, given `force_columns`."""
    return _solve(W[0], W[1], W[2], W[3], W[4], W[5], W[6], W[7], W[8], -F_h, -F_e, -F_z)


@inlined
def small_angle(p, scales, x, u):
    """Return the quasi-static balance to leading order in gamma (eqs. (30)-(36), corrected)."""
    g = x[0]
    ratio = p.gamma0 / g
    part = ratio * ratio
    above = (g - p.gamma0) * (g + p.gamma0) / (g * g)
    beta = sqrt(above * (1.0 + part))
    half = 0.5 * p.D
    a1 = 0.5 * half * g * above
    F_h, F_e, F_z, _, _ = _force(p, x, u, g, 1.0)
    # Well above gamma0 the square of gamma is as large as that of gamma0/gamma.
    S1, S2, b = half * (part + 0.25 * g * g), half * (part - 0.25 * g * g), half * beta
    W = force_columns(p, scales, x, g, 1.0, a1, S1, S2, b, 1.0 / half)
    N = _carrying(W, F_h, F_e, F_z)
    return 0.0, 0.0, 0.0, N[0], N[1], N[2]


@inlined
def quasi_static(p, scales, x, u):
    """Return the balance of forces at the exact pose, all inertia left out."""
    s, c, a1, _, S1, S2, b, _, _, _, _, _, _, _ = _closed_forms(p.d, p.D, p.H_c, p.gamma0, x[0])
    F_h, F_e, F_z, _, _ = _force(p, x, u, s, c)
    over_OB = 1.0 / sqrt(0.25 * p.D * p.D + a1 * a1)
    W = force_columns(p, scales, x, s, c, a1, S1, S2, b, over_OB)
    N = _carrying(W, F_h, F_e, F_z)
    return 0.0, 0.0, 0.0, N[0], N[1], N[2]


@inlined
def _tilting(p, x, u, geo):
    """Return what turns and moves the peg with gamma alone: inertia, torque, forces, moments."""
    s, c, _, _, _, _, _, _, _, _, dh_c, dz_c, ddh_c, ddz_c = geo
    F_h, F_e, F_z, sphi, cphi = _force(p, x, u, s, c)
    square = p.m * x[3] * x[3]
    M_e = sphi * u[3] + cphi * u[4]
    inertia = p.m * (dh_c * dh_c + dz_c * dz_c) + p.Ie
    r_h, r_z = F_h - ddh_c * square, F_z - ddz_c * square
    # The forces' part of the velocity terms is in r_h and r_z already.
    return inertia, r_h * dh_c + r_z * dz_c - M_e, r_h, F_e, r_z


@inlined
def align(p, scales, x, u):
    """Return motion and reactions with gamma as the only freedom: slip and slide left out."""
    geo = _closed_forms(p.d, p.D, p.H_c, p.gamma0, x[0])
    s, c, a1, _, S1, _, b, _, _, _, dh_c, dz_c, _, _ = geo
    inertia, torque, r_h, r_e, r_z = _tilting(p, x, u, geo)
    over_OB = 1.0 / sqrt(0.25 * p.D * p.D + a1 * a1)
    # K slides along the peg, both B across it; speeds per rate are the levers of friction.
    lever_K, lever_B = 2.0 * a1 / s, 2.0 * sqrt(a1 * a1 + S1 * S1)
    v_K, v_B = lever_K * x[3], lever_B * x[3]
    f_K = v_K * _over(scales[0], v_K, 0.0, 0.0, p.f)
    f_B = v_B * _over(scales[1], v_B, 0.0, 0.0, p.f)
    m_h, m_z = p.m * dh_c / inertia, p.m * dz_c / inertia
    K_h = c - f_K * s + m_h * f_K * lever_K
    K_z = s + f_K * c + m_z * f_K * lever_K
    B_h = -S1 * over_OB - f_B * 2.0 * a1 / lever_B + m_h * f_B * lever_B
    B_z = a1 * over_OB - f_B * 2.0 * S1 / lever_B + m_z * f_B * lever_B
    k_h, k_z = m_h * torque - r_h, m_z * torque - r_z
    over = 1.0 / (K_h * B_z - K_z * B_h)
    N_K, both = (k_h * B_z - k_z * B_h) * over, (K_h * k_z - K_z * k_h) * over
    difference = -r_e / (b * over_OB)
    acceleration = (torque - f_K * lever_K * N_K - f_B * lever_B * both) / inertia
    return acceleration, 0.0, 0.0, N_K, 0.5 * (both + difference), 0.5 * (both - difference)


@inlined
def align_slip(p, scales, x, u):
    """Return motion and reactions with gamma and phi as freedoms: the slide psi left out."""
    geo = _closed_forms(p.d, p.D, p.H_c, p.gamma0, x[0])
    s, c, a1, _, S1, S2, b, _, _, _, dh_c, dz_c, _, _ = geo
    inertia, torque, r_h, r_e, r_z = _tilting(p, x, u, geo)
    over_OB = 1.0 / sqrt(0.25 * p.D * p.D + a1 * a1)
    dgamma, dphi = x[3], x[5]
    rise, spin, up, around = 2.0 * a1 * dgamma, b * dphi, 2.0 * S1 * dgamma, S2 * dphi
    v_h, v_e, v_z = rise, -0.5 * p.d * dphi, -rise * c / s
    t = _over(scales[0], v_h, v_e, v_z, p.f)
    K_h, K_e, K_z = c - t * v_h, -t * v_e, s - t * v_z
    # Friction times how its contact moves with gamma, and with phi.
    K_gamma, K_phi = -t * 2.0 * a1 * (v_h - v_z * c / s), t * 0.5 * p.d * v_e
    v_h, v_z = rise + c * spin, up + s * spin
    t = _over(scales[1], v_h, around, v_z, p.f)
    n_h, n_e, n_z = -S1 * over_OB, b * over_OB, a1 * over_OB
    P_h, P_e, P_z = n_h - t * v_h, n_e - t * around, n_z - t * v_z
    P_gamma = -t * 2.0 * (a1 * v_h + S1 * v_z)
    P_phi = -t * (b * (c * v_h + s * v_z) + S2 * around)
    v_h, v_z = rise - c * spin, up - s * spin
    t = _over(scales[2], v_h, around, v_z, p.f)
    Q_h, Q_e, Q_z = n_h - t * v_h, -n_e - t * around, n_z - t * v_z
    Q_gamma = -t * 2.0 * (a1 * v_h + S1 * v_z)
    Q_phi = -t * (S2 * around - b * (c * v_h + s * v_z))
    m_h, m_z = p.m * dh_c / inertia, p.m * dz_c / inertia
    N_K, N_P, N_Q = _solve(
        K_h - m_h * K_gamma, P_h - m_h * P_gamma, Q_h - m_h * Q_gamma,
        K_e, P_e, Q_e,
        K_z - m_z * K_gamma, P_z - m_z * P_gamma, Q_z - m_z * Q_gamma,
        m_h * torque - r_h, -r_e, m_z * torque - r_z,
    )  # fmt: skip
    # The moment along the peg's axis does not turn with tilt and slip.
    turning = u[5] + K_phi * N_K + P_phi * N_P + Q_phi * N_Q
    tilting = torque + K_gamma * N_K + P_gamma * N_P + Q_gamma * N_Q
    return tilting / inertia, 0.0, turning / p.Iz, N_K, N_P, N_Q


@inlined
def reduced(rung, p, scales, x, u):
    """Return the answer of a rung up to `align_slip`, as 6 floats."""
    if rung == SMALL_ANGLE:
        return small_angle(p, scales, x, u)
    if rung == QUASI_STATIC:
        return quasi_static(p, scales, x, u)
    if rung == ALIGN:
        return align(p, scales, x, u)
    return align_slip(p, scales, x, u)


@compiled
def answer(rung, p, scales, x, u, work, y):
    """
    Fill y with a rung's accelerations and reactions, shape (6,); see the module.

    Returns
    -------
    bool
        Whether all are finite.

    """
    if rung <= ALIGN_SLIP:
        y[0], y[1], y[2], y[3], y[4], y[5] = reduced(rung, p, scales, x, u)
    else:
        accelerate(p, scales, x, u, work, y)
        if rung == MODES and min(y[3], y[4], y[5]) < 0.0:
            open_contacts(p, scales, x, u, y)
    # A sum is finite only if all of its terms are.
    return fabs(y[0] + y[1] + y[2] + y[3] + y[4] + y[5]) < 1e300
