"""
Velocities, direction cosines and generalised forces at the contacts, in every frame of the paper.

Angles, rates and reactions may be scalars or arrays over time; components come first, time last.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.any_side import frame_axes
from peg_on_hole_ros.mechanics.checks import require_finite
from peg_on_hole_ros.mechanics.geometry import (
    ContactGeometry,
    contact_geometry,
    normals,
    velocity_jacobians,
)
from peg_on_hole_ros.mechanics.reference import (
    precession_axes,
    product,
    slip_directions,
    wrench_axes,
)
from peg_on_hole_ros.mechanics.scene import Scene

MOTIONS = {"align": 0, "slide": 1, "slip": 2}


class InstantCenter(NamedTuple):
    """
    Instant centre of the planar motion.

    Attributes
    ----------
    L : ndarray, shape (3, ...)
        In (h, e, z) [m].
    KL, BL : ndarray
        Its distance from K, and from B in the plane of symmetry [m].

    """

    L: np.ndarray
    KL: np.ndarray
    BL: np.ndarray


class GeneralizedForces(NamedTuple):
    """
    Right sides of Lagrange's equations, each part with rows gamma, psi, phi [N m].

    Attributes
    ----------
    applied, gravity : ndarray, shape (3, ...)
    friction : ndarray, shape (3, 3, ...)
        [contact, row].

    """

    applied: np.ndarray
    gravity: np.ndarray
    friction: np.ndarray


def instant_center(g: ContactGeometry) -> InstantCenter:
    """Return the instant centre of the planar motion. Source: G17; eq. (10)."""
    L = np.array([-g.S1, 0 * g.s, 2 * g.a1])
    return InstantCenter(L, 2 * g.a1 / g.s, 2 * np.sqrt(g.a1**2 + g.S1**2))


def contact_velocities(
    scene: Scene, q: ArrayLike, rates: ArrayLike, frame: str = "hole", motion: str | None = None
) -> np.ndarray:
    """
    Return the velocities of the peg's material points at K, B1, B2.

    Parameters
    ----------
    scene : Scene
    q, rates : array_like, shape (3, ...)
        gamma, psi, phi [rad] and their rates [rad/s].
    frame : str
        See `frame_axes`.
    motion : {None, "align", "slide", "slip"}
        One motion alone, V^gamma, V^psi or V^phi; None for the whole.

    Returns
    -------
    ndarray, shape (3, 3, ...)
        [contact, component] [m/s].

    Source: V2; eqs. (10)-(18) for one motion, (19) hole, (20) moving, (21) auxiliary.

    """
    q, rates = _states(q, rates)
    J = velocity_jacobians(contact_geometry(scene, q[0]), scene.peg_diameter, scene.hole_diameter)
    if motion is not None:
        if motion not in MOTIONS:
            raise PegOnHoleError(f"motion = {motion!r} is none of {', '.join(MOTIONS)}")
        chosen = np.zeros(3)
        chosen[MOTIONS[motion]] = 1
        rates = (rates.T * chosen).T
    v = np.einsum("icj...,j...->ic...", J, rates)
    return _to_frame(v, frame, q)


def normal_cosines(scene: Scene, q: ArrayLike, frame: str = "hole") -> np.ndarray:
    """
    Return the direction cosines of the normal reactions at K, B1, B2.

    Returns
    -------
    ndarray, shape (3, 3, ...)
        [contact, component]; along x, y, z these are cos alpha, cos beta, cos lambda.

    Source: V3; eqs. (8), (9), (31).

    """
    q, _ = _states(q, np.zeros(3))
    return _to_frame(normals(contact_geometry(scene, q[0])), frame, q)


def friction_cosines(
    scene: Scene,
    q: ArrayLike,
    rates: ArrayLike,
    frame: str = "hole",
    slip_velocity_scale: float = 0.0,
) -> np.ndarray:
    """
    Return friction over f N at K, B1, B2: direction cosines opposite to the velocities.

    Parameters
    ----------
    scene, q, rates, frame
        As for `contact_velocities`.
    slip_velocity_scale : float
        Of the regularised friction law [m/s]; 0 is Coulomb's, under which a contact at rest gives
        zeros: its friction has no direction.

    Returns
    -------
    ndarray, shape (3, 3, ...)
        [contact, component].

    Source: V4; eq. (22).

    """
    q, rates = _states(q, rates)
    J = velocity_jacobians(contact_geometry(scene, q[0]), scene.peg_diameter, scene.hole_diameter)
    u, _ = slip_directions(J, rates, slip_velocity_scale)
    return _to_frame(-u, frame, q)


def generalized_forces(
    scene: Scene,
    q: ArrayLike,
    rates: ArrayLike,
    normal: ArrayLike,
    wrench_P: ArrayLike = (0, 0, 0, 0, 0, 0),
    slip_velocity_scale: float = 0.0,
) -> GeneralizedForces:
    """
    Return the right sides of Lagrange's equations; the normal reactions do no work.

    Parameters
    ----------
    scene, q, rates, slip_velocity_scale
        As for `friction_cosines`.
    normal : array_like, shape (3, ...)
        N_K, N_B1, N_B2 [N].
    wrench_P : array_like, shape (6, ...)
        Applied force and moment about the mass centre, peg axes [N], [N m].

    Returns
    -------
    GeneralizedForces

    Source: V5; eqs. (24), (27).

    """
    q, rates = _states(q, rates)
    g = contact_geometry(scene, q[0])
    to_hez = wrench_axes(q[0] + 0 * q[2], q[2] + 0 * q[0])
    wrench_P = np.asarray(wrench_P, float)
    F, M = product(to_hez, wrench_P[:3]), product(to_hez, wrench_P[3:])
    weight = np.einsum(
        "ij...,i->j...", precession_axes(q[1] + 0 * q[0]), np.asarray(scene.gravity)
    )
    weight = scene.peg_mass * weight

    def of_force(force):
        return np.array(
            [force[0] * g.dh_c + force[2] * g.dz_c, force[1] * g.h_c, 0 * force[0] * g.s]
        )

    moment = np.array([-M[1], M[2], g.c * M[2] - g.s * M[0]])
    J = velocity_jacobians(g, scene.peg_diameter, scene.hole_diameter)
    u, _ = slip_directions(J, rates, slip_velocity_scale)
    friction = -scene.friction * np.einsum("i...,ic...->ic...", np.asarray(normal, float), u)
    return GeneralizedForces(
        of_force(F) + moment, of_force(weight), np.einsum("icj...,ic...->ij...", J, friction)
    )


def overall_reaction(scene: Scene, normal: ArrayLike) -> np.ndarray:
    """Return R = N sqrt(1 + f^2) of a sliding contact, with its friction [N]. Source: L7."""
    return np.asarray(normal) * np.sqrt(1 + scene.friction**2)


def _states(q, rates):
    q = require_finite("state", "rad", q, 3)
    rates = require_finite("rates", "rad/s", rates, 3)
    rows = np.broadcast_arrays(*q, *rates)
    return np.stack(rows[:3]), np.stack(rows[3:])


def _to_frame(vectors, frame, q):
    return np.einsum("kc...,ic...->ik...", frame_axes(frame, q), vectors)
