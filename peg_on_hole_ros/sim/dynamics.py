"""The six equations of `mechanics.reference` as compiled scalars, for the truth's integrator."""

import numpy as np

from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.mechanics.scene import Scene

# Closer to gamma0 than this [rad] a trial state of the integrator is taken back to it.
TILT_FLOOR = 1e-10


def scene_numbers(scene: Scene) -> np.ndarray:
    """Return the scene as d, D, height of the mass centre, m, Ie, Iz, f, gamma0, g_x, g_y, g_z."""
    return np.array(
        [
            scene.peg_diameter,
            scene.hole_diameter,
            scene.mass_center_height,
            scene.peg_mass,
            scene.transverse_inertia,
            scene.axial_inertia,
            scene.friction,
            scene.gamma0,
            *scene.gravity,
        ]
    )


@compiled
def rotation(q: np.ndarray) -> np.ndarray:
    """Return R_HP = Rz(psi) Ry(-gamma) Rz(phi), shape (3, 3)."""
    s, c = np.sin(q[0]), np.cos(q[0])
    sp, cp = np.sin(q[1]), np.cos(q[1])
    sf, cf = np.sin(q[2]), np.cos(q[2])
    R = np.empty((3, 3))
    R[0, 0] = cp * c * cf - sp * sf
    R[0, 1] = -cp * c * sf - sp * cf
    R[0, 2] = -cp * s
    R[1, 0] = sp * c * cf + cp * sf
    R[1, 1] = -sp * c * sf + cp * cf
    R[1, 2] = -sp * s
    R[2, 0] = s * cf
    R[2, 1] = -s * sf
    R[2, 2] = c
    return R


@compiled
def angular_velocity(q: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Return omega = gamma' eps + psi' z + phi' zeta in hole axes [rad/s], shape (3,)."""
    s, c, sp, cp = np.sin(q[0]), np.cos(q[0]), np.sin(q[1]), np.cos(q[1])
    return np.array(
        [
            rates[0] * sp - rates[2] * s * cp,
            -rates[0] * cp - rates[2] * s * sp,
            rates[1] + rates[2] * c,
        ]
    )


@compiled
def angular_acceleration(q: np.ndarray, rates: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    """Return the rate of `angular_velocity` in hole axes [rad/s^2], shape (3,)."""
    sp, cp = np.sin(q[1]), np.cos(q[1])
    zeta = rotation(q)[:, 2].copy()
    w = angular_velocity(q, rates)
    out = acceleration[0] * np.array([sp, -cp, 0.0])
    out += rates[0] * rates[1] * np.array([cp, sp, 0.0])
    out += acceleration[2] * zeta
    out[0] += rates[2] * (w[1] * zeta[2] - w[2] * zeta[1])
    out[1] += rates[2] * (w[2] * zeta[0] - w[0] * zeta[2])
    out[2] += rates[2] * (w[0] * zeta[1] - w[1] * zeta[0])
    out[2] += acceleration[1]
    return out


@compiled
def three_points(p: np.ndarray, gamma: float) -> tuple[float, ...]:
    """
    Return the geometry of three-point contact.

    Parameters
    ----------
    p : ndarray
        From `scene_numbers`.
    gamma : float
        Tilt [rad]; below gamma0 + TILT_FLOOR it is taken back to that.

    Returns
    -------
    tuple of float
        s, c, a1, a2, S1, S2, b, h_c, z_c, h_c', z_c', h_c'', z_c'' as in `mechanics.geometry`.

    """
    d, D, height, gamma0 = p[0], p[1], p[2], p[7]
    gamma = max(gamma, gamma0 + TILT_FLOOR)
    s, c = np.sin(gamma), np.cos(gamma)
    a1 = D * np.sin((gamma + gamma0) / 2) * np.sin((gamma - gamma0) / 2) / s
    a2 = ((D - d) + 2 * d * np.sin(gamma / 2) ** 2) / (2 * s)
    S1 = D / 2 - 2 * c * a1 / s
    S2 = d / 2 - 2 * a1 / s
    b = 2 * np.sqrt(c * a1 * a2) / s
    h_c = -(height - a2) * s
    z_c = (height - a2) * c + a1
    dh_c = 2 * a1 - z_c
    dz_c = h_c + S1
    return s, c, a1, a2, S1, S2, b, h_c, z_c, dh_c, dz_c, 2 * a2 / s - dz_c, dh_c - 2 * S2 / s


@compiled
def contacts(
    p: np.ndarray, q: np.ndarray, rates: np.ndarray, scale: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """
    Return what is known of the contacts from the state alone, in (h, e, z).

    Parameters
    ----------
    p, q, rates : ndarray
        Scene, gamma, psi, phi [rad] and their rates [rad/s].
    scale : float
        Slip speed at which friction reaches 71 % of f N [m/s].

    Returns
    -------
    points, velocities, directions : ndarray, shape (3, 3)
        Rows K, B1, B2 [m], [m/s]; a contact's force is its normal reaction times its direction
        (normal and friction together).
    jacobians : ndarray, shape (3, 3, 3)
        dv_i/d(gamma', psi', phi').

    """
    s, c, a1, a2, S1, S2, b, h_c, z_c, dh_c, dz_c, ddh_c, ddz_c = three_points(p, q[0])
    d, D, f = p[0], p[1], p[6]
    points = np.zeros((3, 3))
    J = np.zeros((3, 3, 3))
    direction = np.zeros((3, 3))
    points[0, 0] = -D / 2
    J[0, 0, 0], J[0, 2, 0] = 2 * a1, -2 * a1 * c / s
    J[0, 1, 1], J[0, 1, 2] = -D / 2, -d / 2
    direction[0, 0], direction[0, 2] = c, s
    to_O = np.sqrt(S1 * S1 + b * b + a1 * a1)
    for i in range(1, 3):
        e = -b if i == 1 else b
        points[i, 0], points[i, 1] = S1, e
        J[i, 0, 0], J[i, 2, 0] = 2 * a1, 2 * S1
        J[i, 0, 1], J[i, 1, 1] = -e, S1
        J[i, 0, 2], J[i, 1, 2], J[i, 2, 2] = -e * c, S2, -e * s
        direction[i, 0], direction[i, 1], direction[i, 2] = -S1 / to_O, -e / to_O, a1 / to_O
    velocity = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            velocity[i, j] = J[i, j, 0] * rates[0] + J[i, j, 1] * rates[1] + J[i, j, 2] * rates[2]
        speed = np.sqrt(np.sum(velocity[i] ** 2) + scale * scale)
        for j in range(3):
            direction[i, j] -= f * velocity[i, j] / speed
    return points, velocity, direction, J


@compiled
def six_equations(
    p: np.ndarray, q: np.ndarray, rates: np.ndarray, F: np.ndarray, M: np.ndarray, scale: float
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the equations of motion as A y = r; see `mechanics.reference.six_equations`.

    Parameters
    ----------
    p, q, rates : ndarray
        Scene, gamma, psi, phi [rad] and their rates [rad/s].
    F, M : ndarray, shape (3,)
        Applied at and about the mass centre without gravity, hole axes [N], [N m].
    scale : float
        Of the regularised friction law [m/s].

    Returns
    -------
    A : ndarray, shape (6, 6)
    r : ndarray, shape (6,)

    """
    m, Ie, Iz = p[3], p[4], p[5]
    dg, dp, df = rates
    s, c, a1, a2, S1, S2, b, h_c, z_c, dh_c, dz_c, ddh_c, ddz_c = three_points(p, q[0])
    points, velocity, direction, J = contacts(p, q, rates, scale)
    sp, cp = np.sin(q[1]), np.cos(q[1])
    G0, G1, G2 = F[0] + m * p[8], F[1] + m * p[9], F[2] + m * p[10]
    Fh, Fe, Fz = cp * G0 + sp * G1, -sp * G0 + cp * G1, G2
    Mh, Me, Mz = cp * M[0] + sp * M[1], -sp * M[0] + cp * M[1], M[2]
    k = m * h_c * dh_c + (Ie - Iz) * s * c
    A = np.zeros((6, 6))
    r = np.empty(6)
    A[0, 0] = m * (dh_c * dh_c + dz_c * dz_c) + Ie
    A[1, 1] = m * h_c * h_c + Ie * s * s + Iz * c * c
    A[1, 2] = A[2, 1] = Iz * c
    A[2, 2] = Iz
    A[3, 0], A[4, 1], A[5, 0] = m * dh_c, m * h_c, m * dz_c
    for i in range(3):
        for j in range(3):
            A[3 + j, 3 + i] = -direction[i, j]
            # v.n = 0 for every rate, so J^T takes the friction out of the whole force.
            A[j, 3 + i] = -(
                J[i, 0, j] * direction[i, 0]
                + J[i, 1, j] * direction[i, 1]
                + J[i, 2, j] * direction[i, 2]
            )
    r[0] = Fh * dh_c + Fz * dz_c - Me
    r[0] -= m * (dh_c * ddh_c + dz_c * ddz_c) * dg * dg - k * dp * dp + Iz * s * dp * df
    r[1] = Fe * h_c + Mz - 2 * k * dg * dp + Iz * s * dg * df
    r[2] = -Mh * s + Mz * c + Iz * s * dg * dp
    r[3] = Fh - m * (ddh_c * dg * dg - h_c * dp * dp)
    r[4] = Fe - 2 * m * dh_c * dg * dp
    r[5] = Fz - m * ddz_c * dg * dg
    return A, r


@compiled
def solve6(A: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Return y of A y = r by elimination with partial pivoting; A and r are overwritten."""
    n = r.size
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(A[i, k]) > abs(A[pivot, k]):
                pivot = i
        if pivot != k:
            for j in range(k, n):
                A[k, j], A[pivot, j] = A[pivot, j], A[k, j]
            r[k], r[pivot] = r[pivot], r[k]
        for i in range(k + 1, n):
            factor = A[i, k] / A[k, k]
            if factor != 0.0:
                for j in range(k + 1, n):
                    A[i, j] -= factor * A[k, j]
                r[i] -= factor * r[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            r[k] -= A[k, j] * r[j]
        r[k] /= A[k, k]
    return r


@compiled
def motion(
    p: np.ndarray, q: np.ndarray, rates: np.ndarray, F: np.ndarray, M: np.ndarray, scale: float
) -> np.ndarray:
    """Return gamma'', psi'', phi'' [rad/s^2], N_K, N_B1, N_B2 [N], shape (6,)."""
    A, r = six_equations(p, q, rates, F, M, scale)
    return solve6(A, r)


@compiled
def determinant(p: np.ndarray, q: np.ndarray, rates: np.ndarray, scale: float) -> float:
    """
    Return the determinant of the six equations over its frictionless value.

    1 without friction; at 0 rigid sliding has no solution any more, beyond it wedges.
    """
    zero = np.zeros(3)
    frictionless = p.copy()
    frictionless[6] = 0.0
    A, _ = six_equations(p, q, rates, zero, zero, scale)
    A0, _ = six_equations(frictionless, q, rates, zero, zero, scale)
    return np.linalg.det(A) / np.linalg.det(A0)
