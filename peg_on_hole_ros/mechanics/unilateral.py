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

from peg_on_hole_ros.mechanics.free_body import free_body, wrench_of
from peg_on_hole_ros.mechanics.reference import Outcome
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.records import CONTACTS


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
        friction here; `stick_slip.solve_stick_slip` gives it its cone.

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
