"""The compiled six equations against the numpy model that reads like the paper."""

import subprocess
import sys
from dataclasses import asdict
from types import SimpleNamespace

import numpy as np
import pytest

from peg_on_hole_ros.mechanics import kernel
from peg_on_hole_ros.mechanics.reference import friction_cubic, six_equations
from peg_on_hole_ros.mechanics.scene import Scene, scene_scalars
from simulated import ROOT
from tiers import nightly

# One for each contact, so that none can stand for another.
SCALES = np.array([1e-5, 3e-4, 2e-3])


def random_case(rng):
    D = 10 ** rng.uniform(-2.5, -0.5)
    d = D * (1 - 10 ** rng.uniform(-4, -1.5))
    scene = Scene(
        hole_diameter=D,
        peg_diameter=d,
        peg_height=D * rng.uniform(0.8, 3),
        peg_mass=rng.uniform(0.1, 3),
        friction=rng.uniform(0, 0.6),
        mass_center_height=D * rng.uniform(0.3, 1.5),
        gravity=tuple(rng.normal(size=3) * 6),
    )
    tilt = scene.gamma0 + 10 ** rng.uniform(-3, 0) * (1.4 - scene.gamma0)
    x = np.array([tilt, *rng.uniform(-3, 3, 2), *rng.normal(size=3)])
    return scene, x, rng.normal(size=6) * [20, 20, 20, 1, 1, 1]


def with_parameters(scene, friction, peg_diameter):
    """Return a scene of another friction and diameter, which may be complex; mass is kept."""
    values = {**asdict(scene), "friction": friction, "peg_diameter": peg_diameter}
    clearance = scene.hole_diameter - peg_diameter
    gamma0 = 2 * np.arcsin(np.sqrt(clearance / (2 * scene.hole_diameter)))
    return SimpleNamespace(**values, gamma0=gamma0)


def solve_reference(scene, xu):
    A, r = six_equations(scene, xu[:3], xu[3:6], xu[6:], SCALES)
    return np.linalg.solve(A, r)


@pytest.mark.parametrize("seed", [0, *nightly(1, 2, 3)])
def test_kernel_equals_the_reference_model(seed):
    rng = np.random.default_rng(seed)
    work, y, dy = kernel.workspace(), np.zeros(6), np.zeros((6, kernel.JACOBIAN_WIDTH))
    compared = 0
    while compared < 100:
        scene, x, u = random_case(rng)
        expected_determinant = np.polyval(
            friction_cubic(scene, x[:3], x[3:], SCALES)[::-1], scene.friction
        )
        # At the singular set both solutions are rounding times 1/determinant.
        if abs(expected_determinant) < 1e-2:
            continue
        compared += 1
        p = scene_scalars(scene)
        determinant = kernel.accelerate_with_derivatives(p, SCALES, x, u, work, y, dy)
        expected = solve_reference(scene, np.concatenate([x, u]))
        # 1e-9 of the largest acceleration and of the largest reaction.
        for part in (slice(0, 3), slice(3, 6)):
            size = np.abs(expected[part]).max()
            np.testing.assert_allclose(y[part], expected[part], rtol=0, atol=1e-9 * size)
        np.testing.assert_allclose(determinant, expected_determinant, rtol=1e-9)

        slopes = np.empty((6, kernel.JACOBIAN_WIDTH))
        for i in range(kernel.JACOBIAN_WIDTH):
            moved = np.concatenate([x, u, [scene.friction, scene.peg_diameter]]).astype(complex)
            # No difference is formed, so the step may be as small as it likes.
            moved[i] += 1e-30j
            answer = solve_reference(with_parameters(scene, *moved[12:]), moved[:12])
            slopes[:, i] = answer.imag / 1e-30
        for part in (slice(0, 3), slice(3, 6)):
            # Some slopes are zero in exact arithmetic: the floor is far below any other one.
            size = np.abs(slopes[part]).max(axis=0) + 1e-2
            assert (np.abs(dy[part] - slopes[part]) / size).max() < 1e-9


def test_values_do_not_depend_on_whether_derivatives_are_asked_for():
    rng = np.random.default_rng(11)
    scene, x, u = random_case(rng)
    p, work = scene_scalars(scene), kernel.workspace()
    y, with_slopes, dy = np.zeros(6), np.zeros(6), np.zeros((6, kernel.JACOBIAN_WIDTH))
    first = kernel.accelerate(p, SCALES, x, u, work, y)
    second = kernel.accelerate_with_derivatives(p, SCALES, x, u, work, with_slopes, dy)
    assert first == second
    np.testing.assert_array_equal(y, with_slopes)


def test_a_tilt_below_gamma0_is_nan_and_no_exception():
    scene = Scene()
    p = scene_scalars(scene)
    x = np.array([scene.gamma0 * 0.99, 0, 0, -0.1, 0, 0])
    y = np.zeros(6)
    kernel.accelerate(p, SCALES, x, np.zeros(6), kernel.workspace(), y)
    assert np.isnan(y).any()


def test_generated_code_is_what_the_script_writes():
    pytest.importorskip("sympy")
    script = ROOT / "tools" / "generate_kernel.py"
    done = subprocess.run([sys.executable, script, "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
