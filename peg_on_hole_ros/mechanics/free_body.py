"""The peg as a free body with six accelerations, and how three closed contacts would move it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.mechanics.checks import require_finite
from peg_on_hole_ros.mechanics.geometry import (
    contact_geometry,
    contact_points,
    normals,
    velocity_jacobians,
)
from peg_on_hole_ros.mechanics.reference import precession_axes
from peg_on_hole_ros.mechanics.scene import Scene

AXIS_E, AXIS_Z = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])


class FreeBody(NamedTuple):
    """
    One state, everything in (h, e, z); accelerations are (a_C, angular acceleration), shape (6,).

    Attributes
    ----------
    mass : ndarray, shape (6, 6)
        Mass and inertia about C.
    load : ndarray, shape (6,)
        Applied wrench, gravity, less the gyroscopic moment [N], [N m].
    arms, normals, velocity : ndarray, shape (3, 3)
        K, B1, B2: contact point from C [m]; unit normal on the peg; material velocity [m/s].
    velocity_rate : ndarray, shape (3, 3)
        Rate of change of the material velocity at the contact with three contacts closed and
        q'' = 0 [m/s^2].
    freedom : ndarray, shape (6, 3)
        Accelerations for unit gamma'', psi'', phi'' with three contacts closed.
    drift : ndarray, shape (6,)
        Accelerations with three contacts closed and q'' = 0.

    """

    mass: np.ndarray
    load: np.ndarray
    arms: np.ndarray
    normals: np.ndarray
    velocity: np.ndarray
    velocity_rate: np.ndarray
    freedom: np.ndarray
    drift: np.ndarray


def free_body(
    scene: Scene, q: ArrayLike, rates: ArrayLike, force_H: ArrayLike, moment_H: ArrayLike
) -> FreeBody:
    """
    Return the free body of a three-point pose.

    Parameters
    ----------
    scene : Scene
    q, rates : array_like, shape (3,)
        gamma, psi, phi [rad] and their rates [rad/s].
    force_H, moment_H : array_like, shape (3,)
        Applied at the mass centre, hole axes, without gravity [N], [N m].

    Raises
    ------
    PegOnHoleError
        Where an input is not finite, or the tilt has no three-point contact.

    """
    q = require_finite("state", "rad", q, 3)
    rates = require_finite("rates", "rad/s", rates, 3)
    force_H = require_finite("force", "N", force_H, 3)
    moment_H = require_finite("moment", "N m", moment_H, 3)
    g = contact_geometry(scene, q[0])
    dgamma, dpsi, dphi = rates
    s, c = g.s, g.c
    eps, eta, zeta = -AXIS_E, np.array([c, 0, s]), np.array([-s, 0, c])
    C = np.array([g.h_c, 0, g.z_c])
    slope, bend = np.array([g.dh_c, 0, g.dz_c]), np.array([g.ddh_c, 0, g.ddz_c])
    turn = np.cross(AXIS_Z, C)
    freedom = np.zeros((6, 3))
    freedom[:3, 0], freedom[:3, 1] = slope, turn
    freedom[3:] = np.column_stack([eps, AXIS_Z, zeta])
    sideways = np.cross(AXIS_Z, slope)
    drift = np.concatenate(
        [
            bend * dgamma**2 + 2 * dpsi * dgamma * sideways + dpsi**2 * np.cross(AXIS_Z, turn),
            -dphi * dgamma * eta + dpsi * np.cross(AXIS_Z, dgamma * eps + dphi * zeta),
        ]
    )
    inertia = scene.transverse_inertia * np.eye(3)
    inertia += (scene.axial_inertia - scene.transverse_inertia) * np.outer(zeta, zeta)
    mass = np.zeros((6, 6))
    mass[:3, :3], mass[3:, 3:] = scene.peg_mass * np.eye(3), inertia
    omega = freedom[3:] @ rates
    to_hez = precession_axes(q[1]).T
    load = np.concatenate(
        [
            to_hez @ (force_H + scene.peg_mass * np.asarray(scene.gravity)),
            to_hez @ moment_H - np.cross(omega, inertia @ omega),
        ]
    )
    d, D = scene.peg_diameter, scene.hole_diameter
    velocity = velocity_jacobians(g, d, D) @ rates
    step = velocity_jacobians(contact_geometry(scene, q[0] + 1e-30j), d, D).imag / 1e-30
    rate = step @ rates * dgamma + dpsi * np.cross(AXIS_Z, velocity)
    arms = contact_points(g, D) - C
    return FreeBody(mass, load, arms, normals(g), velocity, rate, freedom, drift)


def wrench_of(arm: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return a force at a contact as (force, moment about C), shape (6,)."""
    return np.concatenate([force, np.cross(arm, force)])


def sticking(body: FreeBody, rest_speed: float) -> np.ndarray:
    """Return which contacts are at rest, bool, shape (3,)."""
    return np.linalg.norm(body.velocity, axis=1) <= rest_speed
