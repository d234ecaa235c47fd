"""The simulator's compiled functions against the numpy model, differences and plain geometry."""

from dataclasses import replace

import numpy as np
import pytest

from peg_on_hole_ros.mechanics import reference
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim import dynamics, guided, holder
from peg_on_hole_ros.sim.command import evaluate, quintic

SCENE = Scene(gravity=(0.4, -1.1, -9.6))
P = dynamics.scene_numbers(SCENE)


def random_states(count, seed=5):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        gamma = SCENE.gamma0 + 10 ** rng.uniform(-6, -0.3)
        q = np.array([gamma, *rng.uniform(-3, 3, 2)])
        yield q, rng.normal(size=3), rng.normal(size=3) * 30, rng.normal(size=3)


def test_six_equations_are_those_of_the_numpy_model():
    for q, rates, F, M in random_states(200):
        R = reference.peg_axes(q)
        wrench_P = np.concatenate([R.T @ F, R.T @ M])
        A, r = dynamics.six_equations(P, q, rates, F, M, 1e-5)
        A_ref, r_ref = reference.six_equations(SCENE, q, rates, wrench_P, 1e-5)
        # 1e-12 of the largest entry: both round in double precision, in another order.
        assert np.abs(A - A_ref).max() < 1e-12 * np.abs(A_ref).max()
        assert np.abs(r - r_ref).max() < 1e-12 * np.abs(r_ref).max()
        y = dynamics.motion(P, q, rates, F, M, 1e-5)
        assert np.abs(A_ref @ y - r_ref).max() < 1e-9 * np.abs(A_ref * y).max()
        value = np.polyval(reference.friction_cubic(SCENE, q, rates, 1e-5)[::-1], SCENE.friction)
        assert dynamics.determinant(P, q, rates, 1e-5) == pytest.approx(value, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("friction", [0.0, 1e-9, 0.02, 0.5])
def test_determinant_is_one_without_friction_and_near_one_with_little(friction):
    p = dynamics.scene_numbers(replace(SCENE, friction=friction))
    for q, rates, _, _ in random_states(50):
        cubic = reference.friction_cubic(SCENE, q, rates, 1e-5)
        value = dynamics.determinant(p, q, rates, 1e-5)
        # Rounding of the cubic's coefficients, which are differences of determinants.
        assert value == pytest.approx(np.polyval(cubic[::-1], friction), rel=1e-6, abs=1e-6)
        if not friction:
            assert value == 1.0


@pytest.mark.parametrize("gamma", [0.005, 0.02, 0.06, SCENE.gamma0 - 1e-6])
def test_below_gamma0_the_peg_touches_in_k_and_at_the_far_wall(gamma):
    h, z = holder.touching(P, gamma)[0]
    axis, across = (
        np.array([-np.sin(gamma), np.cos(gamma)]),
        np.array([np.cos(gamma), np.sin(gamma)]),
    )
    radius, rim = SCENE.peg_diameter / 2, SCENE.hole_diameter / 2
    centre = np.array([h, z])
    assert (np.array([-rim, 0]) - centre) @ across == pytest.approx(-radius, abs=1e-15)
    edge = centre - SCENE.mass_center_height * axis + radius * across
    assert edge[0] == pytest.approx(rim, abs=1e-15)
    assert edge[1] < 0


def test_touching_pose_and_slope_are_continuous_at_gamma0():
    below, above = (holder.touching(P, SCENE.gamma0 + d) for d in (-1e-9, 1e-9))
    assert below[:2] == pytest.approx(above[:2], abs=1e-8)


def smooth_motion(seed, gamma=0.3):
    """Angles and offset as quintics in time: a motion whose every derivative is known."""
    rng = np.random.default_rng(seed)
    start, end = rng.normal(size=(2, 3, 6)) * [1, 1, 1, 0.01, 0.01, 0.01]
    start[0, 0], end[0, 0] = gamma, gamma + 0.01
    start[1:, 0] *= 0.05
    end[1:, 0] *= 0.05
    return np.array([0.0, 1.0]), quintic(start, end, 1.0)[None]


def test_quintic_meets_its_ends():
    rng = np.random.default_rng(1)
    start, end = rng.normal(size=(2, 3, 6))
    knots, pieces = np.array([2.0, 2.7]), quintic(start, end, 0.7)[None]
    assert evaluate(knots, pieces, 2.0) == pytest.approx(start, rel=1e-12)
    # Rounding of fifth powers over 0.7 s.
    assert evaluate(knots, pieces, 2.7) == pytest.approx(end, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("gamma", [0.3, 0.04])
def test_guided_wrench_is_the_change_of_momentum(gamma):
    knots, pieces = smooth_motion(3, gamma)
    t, h = 0.4, 1e-4
    x = [evaluate(knots, pieces, t + k * h) for k in range(-3, 4)]
    weights = np.array([-1, 9, -45, 0, 45, -9, 1]) / (60 * h)
    C = np.array([holder.mass_centre(P, xi)[0] for xi in x])
    R = np.array([dynamics.rotation(xi[0, :3]) for xi in x])
    v = np.array([holder.mass_centre(P, xi)[1] for xi in x])
    assert weights @ C == pytest.approx(v[3], abs=1e-10)
    acceleration = weights @ v
    # Angular velocity from the rotation matrices alone: R' R^T is its cross-product matrix.
    L = []
    for xi, Ri in zip(x, R):
        steps = [
            xi[0, :3] + k * h * xi[1, :3] + (k * h) ** 2 / 2 * xi[2, :3] for k in range(-3, 4)
        ]
        W = np.tensordot(weights, [dynamics.rotation(q) for q in steps], 1) @ Ri.T
        inertia = np.diag([SCENE.transverse_inertia] * 2 + [SCENE.axial_inertia])
        L.append(Ri @ inertia @ Ri.T @ [W[2, 1], W[0, 2], W[1, 0]])
    rng = np.random.default_rng(9)
    points, forces = rng.normal(size=(3, 3)) * 0.02, rng.normal(size=(3, 3)) * 5
    F, M = guided.newton_euler(P, x[3], points, forces)
    total = F + forces.sum(axis=0) + SCENE.peg_mass * np.array(SCENE.gravity)
    moment = M + np.cross(points - C[3], forces).sum(axis=0)
    # Sixth-order differences over 0.1 ms: 1e-9 of truncation and rounding.
    assert total == pytest.approx(SCENE.peg_mass * acceleration, abs=1e-8)
    assert moment == pytest.approx(weights @ np.array(L), abs=1e-8)


def test_holder_is_the_slope_of_its_spring_energy():
    stiffness, rotational = 2e4, 2e3
    numbers = holder.holder_numbers(SCENE, [0.01, -0.02, 0.07], stiffness, rotational, 0.7)
    command = np.zeros((3, 6))
    command[0] = 0.3, 0.5, -0.4, -2e-4, 1e-4, -5e-4
    attachment = np.array([0.01, -0.02, 0.07 - SCENE.mass_center_height])

    def pose(x):
        return holder.mass_centre(P, x)[0], dynamics.rotation(x[0, :3])

    def energy(q):
        x = np.zeros((3, 6))
        x[0, :3] = q
        (C, R), (C_c, R_c) = pose(x), pose(command)
        stretch = C_c + R_c @ attachment - C - R @ attachment
        angle = np.arccos((np.trace(R_c @ R.T) - 1) / 2)
        weight = SCENE.peg_mass * np.array(SCENE.gravity) @ C
        return stiffness / 2 * stretch @ stretch + rotational / 2 * angle**2 + weight

    q = np.array([0.302, 0.497, -0.403])
    state = np.concatenate([q, np.zeros(3)])
    F, M = holder.holder_wrench(P, numbers, command, state)
    for j in range(3):
        x, h = np.zeros((3, 6)), 1e-5
        x[0, :3], x[1, j] = q, 1.0
        power = F @ holder.mass_centre(P, x)[1] + M @ dynamics.angular_velocity(q, x[1, :3])
        step = h * np.eye(3)[j]
        slope = (energy(q + step) - energy(q - step)) / (2 * h)
        # Central differences over 1e-5 rad of an energy of some J/rad^2 thousand.
        assert power == pytest.approx(-slope, rel=1e-5, abs=1e-6)


def test_holder_damps_at_the_stated_ratio():
    numbers = holder.holder_numbers(SCENE, [0, 0, 0.07], 2e4, 2e3, 0.7)
    assert numbers[4] == pytest.approx(2 * 0.7 * np.sqrt(2e4 * SCENE.peg_mass), rel=1e-12)
    command = np.zeros((3, 6))
    command[0, 0] = 0.3
    command[1, 2] = 1.0
    F, M = holder.holder_wrench(P, numbers, command, np.array([0.3, 0, 0, 0, 0, 0.5]))
    zeta = dynamics.rotation(np.array([0.3, 0, 0]))[:, 2]
    weight = SCENE.peg_mass * np.array(SCENE.gravity)
    assert pytest.approx(-weight, rel=1e-9) == F
    assert pytest.approx(numbers[6] * 0.5 * zeta, rel=1e-9) == M
