"""A peg that the holder guides: its motion is given, the wrench follows by Newton and Euler."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.sim.command import evaluate
from peg_on_hole_ros.sim.dynamics import angular_velocity, rotation, three_points
from peg_on_hole_ros.sim.holder import cross, mass_centre


class Guidance(NamedTuple):
    """
    A guided motion: the holder's program, and a difference that fades.

    Attributes
    ----------
    t0 : float
        When guidance takes over [s].
    fade : ndarray, shape (6, 6)
        Quintics from the true pose less the commanded one, at t0, to zero.
    settle : float
        When the difference is gone, after t0 [s].
    touching : bool
        True: the offset from the touching pose is zero, whatever the program presses.

    """

    t0: float
    fade: np.ndarray
    settle: float
    touching: bool


def guided_state(
    knots: np.ndarray, coefficients: np.ndarray, guidance: Guidance | None, t: float
) -> np.ndarray:
    """
    Return angles and offset with rates and accelerations, shape (3, 6), as `command.evaluate`.

    Parameters
    ----------
    knots, coefficients : ndarray
        The holder's program.
    guidance : Guidance or None
        None: exactly the program.
    t : float
        [s]

    """
    x = evaluate(knots, coefficients, t)
    if guidance is None:
        return x
    if guidance.touching:
        x[:, 3:] = 0
    if t - guidance.t0 < guidance.settle:
        x += evaluate(np.zeros(1), guidance.fade[None], t - guidance.t0)
    return x


@compiled
def hole_axes(psi: float, v: np.ndarray) -> np.ndarray:
    """Return a vector of (h, e, z) in hole axes, shape (3,)."""
    s, c = np.sin(psi), np.cos(psi)
    return np.array([c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]])


@compiled
def guided_contacts(
    p: np.ndarray, x: np.ndarray, loaded: int, normal: np.ndarray, scale: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Return the contacts of a guided peg that touches in K and at one place of its lower edge.

    Above gamma0 that is B1 or B2 of the three-point pose, below it the far wall.

    Parameters
    ----------
    p : ndarray
        Scene.
    x : ndarray, shape (3, 6)
        From `guided_state`.
    loaded : int
        1 or 2: which of B1, B2 carries.
    normal : ndarray, shape (3,)
        Reactions at K, B1, B2 [N].
    scale : float
        Of the regularised friction law [m/s].

    Returns
    -------
    points, forces : ndarray, shape (3, 3)
        Rows K, B1, B2, hole axes [m], [N].
    slip_speed : ndarray, shape (3,)
        [m/s]; 0 at a contact without load.

    """
    d, D, f = p[0], p[1], p[6]
    s, c = np.sin(x[0, 0]), np.cos(x[0, 0])
    points, n = np.zeros((3, 3)), np.zeros((3, 3))
    points[0, 0] = -D / 2
    n[0, 0], n[0, 2] = c, s
    if x[0, 0] > p[7]:
        g = three_points(p, x[0, 0])
        a1, S1, b = g[2], g[4], g[6]
        to_O = np.sqrt(S1 * S1 + b * b + a1 * a1)
        for i in range(1, 3):
            e = -b if i == 1 else b
            points[i] = np.array([S1, e, 0.0])
            n[i] = np.array([-S1 / to_O, -e / to_O, a1 / to_O])
    else:
        depth = (d * (1 + c * c) / 2 - D * c) / s + d * s / 2
        for i in range(1, 3):
            points[i] = np.array([D / 2, 0.0, depth])
            n[i] = np.array([-1.0, 0.0, 0.0])
    centre = mass_centre(p, x)
    w = angular_velocity(x[0, :3], x[1, :3])
    forces, slip = np.zeros((3, 3)), np.zeros(3)
    for i in range(3):
        points[i] = hole_axes(x[0, 1], points[i])
        if i in (0, loaded):
            n_H = hole_axes(x[0, 1], n[i])
            v = centre[1] + cross(w, points[i] - centre[0])
            v = v - np.sum(v * n_H) * n_H
            slip[i] = np.sqrt(np.sum(v * v))
            forces[i] = normal[i] * (n_H - f * v / np.sqrt(slip[i] ** 2 + scale * scale))
    return points, forces, slip


@compiled
def newton_euler(
    p: np.ndarray, x: np.ndarray, points: np.ndarray, forces: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the wrench about the mass centre that moves the peg so, hole axes.

    Parameters
    ----------
    p : ndarray
        Scene.
    x : ndarray, shape (3, 6)
        Angles and offset with rates and accelerations.
    points, forces : ndarray, shape (3, 3)
        Of the contacts, hole axes [m], [N].

    Returns
    -------
    F, M : ndarray, shape (3,)
        What the holder exerts on the peg, besides gravity and contacts [N], [N m].

    """
    m, Ie, Iz = p[3], p[4], p[5]
    centre = mass_centre(p, x)
    zeta = rotation(x[0, :3])[:, 2].copy()
    w = angular_velocity(x[0, :3], x[1, :3])
    sp, cp = np.sin(x[0, 1]), np.cos(x[0, 1])
    eps = np.array([sp, -cp, 0.0])
    deps = x[1, 1] * np.array([cp, sp, 0.0])
    dzeta = cross(w, zeta)
    alpha = x[2, 0] * eps + x[1, 0] * deps + x[2, 2] * zeta + x[1, 2] * dzeta
    alpha[2] += x[2, 1]
    spin = np.sum(w * zeta)
    dL = Ie * alpha + (Iz - Ie) * (np.sum(alpha * zeta) * zeta + spin * dzeta)
    F = m * (centre[2] - p[8:11])
    M = dL
    for i in range(3):
        F = F - forces[i]
        M = M - cross(points[i] - centre[0], forces[i])
    return F, M
