"""
Contacts that can open: which of K, B1, B2 carry load, by complementarity.

A contact presses (N > 0) or parts (its gap accelerates open), never both. With sliding friction
the problem may have one answer, several, or none: none is where rigid motion ends (Painleve).
"""

from enum import Enum
from itertools import product
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
from peg_on_hole_ros.mechanics.reference import Outcome, precession_axes
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.records import CONTACTS

AXIS_E, AXIS_Z = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])


class Existence(Enum):
    """How many motions rigid contact with friction allows; the values are advice."""

    ONE = "one motion"
    SEVERAL = "several motions: rigid bodies leave it open which; compliance decides"
    NONE = "no motion: the peg jams, only an impact or compliance resolves it"


class Mode(NamedTuple):
    """
    One consistent motion.

    Attributes
    ----------
    closed : tuple of bool
        K, B1, B2.
    normal : ndarray, shape (3,)
        [N]; zero at open contacts.
    parting : ndarray, shape (3,)
        Acceleration of each gap [m/s^2]; zero at closed contacts.
    acceleration : ndarray, shape (6,)
        Of the mass centre and angular, in (h, e, z) [m/s^2], [rad/s^2].
    rates_change : ndarray, shape (3,) or None
        gamma'', psi'', phi'' [rad/s^2] where all three stay closed.

    """

    closed: tuple[bool, bool, bool]
    normal: np.ndarray
    parting: np.ndarray
    acceleration: np.ndarray
    rates_change: np.ndarray | None


class UnilateralSolution(NamedTuple):
    """
    All consistent motions at one state.

    Attributes
    ----------
    modes : tuple of Mode
        Most closed contacts first.
    existence : Existence
    outcome : Outcome
        Of the first mode; WEDGED where there is none.
    opened : tuple of str
        Names of the contacts that open in the first mode.

    """

    modes: tuple[Mode, ...]
    existence: Existence
    outcome: Outcome
    opened: tuple[str, ...]


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


def solve_unilateral(
    scene: Scene,
    q: ArrayLike,
    rates: ArrayLike,
    force_H: ArrayLike,
    moment_H: ArrayLike,
    slip_velocity_scale: float = 0.0,
) -> UnilateralSolution:
    """
    Return every motion that sliding friction and one-sided contacts allow.

    Parameters
    ----------
    scene : Scene
    q, rates : array_like, shape (3,)
        State with three closed contacts: gamma, psi, phi [rad] and their rates [rad/s].
    force_H, moment_H : array_like, shape (3,)
        Applied at the mass centre, hole axes, without gravity [N], [N m].
    slip_velocity_scale : float
        Of the regularised friction law [m/s]. Under Coulomb's law, 0, a contact at rest has no
        friction here.

    Returns
    -------
    UnilateralSolution

    Notes
    -----
    Gap accelerations are w = W N + w0, W = J inv(M) R with the normals J and the reactions R;
    0 <= N, 0 <= w, N w = 0. All eight choices of closed contacts are tried: that finds every
    solution, which a pivoting method does not.

    """
    body = free_body(scene, q, rates, force_H, moment_H)
    speed = np.sqrt(np.sum(body.velocity**2, axis=1) + slip_velocity_scale**2)
    u = body.velocity / np.where(speed == 0, 1, speed)[:, None]
    J = np.array([wrench_of(a, n) for a, n in zip(body.arms, body.normals)])
    R = np.array([wrench_of(a, n) for a, n in zip(body.arms, body.normals - scene.friction * u)]).T
    push = np.linalg.solve(body.mass, R)
    free = np.linalg.solve(body.mass, body.load)
    W, w0 = J @ push, J @ (free - body.drift)
    size = scene.peg_mass * np.linalg.norm(w0) + 1e-12
    modes = []
    for closed in sorted(product((True, False), repeat=3), key=lambda x: -sum(x)):
        on = np.array(closed)
        N = np.zeros(3)
        if on.any():
            block = W[np.ix_(on, on)]
            if abs(np.linalg.det(block)) < 1e-14 * np.prod(np.abs(np.diag(block))):
                continue
            N[on] = np.linalg.solve(block, -w0[on])
        parting = np.where(on, 0.0, W @ N + w0)
        if np.all(-1e-12 * size <= N) and np.all(parting >= -1e-9 * np.max(np.abs(w0))):
            acceleration = free + push @ N
            change = None
            if on.all():
                change = np.linalg.lstsq(body.freedom, acceleration - body.drift, rcond=None)[0]
            modes.append(Mode(closed, np.maximum(N, 0), parting, acceleration, change))  # type: ignore[arg-type]
    if not modes:
        return UnilateralSolution((), Existence.NONE, Outcome.WEDGED, ())
    existence = Existence.ONE if len(_distinct(modes)) == 1 else Existence.SEVERAL
    opened = tuple(name for name, on in zip(CONTACTS, modes[0].closed) if not on)
    outcome = Outcome.CONTACT_OPEN if opened else Outcome.THREE_POINT
    return UnilateralSolution(tuple(modes), existence, outcome, opened)


def _distinct(modes):
    """Return the modes that differ in their accelerations: an N of zero fits two choices."""
    kept = []
    for mode in modes:
        size = 1e-9 * (1 + np.max(np.abs(mode.acceleration)))
        if all(np.max(np.abs(mode.acceleration - x.acceleration)) > size for x in kept):
            kept.append(mode)
    return kept
