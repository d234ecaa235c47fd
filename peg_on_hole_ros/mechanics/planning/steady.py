"""Loads of a peg that a compliant holder leads steadily over three contacts."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.mechanics.geometry import contact_geometry
from peg_on_hole_ros.mechanics.planning.cell import Cell
from peg_on_hole_ros.mechanics.reference import six_equations
from peg_on_hole_ros.mechanics.scene import Scene


class Steady(NamedTuple):
    """
    Loads at states of a steady motion, for several coefficients of friction.

    Attributes
    ----------
    normal : ndarray, shape (3, f, n)
        N_K, N_B1, N_B2 [N]; a negative one would have to pull.
    determinant : ndarray, shape (f, n)
        Of the six equations over its frictionless value; 0 or less: wedged.
    lag : ndarray, shape (3, f, n)
        Commanded less true gamma, psi, phi [rad].
    force, torque : ndarray, shape (f, n)
        Of the holder on the peg, about its mass centre, the peg's weight included [N], [N m].

    """

    normal: np.ndarray
    determinant: np.ndarray
    lag: np.ndarray
    force: np.ndarray
    torque: np.ndarray


def steady_loads(
    scene: Scene,
    cell: Cell,
    gamma: np.ndarray,
    rates: ArrayLike,
    frictions: Sequence[float] | np.ndarray,
) -> Steady:
    """
    Return the reactions to a motion with constant rates, and what the holder gives for it.

    The holder is a spring of six directions between the commanded and the true pose; where it
    lags, its spring gives the couple that the motion needs. Forces for a motion: the six equations
    with no acceleration, solved for three reactions and three lags.

    Parameters
    ----------
    scene : Scene
        Its friction is not used.
    cell : Cell
        Holder: press, grip and stiffnesses.
    gamma : ndarray, shape (n,)
        Above gamma0 [rad].
    rates : array_like, shape (3,) or (3, n)
        True gamma', psi', phi' [rad/s]; some contact slides.
    frictions : sequence of float, length f

    Returns
    -------
    Steady

    Source: L1, L2 with accelerations of zero; the holder's law is that of `simulate`.

    """
    gamma = np.asarray(gamma, float)
    # The holder carries the weight: neither loads the contacts.
    weightless = replace(scene, gravity=(0.0, 0.0, 0.0))
    q = np.stack([gamma, 0 * gamma, 0 * gamma])
    rates = np.asarray(rates, float)
    rates = np.broadcast_to(rates if rates.ndim == 2 else rates[:, None], q.shape)
    smooth, right = _equations(replace(weightless, friction=0.0), q, rates)
    rough, _ = _equations(replace(weightless, friction=1.0), q, rates)
    wrench, spring = _holder(scene, cell, gamma)
    applied = wrench_map(scene, gamma)
    known = right + np.einsum("nij,nj->ni", applied, wrench)
    # Friction is in the reactions' columns alone, so that what is left of them is linear in it.
    without, full = _reactions(smooth), _reactions(rough)
    frictionless = np.linalg.det(without)
    parts = []
    for friction in frictions:
        A = smooth + friction * (rough - smooth)
        columns = np.concatenate([A[:, :, 3:], -applied @ spring], axis=2)
        y = np.linalg.solve(columns, known[..., None])[..., 0]
        given = wrench + np.einsum("nij,nj->ni", spring, y[:, 3:])
        given[:, :3] -= scene.peg_mass * np.asarray(scene.gravity)
        parts.append(
            (
                y[:, :3].T,
                np.linalg.det(without + friction * (full - without)) / frictionless,
                y[:, 3:].T / cell.rotational_stiffness,
                np.linalg.norm(given[:, :3], axis=1),
                np.linalg.norm(given[:, 3:], axis=1),
            )
        )
    normal, determinant, lag, force, torque = map(np.array, zip(*parts))
    return Steady(np.moveaxis(normal, 1, 0), determinant, np.moveaxis(lag, 1, 0), force, torque)


def _equations(scene, q, rates):
    """Return A (n, 6, 6) and r (n, 6) of the six equations without applied wrench."""
    A, r = six_equations(scene, q, rates, np.zeros(6), 0.0)
    return np.moveaxis(A, -1, 0), np.moveaxis(r, -1, 0)


def _reactions(A):
    """Return the reactions' matrices that are left where the accelerations are eliminated."""
    return A[:, 3:, 3:] - A[:, 3:, :3] @ np.linalg.solve(A[:, :3, :3], A[:, :3, 3:])


def wrench_map(scene: Scene, gamma: np.ndarray) -> np.ndarray:
    """Return what a wrench about the mass centre in (h, e, z) does in each equation, (n, 6, 6)."""
    g = contact_geometry(scene, gamma)
    W = np.zeros((gamma.size, 6, 6))
    W[:, 0, 0], W[:, 0, 2], W[:, 0, 4] = g.dh_c, g.dz_c, -1
    W[:, 1, 1], W[:, 1, 5] = g.h_c, 1
    W[:, 2, 3], W[:, 2, 5] = -g.s, g.c
    W[:, 3, 0] = W[:, 4, 1] = W[:, 5, 2] = 1
    return W


def _holder(scene, cell, gamma):
    """
    Return the holder's wrench without lag, (n, 6), and by the lag, (n, 6, 3).

    The lag is counted in the moment that it gives, so that the equations are of one size.
    """
    n = gamma.size
    press = np.broadcast_to(np.asarray(cell.press, float), (n, 3))
    moment = np.einsum("nij,nj->ni", _lever(scene, cell, gamma)[1], press)
    wrench = np.concatenate([press, moment], axis=1)
    return wrench, holder_law(scene, cell, gamma, cell.stiffness / cell.rotational_stiffness, 1.0)


def holder_law(
    scene: Scene, cell: Cell, gamma: np.ndarray, linear: float, rotational: float
) -> np.ndarray:
    """
    Return the holder's wrench by angles that it is off, or by rates where it damps.

    Parameters
    ----------
    scene : Scene
    cell : Cell
    gamma : ndarray, shape (n,)
        [rad]
    linear, rotational : float
        Stiffness [N/m], [N m/rad], or damping [N s/m], [N m s/rad].

    Returns
    -------
    ndarray, shape (n, 6, 3)
        Force and moment about the mass centre in (h, e, z), by gamma, psi, phi.

    """
    g, n = contact_geometry(scene, gamma), gamma.size
    reach, cross = _lever(scene, cell, gamma)
    # Of the gripped point by gamma and psi; phi leaves it where it is.
    moved = np.zeros((n, 3, 3))
    moved[:, 0, 0], moved[:, 2, 0] = g.dh_c - reach * g.c, g.dz_c - reach * g.s
    moved[:, 1, 1] = g.h_c - reach * g.s
    turned = np.zeros((n, 3, 3))
    turned[:, 1, 0], turned[:, 2, 1] = -1, 1
    turned[:, 0, 2], turned[:, 2, 2] = -g.s, g.c
    force = linear * moved
    return np.concatenate([force, rotational * turned + cross @ force], axis=1)


def _lever(scene, cell, gamma):
    """Return how far the grip is above the mass centre, and the lever's cross product."""
    reach = cell.grip_height - scene.mass_center_height
    h, z = -reach * np.sin(gamma), reach * np.cos(gamma)
    cross = np.zeros((gamma.size, 3, 3))
    cross[:, 0, 1], cross[:, 1, 0] = -z, z
    cross[:, 1, 2], cross[:, 2, 1] = -h, h
    return reach, cross
