"""The paper's worked examples: imposed uniform alignment (2.6.1, Fig. 10) and the free one."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from paper import printed
from paper.two_point import two_point_pose
from peg_on_hole_ros.mechanics.checks import require_finite
from peg_on_hole_ros.mechanics.geometry import contact_geometry, normals, velocity_jacobians
from peg_on_hole_ros.mechanics.reference import six_equations, slip_directions
from peg_on_hole_ros.mechanics.scene import Scene


class Imposed(NamedTuple):
    """
    Imposed motion with constant rates under a pure couple.

    Attributes
    ----------
    normal : ndarray, shape (3, ...)
        N_K, N_B1, N_B2 [N]; a negative one would have to pull.
    couple : ndarray, shape (3, ...)
        Q_gamma, Q_psi, Q_phi that the couple must do [N m].

    """

    normal: np.ndarray
    couple: np.ndarray


def imposed(
    scene: Scene, gamma: float | np.ndarray, rates: ArrayLike, slip_velocity_scale: float = 0.0
) -> Imposed:
    """
    Return reactions and couple for constant rates, no applied force, psi = 0.

    Parameters
    ----------
    scene : Scene
    gamma : float or ndarray
        [rad].
    rates : array_like, shape (3,) or (3, ...)
        [rad/s].
    slip_velocity_scale : float
        [m/s].

    Returns
    -------
    Imposed

    Source: 2.6.1, with the corrected (28).

    """
    gamma = require_finite("gamma", "rad", gamma)
    rates = require_finite("rates", "rad/s", rates, 3)
    q = np.stack(np.broadcast_arrays(gamma, 0.0 * np.asarray(gamma), 0.0 * np.asarray(gamma)))
    A, r = six_equations(scene, q, rates, np.zeros(6), slip_velocity_scale)
    balance, right = np.moveaxis(A[3:, 3:], (0, 1), (-2, -1)), np.moveaxis(r[3:], 0, -1)
    N = np.moveaxis(np.linalg.solve(balance, right[..., None])[..., 0], -1, 0)
    return Imposed(N, np.einsum("ij...,j...->i...", A[:3, 3:], N) - r[:3])


def imposed_two_point(scene: Scene, gamma: float, rates: ArrayLike) -> np.ndarray:
    """
    Return N_K, N_B and the lateral force [N] for constant rates below gamma0, no applied force.

    Parameters
    ----------
    scene : Scene
    gamma : float
        [rad], up to gamma0; psi = 0, held symmetric.
    rates : array_like, shape (3,)
        [rad/s].

    Returns
    -------
    ndarray, shape (3,)

    Source: 2.6.2, for the other side of the transition.

    """
    dgamma, dpsi, dphi = require_finite("rates", "rad/s", rates, 3)
    pose = two_point_pose(scene, gamma)
    h, _, z = pose.center
    C = np.array([h.v, 0.0, z.v])
    slope, bend = np.array([h.g[0], 0, z.g[0]]), np.array([h.h[0, 0], 0, z.h[0, 0]])
    s, c = np.sin(gamma), np.cos(gamma)
    omega = np.array([-s * dphi, -dgamma, dpsi + c * dphi])
    turn = np.cross([0, 0, dpsi], C)
    v = slope * dgamma + turn + np.cross(omega, pose.points - C)
    speed = np.linalg.norm(v, axis=1)
    u = v / np.where(speed == 0, 1, speed)[:, None]
    acceleration = bend * dgamma**2 + 2 * dgamma * np.cross([0, 0, dpsi], slope)
    acceleration = acceleration + np.cross([0, 0, dpsi], turn)
    columns = np.column_stack([*(pose.normals - scene.friction * u), [0, 1, 0]])
    return np.linalg.solve(columns, scene.peg_mass * (acceleration - np.asarray(scene.gravity)))


# How (28.4)-(28.6) may be read: friction follows the rates that the print names (`literal`) or
# gamma' as closing speed (`closing`); friction in (28.6) with f or, as printed, without.
READINGS = (
    "corrected",
    "literal sign of gamma', f in (28.6)",
    "literal sign of gamma', no f in (28.6)",
    "closing speed in friction, no f in (28.6)",
    "literal sign of gamma', beta for lambda as in (23.3)",
    "(39) with the closing speed",
)


def figure_10(scene: Scene, gamma: float, rates: ArrayLike, reading: str) -> float:
    """
    Return the overall reaction at K over the weight, as one reading of the print gives it.

    Parameters
    ----------
    scene : Scene
    gamma : float
        [rad].
    rates : array_like, shape (3,)
        [rad/s]; psi' = 0.
    reading : str
        One of `READINGS`.

    Returns
    -------
    float
        n_K = N_K sqrt(1 + f^2)/(m g); its sign is that of N_K.

    """
    weight = -scene.peg_mass * scene.gravity[2]
    stretch = np.sqrt(1 + scene.friction**2) / weight
    rates = np.asarray(rates, float)
    if reading == "corrected":
        return float(imposed(scene, gamma, rates).normal[0] * stretch)
    if reading.startswith("(39)"):
        return float(printed.reaction(scene, rates * [-1, 1, 1]) * stretch)
    g, f = contact_geometry(scene, gamma), scene.friction
    sign = -1 if reading.startswith("literal") else 1
    J = velocity_jacobians(g, scene.peg_diameter, scene.hole_diameter)
    u, _ = slip_directions(J, rates * [sign, 1, 1], 0.0)
    columns = (normals(g) - f * u).T
    if "no f" in reading:
        columns[2] = normals(g)[:, 2] - u[:, 2]
    elif "beta" in reading:
        columns[2] = columns[1]
    m, p = scene.peg_mass, rates[0]
    right = np.array([m * g.ddh_c * p**2, 0, m * g.ddz_c * p**2 + weight])
    N, *_ = np.linalg.lstsq(columns, right, rcond=None)
    return float(N[0] * stretch)
