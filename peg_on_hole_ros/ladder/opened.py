"""
Reactions where a contact opens, compiled: the choice of `mechanics.unilateral` as scalar code.

Off the hot path: it is asked only where the six equations give a negative reaction.
"""

from math import cos, fabs, nan, sin, sqrt

import numpy as np

from peg_on_hole_ros.mechanics.kernel import closed_forms, compiled, inlined

# Closed contacts K, B1, B2 as bits 1, 2, 4: three first, then pairs, as `unilateral` orders them.
_CHOICES = (7, 3, 5, 6, 1, 2, 4, 0)


@inlined
def _cross(a, b, out):
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@compiled
def open_contacts(p, scales, x, u, y):
    """
    Fill y with the first motion that sliding friction and one-sided contacts allow.

    Parameters
    ----------
    p, scales, x, u
        As for `rungs.answer`.
    y : ndarray, shape (6,)
        Filled with gamma'', psi'', phi'' [rad/s^2] (of the peg's axes, whatever holds it), N_K,
        N_B1, N_B2 [N], zero where open; NaN where there is no motion: the peg jams.

    """
    s, c, a1, _, S1, S2, b, _, h_c, z_c, dh_c, dz_c, ddh_c, ddz_c = closed_forms(
        p.d, p.D, p.H_c, p.gamma0, x[0]
    )
    dgamma, dpsi, dphi = x[3], x[4], x[5]
    eps, eta = np.array([0.0, -1.0, 0.0]), np.array([c, 0.0, s])
    zeta, axis = np.array([-s, 0.0, c]), np.array([0.0, 0.0, 1.0])
    side = np.empty(3)
    # Free acceleration of mass centre and axes, less what three closed contacts ask for.
    sphi, cphi, spsi, cpsi = sin(x[2]), cos(x[2]), sin(x[1]), cos(x[1])
    force, moment = np.empty(3), np.empty(3)
    for of, at in ((force, 0), (moment, 3)):
        across = cphi * u[at] - sphi * u[at + 1]
        of[0] = c * across - s * u[at + 2]
        of[1] = sphi * u[at] + cphi * u[at + 1]
        of[2] = s * across + c * u[at + 2]
    force[0] += p.m * (cpsi * p.g_x + spsi * p.g_y)
    force[1] += p.m * (cpsi * p.g_y - spsi * p.g_x)
    force[2] += p.m * p.g_z
    omega = dgamma * eps + dpsi * axis + dphi * zeta
    spin = (p.Iz - p.Ie) * (omega[0] * zeta[0] + omega[2] * zeta[2])
    _cross(omega, p.Ie * omega + spin * zeta, side)
    linear, angular = force / p.m, _turned(p, moment - side, zeta)
    drift, drift_angular = np.empty(3), np.empty(3)
    drift[0] = ddh_c * dgamma * dgamma - dpsi * dpsi * h_c
    drift[1] = 2.0 * dpsi * dgamma * dh_c
    drift[2] = ddz_c * dgamma * dgamma
    _cross(axis, dgamma * eps + dphi * zeta, side)
    drift_angular[:] = dpsi * side - dphi * dgamma * eta
    # What each reaction does to the two, and with what each gap opens.
    normal, push = np.zeros((3, 6)), np.empty((3, 6))
    over_OB = 1.0 / sqrt(0.25 * p.D * p.D + a1 * a1)
    arm, n, v = np.empty(3), np.empty(3), np.empty(3)
    for i in range(3):
        at = 0.0 if i == 0 else (-b if i == 1 else b)
        arm[0], arm[1], arm[2] = (-0.5 * p.D if i == 0 else S1) - h_c, at, -z_c
        if i == 0:
            n[0], n[1], n[2] = c, 0.0, s
            rise = 2.0 * a1 * dgamma
            v[0], v[1], v[2] = rise, -0.5 * (p.D * dpsi + p.d * dphi), -rise * c / s
        else:
            n[0], n[1], n[2] = -S1 * over_OB, -at * over_OB, a1 * over_OB
            v[0] = 2.0 * a1 * dgamma - at * (dpsi + c * dphi)
            v[1], v[2] = S1 * dpsi + S2 * dphi, 2.0 * S1 * dgamma - at * s * dphi
        speed = sqrt(scales[i] * scales[i] + v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
        reaction = n - v * (p.f / speed if speed > 0.0 else 0.0)
        normal[i, :3] = n
        _cross(arm, n, side)
        normal[i, 3:] = side
        _cross(arm, reaction, side)
        push[i, :3], push[i, 3:] = reaction / p.m, _turned(p, side, zeta)
    W, w = np.empty((3, 3)), np.empty(3)
    for i in range(3):
        w[i] = normal[i, :3] @ (linear - drift) + normal[i, 3:] @ (angular - drift_angular)
        for j in range(3):
            W[i, j] = normal[i, :3] @ push[j, :3] + normal[i, 3:] @ push[j, 3:]
    most = max(fabs(w[0]), fabs(w[1]), fabs(w[2]))
    size = p.m * most + 1e-12
    N = np.empty(3)
    for closed in _CHOICES:
        if _holds(closed, W, w, N, 1e-12 * size, 1e-9 * most):
            for i in range(3):
                N[i] = max(N[i], 0.0)
                angular += N[i] * push[i, 3:]
            angular -= drift_angular
            y[0], y[2] = -angular[1], -angular[0] / s
            y[1] = angular[2] - c * y[2]
            y[3], y[4], y[5] = N[0], N[1], N[2]
            return
    y[:] = nan


@inlined
def _turned(p, torque, zeta):
    """Return the angular acceleration of a moment."""
    along = (1.0 / p.Iz - 1.0 / p.Ie) * (torque[0] * zeta[0] + torque[2] * zeta[2])
    return torque / p.Ie + along * zeta


@compiled
def _holds(closed, W, w, N, pull, close):
    """Fill N for a choice of closed contacts; return whether none pulls and no gap closes."""
    block, right = W.copy(), -w
    scale = 1.0
    for i in range(3):
        if closed >> i & 1:
            scale *= fabs(W[i, i])
            continue
        # An open contact carries nothing.
        block[i, :] = 0.0
        block[:, i] = 0.0
        block[i, i], right[i] = 1.0, 0.0
    if fabs(np.linalg.det(block)) < 1e-14 * scale:
        return False
    N[:] = np.linalg.solve(block, right)
    for i in range(3):
        if not N[i] >= -pull:
            return False
        if (
            not closed >> i & 1
            and not W[i, 0] * N[0] + W[i, 1] * N[1] + W[i, 2] * N[2] + w[i] >= -close
        ):
            return False
    return True
