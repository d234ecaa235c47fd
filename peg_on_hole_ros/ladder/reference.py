"""The rungs in numpy, made of the six equations by taking rows and columns away: to be read."""

import numpy as np

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.ladder.rungs import RUNGS
from peg_on_hole_ros.mechanics.reference import (
    peg_axes,
    precession_axes,
    six_equations,
    wrench_axes,
)
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.mechanics.unilateral import solve_unilateral

# Places of the freedoms among gamma, psi, phi that a rung keeps.
FREEDOMS = {
    "quasi_static": (), "align": (0,), "align_slip": (0, 2), "dynamic": (0, 1, 2),
}  # fmt: skip


def answer(rung: str, scene: Scene, q, rates, wrench_P, slip_velocity_scale=0.0) -> np.ndarray:
    """
    Return accelerations and reactions of a rung.

    Parameters
    ----------
    rung : str
        Of RUNGS.
    scene : Scene
    q, rates : array_like, shape (3,)
        gamma, psi, phi [rad] and their rates [rad/s].
    wrench_P : array_like, shape (6,)
        Applied force and moment about the mass centre, peg axes [N], [N m].
    slip_velocity_scale : float
        Of the regularised friction law [m/s].

    Returns
    -------
    ndarray, shape (6,)
        gamma'', psi'', phi'' [rad/s^2], N_K, N_B1, N_B2 [N].

    """
    q, rates, wrench_P = (np.asarray(value, float) for value in (q, rates, wrench_P))
    if rung not in RUNGS:
        raise PegOnHoleError(f"model = {rung!r} is none of {', '.join(RUNGS)}")
    if rung == "small_angle":
        return _small_angle(scene, q, rates, wrench_P, slip_velocity_scale)
    if rung == "modes":
        return _modes(scene, q, rates, wrench_P, slip_velocity_scale)
    free = FREEDOMS[rung]
    held = [i for i in range(3) if i not in free]
    slow = rates.copy()
    if free:
        slow[held] = 0.0
    A, r = six_equations(scene, q, slow, wrench_P, slip_velocity_scale)
    if not free:
        # Friction against the slip, and no inertia: the forces are those of a peg at rest.
        _, r = six_equations(scene, q, 0 * rates, wrench_P, slip_velocity_scale)
    kept = [*free, 3, 4, 5]
    y = np.zeros(6)
    y[kept] = np.linalg.solve(A[np.ix_(kept, kept)], r[kept])
    return y


def _small_angle(scene, q, rates, wrench_P, scale):
    """Return the balance of forces with every length to leading order in gamma."""
    gamma, psi, phi = q
    dgamma, dpsi, dphi = rates
    D, gamma0 = scene.hole_diameter, scene.gamma0
    share = (gamma0 / gamma) ** 2
    S1, S2 = D / 2 * (share + gamma**2 / 4), D / 2 * (share - gamma**2 / 4)
    b = D / 2 * np.sqrt(1 - share**2)
    a1 = D / 4 * gamma * (1 - share)
    turn = wrench_axes(gamma, phi)
    # sin(gamma) = gamma, cos(gamma) = 1.
    turn = np.array([[np.cos(phi), -np.sin(phi), -gamma], turn[1],
                     [gamma * np.cos(phi), -gamma * np.sin(phi), 1]])  # fmt: skip
    F = turn @ wrench_P[:3] + scene.peg_mass * precession_axes(psi).T @ np.array(scene.gravity)
    n = np.array([[1, 0, gamma], [-S1, b, a1], [-S1, -b, a1]])
    n[1:] /= D / 2
    v = np.array([[2 * a1 * dgamma, -(D * dpsi + scene.peg_diameter * dphi) / 2,
                   -2 * a1 * dgamma / gamma]]
                 + [[2 * a1 * dgamma + e * (dpsi + dphi), S1 * dpsi + S2 * dphi,
                     2 * S1 * dgamma + e * gamma * dphi] for e in (b, -b)])  # fmt: skip
    speed = np.sqrt(np.sum(v**2, axis=1) + scale**2)
    w = n - scene.friction * v / np.where(speed == 0, 1, speed)[:, None]
    return np.concatenate([np.zeros(3), np.linalg.solve(w.T, -F)])


def _modes(scene, q, rates, wrench_P, scale):
    A, r = six_equations(scene, q, rates, wrench_P, scale)
    y = np.linalg.solve(A, r)
    if np.min(y[3:]) >= 0:
        return y
    R_HP = peg_axes(q)
    found = solve_unilateral(scene, q, rates, R_HP @ wrench_P[:3], R_HP @ wrench_P[3:], scale)
    if not found.modes:
        return np.full(6, np.nan)
    mode = found.modes[0]
    # From the angular acceleration to those of the angles: what the rates alone make is taken off.
    s, c = np.sin(q[0]), np.cos(q[0])
    eps, z, zeta = np.array([0.0, -1, 0]), np.array([0.0, 0, 1]), np.array([-s, 0, c])
    eta = np.array([c, 0, s])
    by_rates = rates[1] * np.cross(z, rates[0] * eps + rates[2] * zeta)
    by_rates = by_rates - rates[2] * rates[0] * eta
    axes = np.column_stack([eps, z, zeta])
    change = np.linalg.solve(axes, mode.acceleration[3:] - by_rates)
    return np.concatenate([change, mode.normal])
