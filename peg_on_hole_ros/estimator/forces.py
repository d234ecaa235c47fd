"""Forces at the contacts that go with given reactions, and what a rim has to carry at all."""

from math import cos, sin, sqrt

from peg_on_hole_ros.estimator.record import SCALES, WORK, U, X
from peg_on_hole_ros.mechanics.kernel import closed_forms, compiled, equations, scene_of


@compiled
def tilt_on_contacts(p, gamma):
    """Return the tilt, kept where the closed forms of the geometry exist [rad]."""
    return min(max(gamma, p.gamma0 * (1.0 + 1e-9)), 1.5)


@compiled
def contact_forces(p, m, gamma, out, normal, force, point):
    """
    Fill in force on the peg (normal and friction) and place of each contact, hole axes.

    Parameters
    ----------
    p : SceneScalars
    m : ndarray
        Memory, of which psi and the rates are used.
    gamma : float
        Tilt at which the contacts are taken [rad].
    out : ndarray
        Read and filled at three places.
    normal, force, point : int
        Places of N_K, N_B1, N_B2 (3) [N], which are given; of the forces (3, 3) [N] and of the
        points (3, 3) [m], rows K, B1, B2.

    """
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, gamma)
    wrench = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    rates = (m[X + 3], m[X + 4], m[X + 5])
    scales, work = m[SCALES : SCALES + 3], m[WORK:]
    equations(p.m, p.Ie, p.Iz, p.f, p.d, p.D, scales, geo, rates, wrench, work)
    s, c = sin(m[X + 1]), cos(m[X + 1])
    for i in range(3):
        # Places 9 to 17 hold normal plus friction direction, rows h, e, z.
        f_h, f_e, f_z = work[9 + i], work[12 + i], work[15 + i]
        N, at = out[normal + i], force + 3 * i
        if N == 0.0:
            # No force has no direction, and is none also where friction's is no number.
            out[at] = out[at + 1] = out[at + 2] = 0.0
        else:
            out[at], out[at + 1], out[at + 2] = (
                N * (c * f_h - s * f_e),
                N * (s * f_h + c * f_e),
                N * f_z,
            )
        r_h = -0.5 * p.D if i == 0 else geo[4]
        r_e = 0.0 if i == 0 else (-geo[6] if i == 1 else geo[6])
        at = point + 3 * i
        out[at], out[at + 1], out[at + 2] = c * r_h - s * r_e, s * r_h + c * r_e, 0.0


@compiled
def rim_load(m):
    """Return the sizes of the force [N] and of the couple [N m] that a rim has to carry."""
    p = scene_of(m)
    s, c = sin(m[X]), cos(m[X])
    spsi, cpsi, sphi, cphi = sin(m[X + 1]), cos(m[X + 1]), sin(m[X + 2]), cos(m[X + 2])
    g_h, g_e = cpsi * p.g_x + spsi * p.g_y, cpsi * p.g_y - spsi * p.g_x
    # Gravity in peg axes: across the tilt, along eps, along the axis.
    across = c * g_h + s * p.g_z
    F_x = m[U] + p.m * (cphi * across + sphi * g_e)
    F_y = m[U + 1] + p.m * (cphi * g_e - sphi * across)
    F_z = m[U + 2] + p.m * (c * p.g_z - s * g_h)
    couple = m[U + 3] * m[U + 3] + m[U + 4] * m[U + 4] + m[U + 5] * m[U + 5]
    return sqrt(F_x * F_x + F_y * F_y + F_z * F_z), sqrt(couple)
