"""What is said of one estimate: pose and contacts against the geometry that they are made of."""

import numpy as np
import pytest
from peg_on_hole_ros.estimation.filters.contact import ContactFilter
from peg_on_hole_ros.estimation.kernel.memory import part
from scipy.optimize import nnls
from scipy.spatial.transform import Rotation

from peg_on_hole_ros.mechanics.geometry import (
    contact_geometry,
    contact_points,
    normals,
    velocity_jacobians,
)
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.options import FilterOptions

SCENE = Scene(peg_diameter=0.048, peg_height=0.09, gravity=(1.0, -2.0, -9.0))
SPREAD = np.array([1e-4, 3e-4, 5e-4, 1e-3, 2e-3, 3e-3])


def estimated(seed=0):
    """A filter at some state with correlated errors, under a wrench that presses."""
    rng = np.random.default_rng(seed)
    kalman = ContactFilter(SCENE, FilterOptions(), np.diag([0.04] * 3 + [2.5e-5] * 3))
    q = np.array([rng.uniform(0.4, 0.6), *rng.uniform(-3, 3, 2)])
    kalman.start(q, np.eye(3))
    kalman.x[3:] = 5 * rng.normal(size=3)
    root = rng.normal(size=(6, 6)) * SPREAD[:, None]
    kalman.Z[:6, :6] = root @ root.T
    kalman.hold(np.array([3.0, -2.0, -40.0, 0.3, -0.2, 0.1]))
    return kalman


def pose(q):
    """Place of the peg's end and its orientation, from the scene's contacts alone."""
    gamma, psi, phi = q
    R = Rotation.from_euler("ZYZ", [psi, -gamma, phi]).as_matrix()
    # B1 and B2 are on the end's edge, and K is on the side: a radius away from the axis.
    K, B1, B2 = contact_points(contact_geometry(SCENE, gamma), SCENE.hole_diameter)
    turn = Rotation.from_euler("z", psi).as_matrix()
    zeta, eta, radius = R[:, 2], np.cross(turn[:, 1], R[:, 2]), SCENE.peg_diameter / 2
    reach = np.sqrt(radius**2 - np.sum((B1 - B2) ** 2) / 4)
    centres = [turn @ (B1 + B2) / 2 + side * reach * eta for side in (1, -1)]
    misses = [abs(np.linalg.norm(np.cross(turn @ K - O2, zeta)) - radius) for O2 in centres]
    assert min(misses) < 1e-14
    return centres[int(np.argmin(misses))], R


@pytest.mark.parametrize("seed", range(4))
def test_pose_is_that_of_three_contacts(seed):
    kalman = estimated(seed)
    kalman.reactions()
    estimate = kalman.describe(True, 1.0)
    O2, R = pose(kalman.x[:3])
    np.testing.assert_allclose(estimate.rotation, R, atol=1e-15)
    np.testing.assert_allclose(estimate.position, O2, atol=1e-15)


@pytest.mark.parametrize("seed", range(4))
def test_pose_covariance_is_that_of_the_angles_through_the_pose(seed):
    kalman = estimated(seed)
    kalman.reactions()
    found = kalman.describe(True, 1.0).pose_covariance
    small, J = 1e-6, np.empty((6, 3))
    for i in range(3):
        moved = [kalman.x[:3] + sign * small * np.eye(3)[i] for sign in (1, -1)]
        (O2a, Ra), (O2b, Rb) = pose(moved[0]), pose(moved[1])
        J[:3, i] = (O2a - O2b) / (2 * small)
        J[3:, i] = Rotation.from_matrix(Ra @ Rb.T).as_rotvec() / (2 * small)
    expected = J @ kalman.P[:3, :3] @ J.T
    stddev = np.sqrt(np.diagonal(expected))
    # Central differences: 1e-12 of curvature and 1e-16 / 1e-6 of rounding, over 10 mm.
    np.testing.assert_allclose(
        found / np.outer(stddev, stddev), expected / np.outer(stddev, stddev), atol=1e-7
    )


def test_contact_forces_press_along_the_normals_and_rub_against_the_slip():
    kalman = estimated()
    kalman.reactions()
    estimate = kalman.describe(True, 1.0)
    g = contact_geometry(SCENE, kalman.x[0])
    turn = Rotation.from_euler("z", kalman.x[1]).as_matrix()
    velocity = velocity_jacobians(g, SCENE.peg_diameter, SCENE.hole_diameter) @ kalman.x[3:]
    speed = np.linalg.norm(velocity, axis=1)
    # At 1 cm/s friction is Coulomb's to (2e-5 / 1e-2)^2 / 2.
    assert speed.min() > 1e-2
    direction = normals(g) - SCENE.friction * velocity / speed[:, None]
    expected = estimate.normal[:, None] * direction @ turn.T
    size = np.abs(expected).max()
    np.testing.assert_allclose(estimate.contact_force, expected, atol=4e-6 * size)
    np.testing.assert_allclose(estimate.slip_speed, speed, rtol=1e-12)
    points = contact_points(g, SCENE.hole_diameter) @ turn.T
    np.testing.assert_allclose(estimate.contact_point, points, atol=1e-15)


def test_slip_speeds_vary_as_the_rates_do():
    kalman = estimated(2)
    kalman.reactions()
    found = kalman.describe(True, 1.0).slip_speed_stddev
    g = contact_geometry(SCENE, kalman.x[0])
    J = velocity_jacobians(g, SCENE.peg_diameter, SCENE.hole_diameter)
    rates = np.random.default_rng(0).multivariate_normal(
        kalman.x[3:], kalman.Z[3:6, 3:6], size=40_000
    )
    speeds = np.linalg.norm(np.einsum("ijk,nk->nij", J, rates), axis=2)
    # Known to sqrt(1 / 80000) = 0.4 % from as many samples.
    np.testing.assert_allclose(found, speeds.std(axis=0), rtol=0.015)


def test_off_the_contacts_nothing_is_said_of_reactions_and_place():
    kalman = estimated()
    kalman.reactions()
    estimate = kalman.describe(False, 12.5)
    np.testing.assert_array_equal(estimate.normal, 0.0)
    np.testing.assert_array_equal(estimate.normal_stddev, 12.5)
    np.testing.assert_array_equal(estimate.contact_force, 0.0)
    place = estimate.pose_covariance[:3, :3]
    np.testing.assert_array_equal(place, SCENE.peg_height**2 * np.eye(3))
    np.testing.assert_array_equal(estimate.pose_covariance[:3, 3:], 0.0)
    assert np.linalg.matrix_rank(estimate.pose_covariance[3:, 3:]) == 3


def test_psi_and_phi_are_wrapped_and_gamma_is_not():
    kalman = estimated()
    kalman.x[:3] = 0.5, np.pi + 0.1 + 6 * np.pi, -np.pi
    kalman.reactions()
    state = kalman.describe(True, 1.0).state
    np.testing.assert_allclose(state[:3], [0.5, 0.1 - np.pi, np.pi], atol=1e-14)
    np.testing.assert_array_equal(state[3:], kalman.x[3:])


def test_rim_carries_wrench_and_weight():
    kalman = estimated(3)
    R = Rotation.from_euler("ZYZ", [kalman.x[1], -kalman.x[0], kalman.x[2]]).as_matrix()
    force = kalman.u[:3] + SCENE.peg_mass * R.T @ SCENE.gravity
    found = kalman.rim_load()
    np.testing.assert_allclose(
        found, (np.linalg.norm(force), np.linalg.norm(kalman.u[3:])), rtol=1e-14
    )


def test_what_was_described_does_not_change_with_the_filter():
    kalman = estimated()
    kalman.reactions()
    estimate = kalman.describe(True, 1.0)
    kept = [values.copy() for values in estimate]
    kalman.predict(1e-3, True)
    kalman.reactions()
    kalman.describe(True, 1.0)
    for values, before in zip(estimate, kept):
        np.testing.assert_array_equal(values, before)


@pytest.mark.parametrize("seed", range(20))
def test_a_contact_that_would_pull_carries_nothing_and_moves_the_others_with_it(seed):
    kalman = estimated()
    kalman.reactions()
    rng = np.random.default_rng(seed)
    found, root = rng.normal(size=3), rng.normal(size=(3, 3))
    covariance = root @ root.T
    part(kalman.memory, "Y")[3:] = found
    part(kalman.memory, "REACTIONS").reshape(6, 6)[3:, 3:] = covariance
    estimate = kalman.describe(True, 1.0)
    # The nearest in units of the covariance, as a least-squares problem of its root.
    whiten = np.linalg.inv(np.linalg.cholesky(covariance))
    nearest, _ = nnls(whiten, whiten @ found)
    # It ends where a pass moves 1e-10; with correlations up to 0.999 that is 1e-7 before the end.
    np.testing.assert_allclose(estimate.normal, nearest, atol=1e-6)
    np.testing.assert_array_equal(estimate.normal_stddev, np.sqrt(np.diagonal(covariance)))
    np.testing.assert_array_equal(part(kalman.memory, "Y")[3:], found)
