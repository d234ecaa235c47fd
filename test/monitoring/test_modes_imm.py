"""The comparison with an IMM: its free body and its scores, by other routes."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp, trapezoid
from scipy.spatial.transform import Rotation

from modes_imm import free_turning, scored, stay
from peg_on_hole_ros.mechanics.scene import Scene
from scenes_labels import Labels

SCENE = Scene()


def test_a_free_body_keeps_what_euler_says():
    # The angular momentum in fixed axes gains what the couple gives it.
    moment_P, full = np.array([0.02, -0.01, 0.005]), np.zeros(14)
    full[9:12] = moment_P

    def axes(q):
        return Rotation.from_euler("ZYZ", [q[1], -q[0], q[2]]).as_matrix()

    def momentum(y):
        eps = np.array([np.sin(y[1]), -np.cos(y[1]), 0.0])
        R = axes(y)
        w = y[3] * eps + y[5] * R[:, 2] + [0.0, 0.0, y[4]]
        Ie, Iz = SCENE.transverse_inertia, SCENE.axial_inertia
        return R @ np.diag([Ie, Ie, Iz]) @ R.T @ w

    def motion(t, y):
        full[:6] = y
        return np.concatenate([y[3:], free_turning(SCENE, full)])

    start = np.array([0.4, 0.3, 0.2, -1.0, 2.0, 3.0])
    run = solve_ivp(motion, (0.0, 0.02), start, rtol=1e-10, atol=1e-12, dense_output=True)
    times = np.linspace(0.0, 0.02, 401)
    moments = np.array([axes(run.sol(t)) @ moment_P for t in times])
    gained = trapezoid(moments, times, axis=0)
    # The trapezoid's error at this spacing is below 1e-5 of the sum.
    change = momentum(run.y[:, -1]) - momentum(start)
    np.testing.assert_allclose(change, gained, rtol=1e-4, atol=1e-10)


def test_scores_count_wrong_samples_and_the_first_sure_one():
    t = np.arange(200) * 1e-3
    kind = np.where(t < 0.1, "three_point", "two_point").astype("U11")
    kind[:10] = ""
    labels = Labels(t, kind, t >= 0.1, 0.1, ())
    probabilities = np.tile([0.9, 0.1, 0.0], (200, 1))
    probabilities[107:] = 0.05, 0.95, 0.0
    found = scored(labels, probabilities)
    assert found == {"samples": 150, "wrong": 7, "latency": pytest.approx(0.007), "rises": 1}
    probabilities[107:] = 0.3, 0.7, 0.0
    assert np.isnan(scored(labels, probabilities)["latency"])


def test_modes_change_as_often_as_said():
    M = stay(0.1, 2.0)
    np.testing.assert_allclose(M.sum(axis=1), 1.0, atol=1e-15)
    assert M[0, 0] == pytest.approx(np.exp(-0.2) + (1 - np.exp(-0.2)) / 3)
