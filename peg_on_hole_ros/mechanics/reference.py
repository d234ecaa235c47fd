"""The six differential equations of the peg on three contacts, to be read beside the paper."""

from collections.abc import Sequence
from dataclasses import replace
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.geometry import contact_geometry, normals, velocity_jacobians
from peg_on_hole_ros.mechanics.scene import Scene


class Outcome(Enum):
    """What a solution of the six equations means; the values are advice."""

    THREE_POINT = "three-point contact: all reactions press"
    CONTACT_OPEN = "a reaction is negative: that contact has opened, three-point contact is over"
    WEDGED = "friction is beyond its critical value: rigid three-point motion has no solution here"
    STUCK = "no contact slides: friction, and with it the reactions, is not determined"


class ContactSolution(NamedTuple):
    """
    Motion and reactions at one state.

    Attributes
    ----------
    acceleration : ndarray, shape (3,)
        gamma'', psi'', phi'' [rad/s^2].
    normal : ndarray, shape (3,)
        N_K, N_B1, N_B2 [N].
    slip_speed : ndarray, shape (3,)
        At K, B1, B2 [m/s].
    determinant : float
        Of the reactions' matrix over its value without friction; 1 without friction, 0 where
        rigid motion ends, negative beyond.
    critical_friction : float or None
        Smallest friction coefficient at which the determinant vanishes; None if there is none.
    outcome : Outcome

    """

    acceleration: np.ndarray
    normal: np.ndarray
    slip_speed: np.ndarray
    determinant: float
    critical_friction: float | None
    outcome: Outcome


def wrench_axes(gamma: float | np.ndarray, phi: float | np.ndarray) -> np.ndarray:
    """Return peg axes in (h, e, z), Ry(-gamma) Rz(phi), shape (3, 3, ...)."""
    s, c, sp, cp = np.sin(gamma), np.cos(gamma), np.sin(phi), np.cos(phi)
    return np.array([[c * cp, -c * sp, -s], [sp, cp, 0 * s], [s * cp, -s * sp, c]])


def precession_axes(psi: float | np.ndarray) -> np.ndarray:
    """Return (h, e, z) in hole axes, Rz(psi), shape (3, 3, ...)."""
    s, c = np.sin(psi), np.cos(psi)
    return np.array([[c, -s, 0 * s], [s, c, 0 * s], [0 * s, 0 * s, 1 + 0 * s]])


def peg_axes(q: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return R_HP, peg axes in hole axes, Rz(psi) Ry(-gamma) Rz(phi), shape (3, 3, ...)."""
    return product(precession_axes(q[1]), wrench_axes(q[0], q[2]))


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the matrix product over the first axes, with time along the last ones."""
    a, b = np.asarray(a), np.asarray(b)
    if a.ndim == 2 and b.ndim <= 2:
        return a @ b
    if b.ndim == a.ndim - 1:
        return np.einsum("ij...,j...->i...", a, b)
    return np.einsum("ij...,jk...->ik...", a, b)


def slip_directions(
    jacobians: np.ndarray, rates: np.ndarray, slip_velocity_scale: float
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return contact velocities over their regularised speed, and the velocities.

    Parameters
    ----------
    jacobians : ndarray, shape (3, 3, 3, ...)
    rates : ndarray, shape (3, ...)
        [rad/s].
    slip_velocity_scale : float
        Speed at which friction reaches 71 % of f N [m/s]; 0 is Coulomb's law.

    Returns
    -------
    u, v : ndarray, shape (3, 3, ...)
        Rows K, B1, B2 in (h, e, z); |u| < 1, and v [m/s].

    """
    v = (
        jacobians @ rates
        if jacobians.ndim == 3
        else np.einsum("icj...,j...->ic...", jacobians, rates)
    )
    speed = np.sqrt(np.sum(v * v, axis=1) + slip_velocity_scale**2)
    # A contact at rest under Coulomb's law has no direction of slip.
    speed = np.where(speed == 0, 1, speed)
    return v / speed[:, None], v


def six_equations(
    scene: Scene, q: ArrayLike, rates: ArrayLike, wrench_P: ArrayLike, slip_velocity_scale: float
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the equations of motion as a linear system A y = r.

    Parameters
    ----------
    scene : Scene
    q, rates : array_like, shape (3, ...)
        gamma, psi, phi [rad] and their rates [rad/s]; further axes are states, such as times.
    wrench_P : array_like, shape (6, ...)
        Applied force and moment about the mass centre, peg axes [N], [N m].
    slip_velocity_scale : float
        Of the regularised friction law [m/s].

    Returns
    -------
    A : ndarray, shape (6, 6, ...)
    r : ndarray, shape (6, ...)
        Rows: Lagrange's equations for gamma, psi, phi [N m]; force balance along h, e, z [N].
        Columns, and y: gamma'', psi'', phi'' [rad/s^2], N_K, N_B1, N_B2 [N].

    Source: eq. (28), corrected as in docs/errata.md.

    """
    q, rates, wrench_P = np.asarray(q), np.asarray(rates), np.asarray(wrench_P)
    if q.ndim > 1 or rates.ndim > 1 or wrench_P.ndim > 1:
        rows = np.broadcast_arrays(*q, *rates, *wrench_P)
        q, rates, wrench_P = np.stack(rows[:3]), np.stack(rows[3:6]), np.stack(rows[6:])
    gamma, psi, phi = q
    dgamma, dpsi, dphi = rates
    g = contact_geometry(scene, gamma)
    s, c = g.s, g.c
    m, Ie, Iz, f = scene.peg_mass, scene.transverse_inertia, scene.axial_inertia, scene.friction

    to_hez = wrench_axes(gamma, phi)
    F, M = product(to_hez, wrench_P[:3]), product(to_hez, wrench_P[3:])
    gravity_hez = np.einsum("ij...,i->j...", precession_axes(psi), np.asarray(scene.gravity))
    F = F + m * gravity_hez

    J = velocity_jacobians(g, scene.peg_diameter, scene.hole_diameter)
    n = normals(g)
    u, _ = slip_directions(J, rates, slip_velocity_scale)
    friction = -f * u

    zero = 0 * s
    mass = np.array(
        [
            [m * (g.dh_c**2 + g.dz_c**2) + Ie, zero, zero],
            [zero, m * g.h_c**2 + Ie * s**2 + Iz * c**2, Iz * c],
            [zero, Iz * c, Iz + zero],
        ]
    )
    inertia_coupling = m * g.h_c * g.dh_c + (Ie - Iz) * s * c
    velocity_terms = np.array(
        [
            m * (g.dh_c * g.ddh_c + g.dz_c * g.ddz_c) * dgamma**2
            - inertia_coupling * dpsi**2
            + Iz * s * dpsi * dphi,
            2 * inertia_coupling * dgamma * dpsi - Iz * s * dgamma * dphi,
            -Iz * s * dgamma * dpsi,
        ]
    )
    applied = np.array(
        [
            F[0] * g.dh_c + F[2] * g.dz_c - M[1],
            F[1] * g.h_c + M[2],
            -s * M[0] + c * M[2],
        ]
    )
    friction_Q = np.array(
        [[(J[i, :, j] * friction[i]).sum(axis=0) for i in range(3)] for j in range(3)]
    )

    acceleration_q = np.array([[g.dh_c, zero, zero], [zero, g.h_c, zero], [g.dz_c, zero, zero]])
    acceleration_0 = np.array(
        [
            g.ddh_c * dgamma**2 - g.h_c * dpsi**2,
            2 * g.dh_c * dgamma * dpsi,
            g.ddz_c * dgamma**2,
        ]
    )
    lagrange = np.concatenate([mass, -friction_Q], axis=1)
    balance = np.concatenate([m * acceleration_q, -np.swapaxes(n + friction, 0, 1)], axis=1)
    return (
        np.concatenate([lagrange, balance]),
        np.concatenate([applied - velocity_terms, F - m * acceleration_0]),
    )


def friction_cubic(
    scene: Scene, q: ArrayLike, rates: ArrayLike, slip_velocity_scale: float = 0.0
) -> np.ndarray:
    """
    Return the normalised determinant of the six equations as a cubic in the friction coefficient.

    Parameters
    ----------
    scene : Scene
        Its friction coefficient does not matter.
    q, rates : array_like, shape (3,)
        [rad], [rad/s].
    slip_velocity_scale : float
        [m/s].

    Returns
    -------
    ndarray, shape (4,)
        Coefficients of f^0 .. f^3; the first is 1.

    Notes
    -----
    With the accelerations eliminated the reactions obey (K0 + f K1) N = ..., so the determinant
    over its frictionless value is det(1 + f X), X = inv(K0) K1.

    """
    K0, K1 = (_reactions_matrix(scene, q, rates, slip_velocity_scale, f) for f in (0.0, 1.0))
    X = np.linalg.solve(K0, K1 - K0)
    trace = np.trace(X)
    return np.array([1.0, trace, (trace**2 - np.trace(X @ X)) / 2, np.linalg.det(X)])


def _reactions_matrix(scene, q, rates, slip_velocity_scale, friction):
    no_wrench = np.zeros(6)
    A, _ = six_equations(
        replace(scene, friction=friction), q, rates, no_wrench, slip_velocity_scale
    )
    return A[3:, 3:] - A[3:, :3] @ np.linalg.solve(A[:3, :3], A[:3, 3:])


def critical_frictions(cubic: ArrayLike) -> tuple[float, ...]:
    """
    Return all positive real roots of the determinant's cubic, ascending.

    Parameters
    ----------
    cubic : array_like, shape (4,)
        From `friction_cubic`: coefficients of f^0 .. f^3.

    Returns
    -------
    tuple of float

    Raises
    ------
    PegOnHoleError
        Where a coefficient is not finite.

    """
    cubic = np.asarray(cubic, float)
    if cubic.shape != (4,) or not np.all(np.isfinite(cubic)):
        raise PegOnHoleError(f"cubic = {cubic} is not four finite coefficients of f^0 .. f^3")
    # Coefficients that are rounding beside the others would give roots near infinity: those of f
    # and f^3 where psi or phi turns alone.
    high = np.where(np.abs(cubic) < 1e-12 * np.max(np.abs(cubic)), 0, cubic)[::-1]
    roots = np.roots(np.trim_zeros(high, "f"))
    # A double root comes out of the eigenvalues with an imaginary part of about sqrt(1e-16).
    real = roots.real[(np.abs(roots.imag) < 1e-7 * np.abs(roots)) & (roots.real > 0)]
    return tuple(float(x) for x in np.sort(real))


def solve_contact(
    scene: Scene,
    q: ArrayLike,
    rates: ArrayLike,
    force_H: ArrayLike,
    moment_H: ArrayLike,
    slip_velocity_scale: float = 0.0,
) -> ContactSolution:
    """
    Return motion and reactions at one state, and what they mean.

    Parameters
    ----------
    scene : Scene
    q, rates : array_like, shape (3,)
        gamma, psi, phi [rad] and their Euler rates [rad/s].
    force_H, moment_H : array_like, shape (3,)
        Applied to the peg at its mass centre, hole axes, without gravity [N], [N m].
    slip_velocity_scale : float
        Of the regularised friction law [m/s]; 0 is Coulomb's.

    Returns
    -------
    ContactSolution

    Raises
    ------
    PegOnHoleError
        Where an input is not finite, or the tilt has no three-point contact.

    """
    q, rates = np.asarray(q, float), np.asarray(rates, float)
    R_HP = peg_axes(q)
    wrench_P = np.concatenate([R_HP.T @ np.asarray(force_H), R_HP.T @ np.asarray(moment_H)])
    for name, unit, value in (("state", "rad", q), ("rates", "rad/s", rates)):
        if not np.all(np.isfinite(value)):
            raise PegOnHoleError(f"{name} = {value} {unit} is not finite: give three numbers")
    if not np.all(np.isfinite(wrench_P)):
        raise PegOnHoleError(f"wrench = {force_H} N, {moment_H} N m is not finite")  # type: ignore[str-bytes-safe]
    A, r = six_equations(scene, q, rates, wrench_P, slip_velocity_scale)
    y = np.linalg.solve(A, r)
    g = contact_geometry(scene, q[0])
    J = velocity_jacobians(g, scene.peg_diameter, scene.hole_diameter)
    _, v = slip_directions(J, rates, slip_velocity_scale)
    slip_speed = np.linalg.norm(v, axis=1)
    cubic = friction_cubic(scene, q, rates, slip_velocity_scale)
    critical = critical_frictions(cubic)
    determinant = float(np.polyval(cubic[::-1], scene.friction))
    if scene.friction and np.all(slip_speed <= slip_velocity_scale):
        outcome = Outcome.STUCK
    elif determinant <= 0:
        outcome = Outcome.WEDGED
    elif np.any(y[3:] < 0):
        outcome = Outcome.CONTACT_OPEN
    else:
        outcome = Outcome.THREE_POINT
    first = critical[0] if critical else None
    return ContactSolution(y[:3], y[3:], slip_speed, determinant, first, outcome)
