"""The peg's frame in the hole's frame on three contacts, with its covariance."""

import numpy as np

from peg_on_hole_ros.mechanics.geometry import closed_forms
from peg_on_hole_ros.mechanics.reference import peg_axes, precession_axes
from peg_on_hole_ros.mechanics.scene import Scene


def peg_pose(scene: Scene, q, covariance, position_free: bool):
    """
    Return place, orientation and covariance of the peg's frame.

    Parameters
    ----------
    scene : Scene
    q : ndarray, shape (3,)
        gamma, psi, phi [rad].
    covariance : ndarray, shape (3, 3)
        Of q [rad^2].
    position_free : bool
        No three contacts hold the peg: its place is then unknown to about its own height.

    Returns
    -------
    position : ndarray, shape (3,)
        Centre of the lower end face, O2, in the hole frame [m].
    rotation : ndarray, shape (3, 3)
        R_HP.
    pose_covariance : ndarray, shape (6, 6)
        Place, and rotation about the hole's axes; rank 3 on three contacts.

    """
    rotation = peg_axes(q)
    # At and below gamma0 the closed forms end; the pose there is that of gamma0, marked as free.
    gamma = max(q[0], scene.gamma0 * (1 + 1e-9))
    s, c, a1, a2 = closed_forms(
        scene.peg_diameter, scene.hole_diameter, scene.mass_center_height, scene.gamma0, gamma
    )[:4]
    turn = precession_axes(q[1])
    O2 = turn @ np.array([a2 * s, 0.0, a1 - a2 * c])
    by_gamma = turn @ np.array([a1 + a2 * c, 0.0, (a2 - a1 * c) / s + a2 * s])
    by_psi = np.array([-O2[1], O2[0], 0.0])
    eps, zeta = turn @ np.array([0.0, -1.0, 0.0]), rotation[:, 2]
    J = np.zeros((6, 3))
    J[:3, 0], J[:3, 1] = by_gamma, by_psi
    J[3:, 0], J[3:, 1], J[3:, 2] = eps, (0.0, 0.0, 1.0), zeta
    pose_covariance = J @ covariance @ J.T
    if position_free:
        pose_covariance[:3, :] = pose_covariance[:, :3] = 0.0
        pose_covariance[range(3), range(3)] = scene.peg_height**2
    return O2, rotation, pose_covariance
