"""
Whether a steady motion lasts: friction turns with the direction of slip, and may feed a vibration.

A peg that is led steadily is a spring-mass system of three degrees of freedom. A slip that turns
aside turns friction aside, which moves the peg along another axis: without symmetry of that
coupling a vibration grows, and the peg chatters.
"""

import numpy as np

from peg_on_hole_ros.mechanics.geometry import contact_geometry, normals, velocity_jacobians
from peg_on_hole_ros.mechanics.planning.cell import Cell
from peg_on_hole_ros.mechanics.planning.steady import Steady, holder_law, wrench_map
from peg_on_hole_ros.mechanics.scene import Scene


def growth(
    scene: Scene,
    cell: Cell,
    gamma: np.ndarray,
    rates: np.ndarray,
    frictions: np.ndarray,
    steady: Steady,
) -> np.ndarray:
    """
    Return the fastest growth of a vibration about a steady motion.

    Parameters
    ----------
    scene : Scene
    cell : Cell
    gamma : ndarray, shape (n,)
        [rad]
    rates : ndarray, shape (3, n) or (3, f, n)
        [rad/s]
    frictions : ndarray, shape (f,)
    steady : Steady
        Its loads.

    Returns
    -------
    ndarray, shape (f, n)
        [1/s]; below zero where vibrations die away.

    Notes
    -----
    Left out: how geometry changes with the tilt, N D beside the holder's rotational stiffness.

    """
    g = contact_geometry(scene, gamma)
    J = np.moveaxis(velocity_jacobians(g, scene.peg_diameter, scene.hole_diameter), -1, 0)
    n = np.moveaxis(normals(g), -1, 0)
    applied = wrench_map(scene, gamma)
    mass = _mass(scene, g)
    stiff = applied @ holder_law(scene, cell, gamma, cell.stiffness, cell.rotational_stiffness)
    damped = applied @ holder_law(scene, cell, gamma, *cell.damping(scene))
    # What a force at each contact does in each equation, (n, 3, 6, 3).
    works = np.concatenate([np.swapaxes(J, 2, 3), np.broadcast_to(np.eye(3), J.shape)], axis=2)
    found = []
    for k, friction in enumerate(frictions):
        v = np.einsum("nicj,jn->nic", J, rates[:, k] if rates.ndim == 3 else rates)
        speed = np.linalg.norm(v, axis=2)
        u = v / speed[..., None]
        columns = np.concatenate(
            [mass, -np.einsum("niac,nic->nai", works, n - friction * u)], axis=2
        )
        across = np.eye(3) - u[..., None] * u[..., None, :]
        load = friction * np.maximum(steady.normal[:, k].T, 0) / speed
        turned = np.einsum("ni,niac,nicd,nidj->naj", load, works, across, J)
        forces = np.concatenate([stiff, damped + turned], axis=2)
        motion = -np.linalg.solve(columns, forces)[:, :3]
        whole = np.zeros((len(gamma), 6, 6))
        whole[:, 0, 3] = whole[:, 1, 4] = whole[:, 2, 5] = 1
        whole[:, 3:] = motion
        found.append(np.linalg.eigvals(whole).real.max(axis=1))
    return np.array(found)


def _mass(scene, g):
    """Return the accelerations' columns of the six equations, (n, 6, 3)."""
    m, Ie, Iz = scene.peg_mass, scene.transverse_inertia, scene.axial_inertia
    mass = np.zeros((len(g.s), 6, 3))
    mass[:, 0, 0] = m * (g.dh_c**2 + g.dz_c**2) + Ie
    mass[:, 1, 1] = m * g.h_c**2 + Ie * g.s**2 + Iz * g.c**2
    mass[:, 1, 2] = mass[:, 2, 1] = Iz * g.c
    mass[:, 2, 2] = Iz
    mass[:, 3, 0], mass[:, 4, 1], mass[:, 5, 0] = m * g.dh_c, m * g.h_c, m * g.dz_c
    return mass
