"""
Two-point contact below gamma0: K on the rim, B (the peg's lower edge) on the wall of the hole.

Two contacts leave four freedoms: gamma, psi, phi and `lateral` = beta, the place of B on the wall
from the plane of tilt. Where symmetry keeps beta = 0, a multiplier takes the place of beta'': a
force along e at O, where the axes cross, which does no work on gamma, psi and phi. In three-point
contact N_B1 - N_B2 is that same force. At beta = 0 the closed forms of h_c and z_c are those of
three-point contact: the pose runs smoothly through gamma0.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from paper import jet
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.checks import require_finite
from peg_on_hole_ros.mechanics.reference import precession_axes, wrench_axes
from peg_on_hole_ros.mechanics.scene import Scene


class TwoPointPose(NamedTuple):
    """
    The pose in (h, e, z), with derivatives by (gamma, beta).

    Attributes
    ----------
    center : tuple of 3 Jet
        Mass centre [m].
    points, normals : ndarray, shape (2, 3)
        K and B [m]; unit normals on the peg.
    alpha : float
        Place of K on the rim, from -h [rad].

    """

    center: tuple
    points: np.ndarray
    normals: np.ndarray
    alpha: float


class TwoPointSolution(NamedTuple):
    """
    Motion and reactions in two-point contact.

    Attributes
    ----------
    acceleration : ndarray, shape (4,)
        gamma'', psi'', phi'', beta'' [rad/s^2]; beta'' is zero where it is held.
    normal : ndarray, shape (2,)
        N_K, N_B [N].
    lateral_force : float
        Multiplier Lambda: force along e at O that holds beta [N]; zero where free.
    slip_speed : ndarray, shape (2,)
        [m/s].

    """

    acceleration: np.ndarray
    normal: np.ndarray
    lateral_force: float
    slip_speed: np.ndarray


def insertion_length(scene: Scene, gamma: float | np.ndarray) -> np.ndarray:
    """Return l = (D - d cos(gamma))/sin(gamma), along the peg's side up to K [m]. Source: T1."""
    d, D = scene.peg_diameter, scene.hole_diameter
    return ((D - d) + 2 * d * np.sin(np.asarray(gamma) / 2) ** 2) / np.sin(gamma)


def two_point_pose(scene: Scene, gamma: float, lateral: float = 0.0) -> TwoPointPose:
    """
    Return the pose with K on the rim and B on the wall.

    Parameters
    ----------
    scene : Scene
    gamma : float
        Tilt [rad], below gamma0, and such that K still lies on the peg's side: l <= H.
    lateral : float
        beta [rad], |beta| < pi/4.

    Returns
    -------
    TwoPointPose

    Raises
    ------
    PegOnHoleError
        Where there is no such contact.

    Notes
    -----
    Seen along the hole, the peg's cut with the rim's plane is an ellipse of half-axes d/(2c) and
    d/2, its lower edge one of c d/2 and d/2; each touches the circle D/2 from inside, at the
    angles pi + alpha and beta. Their centres share the coordinate along e, which gives alpha.

    Source: T1 to T3.

    """
    _check(scene, gamma, lateral)
    R, D, H_c = scene.peg_diameter / 2, scene.hole_diameter, scene.mass_center_height
    tilt, beta = jet.variables(float(gamma), float(lateral))
    s, c = tilt.sin(), tilt.cos()
    sb, cb = beta.sin(), beta.cos()
    rho = (c * c * cb * cb + sb * sb).sqrt()
    y = sb * (D / 2 - R / rho)
    sa = _place_of_K(y, c, R, D)
    ca = (1 - sa * sa).sqrt()
    rho_K = (ca * ca + c * c * sa * sa).sqrt()
    pierce_h = ca * (R / (c * rho_K) - D / 2)
    end_h = cb * (D / 2 - R * c * c / rho)
    length = (end_h - pierce_h) / s
    center = (end_h - H_c * s, y, (H_c - length) * c)
    K = [-D / 2 * ca.v, -D / 2 * sa.v, 0.0]
    B = [D / 2 * cb.v, D / 2 * sb.v, float((R * c * s * cb / rho - length * c).v)]
    n_K = np.array([ca.v, sa.v, ca.v * s.v / c.v])
    normals = np.array([n_K / np.linalg.norm(n_K), [-cb.v, -sb.v, 0.0]])
    return TwoPointPose(center, np.array([K, B]), normals, float(np.arcsin(sa.v)))


def _place_of_K(y, c, R, D):
    """Return sin(alpha) where the peg's cut, its centre y off, touches the rim."""
    sa = jet.Jet(0.0, np.zeros(2), np.zeros((2, 2)))
    # Newton's steps in jets: after the value has settled, two more make both derivatives exact.
    settled = 0
    for _ in range(60):
        rho = (1 - sa * sa + c * c * sa * sa).sqrt()
        gap = sa * (D / 2 - R * c / rho) + y
        slope = D / 2 - R * c.v / rho.v - R * c.v * sa.v**2 * (1 - c.v**2) / rho.v**3
        step = gap.v / slope
        sa = sa - gap / slope
        settled += abs(step) < 1e-15 * (1 + abs(sa.v))
        if settled == 3:
            break
    return sa


def _check(scene, gamma, lateral):
    gamma0 = scene.gamma0
    if not np.isfinite(gamma) or not 0 < gamma <= gamma0:
        raise PegOnHoleError(
            f"gamma = {gamma:g} rad has no two-point contact of rim and wall: it must lie within "
            f"0 and {gamma0:.9g} rad (gamma0 = acos(d/D)); above, the contact is three-point"
        )
    length = insertion_length(scene, gamma)
    if length > scene.peg_height:
        raise PegOnHoleError(
            f"gamma = {gamma:g} rad puts K {length:.4g} m up the peg's side, beyond peg_height = "
            f"{scene.peg_height:g} m: a tilt as small as this leaves the peg free in the hole"
        )
    if not np.isfinite(lateral) or abs(lateral) > np.pi / 4:
        raise PegOnHoleError(
            f"lateral = {lateral:g} rad is not within -0.785 to 0.785 rad: B is close to "
            "the plane of tilt; measure psi anew"
        )


def solve_two_point(
    scene: Scene,
    q: ArrayLike,
    rates: ArrayLike,
    wrench_P: ArrayLike,
    slip_velocity_scale: float = 0.0,
    held: bool = False,
) -> TwoPointSolution:
    """
    Return motion and reactions in two-point contact, by Newton's and Euler's equations.

    Parameters
    ----------
    scene : Scene
    q, rates : array_like, shape (4,)
        gamma, psi, phi, beta [rad] and their rates [rad/s]; with `held`, beta = beta' = 0.
    wrench_P : array_like, shape (6,)
        Applied force and moment about the mass centre, peg axes [N], [N m].
    slip_velocity_scale : float
        Of the regularised friction law [m/s]; 0 is Coulomb's.
    held : bool
        Whether beta stays 0 by a lateral force, which is returned.

    Returns
    -------
    TwoPointSolution

    Raises
    ------
    PegOnHoleError
        Where the pose has no two-point contact, or beta is held off zero.

    Source: T1 to T4.

    """
    q = require_finite("state", "rad", q, 4)
    rates = require_finite("rates", "rad/s", rates, 4)
    wrench_P = require_finite("wrench", "N, N m", wrench_P, 6)
    gamma, psi, phi, beta = q
    dgamma, dpsi, dphi, dbeta = rates
    if held and (beta or dbeta):
        raise PegOnHoleError(
            f"lateral = {beta:g} rad moving at {dbeta:g} rad/s cannot be held at 0: set both to 0"
        )
    pose = two_point_pose(scene, gamma, beta)
    m, Ie, Iz = scene.peg_mass, scene.transverse_inertia, scene.axial_inertia
    s, c = np.sin(gamma), np.cos(gamma)
    z, eps = np.array([0.0, 0, 1]), np.array([0.0, -1, 0])
    zeta, eta = np.array([-s, 0, c]), np.array([c, 0, s])
    C = np.array([x.v for x in pose.center])
    slope = np.array([x.g for x in pose.center])
    inner = np.array([dgamma, dbeta])
    bend = np.array([inner @ x.h @ inner for x in pose.center])
    v_rel = slope @ inner
    omega = dgamma * eps + dpsi * z + dphi * zeta
    v_C = v_rel + dpsi * np.cross(z, C)

    # Accelerations: linear in (gamma'', psi'', phi'', beta''), and the rest.
    linear = np.column_stack([slope[:, 0], np.cross(z, C), np.zeros(3), slope[:, 1]])
    angular = np.column_stack([eps, z, zeta, np.zeros(3)])
    a_rest = bend + 2 * dpsi * np.cross(z, v_rel) + dpsi**2 * np.cross(z, np.cross(z, C))
    alpha_rest = -dphi * dgamma * eta + dpsi * np.cross(z, dgamma * eps + dphi * zeta)
    inertia = Ie * np.eye(3) + (Iz - Ie) * np.outer(zeta, zeta)

    arms = pose.points - C
    v = v_C + np.cross(omega, arms)
    speed = np.sqrt(np.sum(v * v, axis=1) + slip_velocity_scale**2)
    u = v / np.where(speed == 0, 1, speed)[:, None]
    reaction = pose.normals - scene.friction * u

    to_hez = wrench_axes(gamma, phi)
    F = to_hez @ wrench_P[:3] + m * precession_axes(psi).T @ np.asarray(scene.gravity)
    M = to_hez @ wrench_P[3:]
    A = np.zeros((6, 6))
    A[:3, :4], A[:3, 4:] = m * linear, -reaction.T
    A[3:, :4], A[3:, 4:] = inertia @ angular, -np.cross(arms, reaction).T
    if held:
        # -e and -(O - C) x e, with O = (0, 0, a1) where the axes cross.
        a1 = C[2] + C[0] * c / s
        A[:, 3] = [0, -1, 0, a1 - C[2], 0, C[0]]
    gyro = np.cross(omega, inertia @ omega)
    r = np.concatenate([F - m * a_rest, M - inertia @ alpha_rest - gyro])
    y = np.linalg.solve(A, r)
    acceleration = np.array([*y[:3], 0.0 if held else y[3]])
    return TwoPointSolution(
        acceleration, y[4:], float(y[3]) if held else 0.0, np.linalg.norm(v, axis=1)
    )
