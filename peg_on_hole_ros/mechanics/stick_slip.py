"""
Set-valued friction: contacts at rest stick within their cones or start to slip.

The reference for the regularised law of `reference` and `kernel`. Reactions follow from
accelerations: a contact that slides has its friction opposite to its velocity; one at rest may
hold anything in its cone, and starts to slip against its tangential acceleration when that is not
enough.
"""

from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares

from peg_on_hole_ros.mechanics.free_body import free_body, sticking, wrench_of
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.mechanics.undetermined import reaction_problem

# Sweeps before each least-squares step, and how often both are tried.
_SWEEPS, _ROUNDS = 100, 8


class Motion(Enum):
    """What a contact does next; the values are advice."""

    STICKS = "at rest and stays: its friction is only known to lie in its cone"
    STARTS = "at rest and starts to slip"
    SLIDES = "slides"
    OPENS = "parts"


class StickSlip(NamedTuple):
    """
    One motion under set-valued friction.

    Attributes
    ----------
    motion : tuple of Motion
        Of K, B1, B2.
    acceleration : ndarray, shape (6,)
        Of the mass centre and angular, in (h, e, z) [m/s^2], [rad/s^2].
    rates_change : ndarray, shape (3,)
        gamma'', psi'', phi'' that fit it best; exact where no contact parts [rad/s^2].
    reaction : ndarray, shape (3, 3)
        One possible force at each contact, in (h, e, z) [N]; where contacts stick it is not the
        only one, see `undetermined.reaction_ranges`.
    residual : float
        Largest violation of the laws of contact over the load, as a force; above 1e-6 there is no
        solution or it was not found.
    converged : bool

    """

    motion: tuple[Motion, Motion, Motion]
    acceleration: np.ndarray
    rates_change: np.ndarray
    reaction: np.ndarray
    residual: float
    converged: bool


def solve_stick_slip(
    scene: Scene,
    q: ArrayLike,
    rates: ArrayLike,
    force_H: ArrayLike,
    moment_H: ArrayLike,
    rest_speed: float = 1e-9,
) -> StickSlip:
    """
    Return accelerations and reactions under Coulomb's law with stick.

    Parameters
    ----------
    scene : Scene
    q, rates : array_like, shape (3,)
        State with three closed contacts: gamma, psi, phi [rad] and their rates [rad/s].
    force_H, moment_H : array_like, shape (3,)
        Applied at the mass centre, hole axes, without gravity [N], [N m].
    rest_speed : float
        Below it a contact counts as at rest [m/s].

    Returns
    -------
    StickSlip

    Notes
    -----
    Each contact's law: its force is the projection of force - rho (acceleration + f |a_t| n) on
    the friction cone (De Saxce and Feng 1998); a sliding contact has a ray for a cone. Sweeps over
    the contacts bring it close, a least-squares step on the violation makes it exact. Nine forces
    act on six accelerations: where contacts stick, forces depend on the start, accelerations not.

    """
    body = free_body(scene, q, rates, force_H, moment_H)
    speed = np.linalg.norm(body.velocity, axis=1)
    frames = [_contact_frame(n) for n in body.normals]
    rays = [
        None if v <= rest_speed else frame @ (n - scene.friction * u / v)
        for v, frame, n, u in zip(speed, frames, body.normals, body.velocity)
    ]
    J = np.vstack([[wrench_of(a, axis) for axis in F] for a, F in zip(body.arms, frames)])
    W = J @ np.linalg.solve(body.mass, J.T)
    # Contact accelerations with no force: relative to those of closed, rolling contacts.
    bias = np.concatenate([frame @ rate for frame, rate in zip(frames, body.velocity_rate)])
    bias.reshape(3, 3)[:, 0] = 0
    a0 = J @ (np.linalg.solve(body.mass, body.load) - body.drift) + bias
    size = scene.peg_mass * np.max(np.abs(a0)) + 1e-300
    law = _Law(W, a0, rays, scene.friction, size)
    starts = [np.zeros(9), _all_slide(scene, rays, W, a0)]
    if sticking(body, rest_speed).all():
        held = reaction_problem(scene, body, rest_speed).example()
        starts += [] if held is None else [(np.array(frames) @ held[:, :, None]).ravel()]
    force, residual = law.settle(starts)
    a = (W @ force + a0).reshape(3, 3)
    acceleration = np.linalg.solve(body.mass, body.load + J.T @ force)
    force = force.reshape(3, 3)
    motion = tuple(_motion(force[i], a[i], rays[i], size, size / scene.peg_mass) for i in range(3))
    change = np.linalg.lstsq(body.freedom, acceleration - body.drift, rcond=None)[0]
    reaction = np.array([f @ frame for f, frame in zip(force, frames)])
    return StickSlip(motion, acceleration, change, reaction, residual, residual <= 1e-6)


class _Law(NamedTuple):
    """The laws of three contacts as a fixed point force = projection(force - rho acceleration)."""

    W: np.ndarray
    a0: np.ndarray
    rays: list
    friction: float
    size: float

    def rho(self, i):
        block = slice(3 * i, 3 * i + 3)
        return 1 / np.max(np.linalg.eigvalsh(self.W[block, block]))

    def project(self, i, force, acceleration, rho):
        """Return the force that contact i would take."""
        if self.rays[i] is not None:
            return max(force[0] - rho * acceleration[0], 0.0) * self.rays[i]
        sliding = self.friction * np.hypot(acceleration[1], acceleration[2])
        moved = acceleration + np.array([sliding, 0, 0])
        return _on_cone(force - rho * moved, self.friction)

    def violation(self, x, rhos):
        """Return how far forces (over the size) are from their projections."""
        force = x * self.size
        a = self.W @ force + self.a0
        new = [
            self.project(i, force[3 * i : 3 * i + 3], a[3 * i : 3 * i + 3], rhos[i])
            for i in range(3)
        ]
        return x - np.concatenate(new) / self.size

    def settle(self, starts):
        """Return forces that fulfil the laws, and the violation that is left."""
        rhos = [self.rho(i) for i in range(3)]
        found = [np.max(np.abs(self.violation(x / self.size, rhos))) for x in starts]
        best, left = starts[int(np.argmin(found))], min(found)
        force = best
        for _ in range(_ROUNDS):
            if left < 1e-9:
                break
            for _ in range(_SWEEPS):
                for i in range(3):
                    block = slice(3 * i, 3 * i + 3)
                    a = self.W[block] @ force + self.a0[block]
                    force = force.copy()
                    force[block] = self.project(i, force[block], a, rhos[i])
            polished = least_squares(
                self.violation, force / self.size, args=(rhos,), xtol=1e-15, ftol=1e-15, gtol=1e-15
            )
            for x in (force / self.size, polished.x):
                violation = np.max(np.abs(self.violation(x, rhos)))
                if violation < left:
                    best, left = x * self.size, violation
            force = best
        return best, float(left)


def _all_slide(scene, rays, W, a0):
    """Return forces of a motion with three closed contacts that all slide: a start."""
    directions = [np.array([1.0, 0, 0]) if ray is None else ray for ray in rays]
    force = np.zeros(9)
    for _ in range(_SWEEPS):
        columns = np.zeros((9, 3))
        for i, direction in enumerate(directions):
            columns[3 * i : 3 * i + 3, i] = direction
        pressing = [0, 3, 6]
        block = (W @ columns)[pressing]
        if abs(np.linalg.det(block)) < 1e-12 * np.prod(np.linalg.norm(block, axis=1)):
            break
        force = columns @ np.linalg.solve(block, -a0[pressing])
        a = (W @ force + a0).reshape(3, 3)
        # Rounding must not turn a symmetric motion sideways: the next sweep would magnify it.
        a = np.where(np.abs(a) < 1e-9 * np.max(np.abs(a)), 0.0, a)
        change = 0.0
        for i, ray in enumerate(rays):
            slip = np.hypot(a[i, 1], a[i, 2])
            if ray is None and slip > 0:
                new = np.array([1.0, *(-scene.friction * a[i, 1:] / slip)])
                change = max(change, np.max(np.abs(new - directions[i])))
                directions[i] = (new + directions[i]) / 2
        if change < 1e-14:
            break
    return force


def _motion(force, a, ray, size, scale):
    if force[0] <= 1e-7 * size and a[0] > 1e-7 * scale:
        return Motion.OPENS
    if ray is not None:
        return Motion.SLIDES
    return Motion.STARTS if np.hypot(a[1], a[2]) > 1e-7 * scale else Motion.STICKS


def _contact_frame(normal):
    """Return the normal and two tangents as rows."""
    other = np.array([0.0, 1.0, 0.0]) if abs(normal[1]) < 0.9 else np.array([0.0, 0.0, 1.0])
    first = np.cross(normal, other)
    first /= np.linalg.norm(first)
    return np.array([normal, first, np.cross(normal, first)])


def _on_cone(x, friction):
    """Return the nearest point of the friction cone |tangential| <= f normal."""
    tangential = np.hypot(x[1], x[2])
    if tangential <= friction * x[0]:
        return x
    if friction * tangential <= -x[0]:
        return np.zeros(3)
    normal = (x[0] + friction * tangential) / (1 + friction**2)
    share = friction * normal / tangential if tangential else 0.0
    return np.array([normal, share * x[1], share * x[2]])
