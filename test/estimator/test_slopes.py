"""The six equations as a measurement: residual and slopes against differences of the equations."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import reference_equations
from compiled_beside import STATED, Compiled, cell_of
from peg_on_hole_ros.estimator.contact_sets import three_on_rim
from peg_on_hole_ros.estimator.orientation import (
    fill_orientation_jacobian,
    fill_orientation_residual,
)
from peg_on_hole_ros.estimator.state import ACCELERATION, FRICTION, OPEN_BEGIN, places_of
from peg_on_hole_ros.mechanics.reference import peg_axes, six_equations
from peg_on_hole_ros.mechanics.scene import Scene, scene_scalars

LOAD = 60.0
NOISE = np.diag([0.04] * 3 + [2.5e-5] * 3)
AT = places_of(tuple(STATED))
N = int(AT.reactions)


def drawn(seed):
    """Return a cell, and a mean, covariance and wrench that are somewhere in its range."""
    rng = np.random.default_rng(seed)
    cell = cell_of(Scene(), NOISE, tuple(STATED))
    open_stddev = np.concatenate(list(STATED.values()))
    x = np.zeros(N + 3)
    x[:3] = rng.uniform([0.09, -3.0, -3.0], [0.4, 3.0, 3.0])
    x[3:9] = rng.normal(size=6) * ([0.3] * 3 + [20.0] * 3)
    x[FRICTION], x[OPEN_BEGIN:N] = (
        rng.uniform(0.1, 0.4),
        rng.normal(size=N - OPEN_BEGIN) * open_stddev,
    )
    x[N:] = rng.uniform(5.0, 100.0, 3)
    root = rng.normal(size=(N + 3, N + 3)) * 0.01
    return cell, x, root @ root.T, rng.normal(size=6) * ([30.0] * 3 + [1.0] * 3)


def equations_by_hand(cell, x, u, scales):
    """Return the six equations' left less right side, with scenes that are really other ones."""
    scene = cell.scene
    clearance = (scene.hole_diameter - scene.peg_diameter) * np.exp(x[AT.clearance])
    clearance -= x[AT.compliance] * LOAD
    t_x, t_y = x[AT.tilt : AT.tilt + 2]
    lean = np.array([[1.0, 0.0, -t_y], [0.0, 1.0, t_x], [t_y, -t_x, 1.0]])
    scene = replace(
        scene,
        peg_diameter=scene.hole_diameter - clearance,
        gravity=tuple((lean @ scene.gravity).tolist()),
    )
    wrench = u - cell.bias_map @ x[AT.bias : AT.bias + 6]
    A, r = six_equations(replace(scene, friction=x[FRICTION]), x[:3], x[3:6], wrench, scales)
    at_K = replace(scene, friction=x[FRICTION] + x[AT.friction_k])
    A[:, 3] = six_equations(at_K, x[:3], x[3:6], wrench, scales)[0][:, 3]
    return A @ [*x[ACCELERATION : ACCELERATION + 3], *x[N:]] - r


def linearised(cell, x, P, u):
    both = Compiled(cell, 1)
    scratch, force2 = both.scratch, np.array([30.0, 90.0, 100.0])
    both.memory.wrench[:], both.state.load, both.state.friction_force2[:] = u, LOAD, force2
    three_on_rim.linearise(both.memory, scene_scalars(cell.scene), x, P, 0.0)
    w = N + 3
    return SimpleNamespace(
        residual=scratch.residual,
        E=scratch.jacobian[:, :w],
        R=scratch.noise,
        unknown=scratch.direction_noise,
        by_friction=scratch.by_friction,
        scales=scratch.velocity_scale,
    ), force2


@pytest.mark.parametrize("seed", range(6))
def test_of_the_six_equations_by_every_value(seed):
    cell, x, P, u = drawn(seed)
    scratch, _ = linearised(cell, x, P, u)
    scales = scratch.scales.copy()
    value = equations_by_hand(cell, x, u, scales)
    by_wrench = np.stack([equations_by_hand(cell, x, unit, scales) for unit in np.eye(6)], axis=1)
    none = equations_by_hand(cell, x, np.zeros(6), scales)
    # Slopes are those at the wrench with which the equations hold.
    expected = u - np.linalg.solve(by_wrench - none[:, None], value)
    size = np.maximum(np.abs(scratch.E * x).max(axis=1), np.abs(value))
    assert np.all(np.abs(scratch.residual - value) < 1e-12 * size)
    for k in range(N + 3):
        # Four points: what is left of the step's fifth power meets rounding at a thousandth.
        h = 1e-3 * max(abs(x[k]), {AT.compliance: 1e-7}.get(k, 1e-2))
        moved = [
            equations_by_hand(cell, x + j * h * np.eye(N + 3)[k], expected, scales) for j in _STEPS
        ]
        slope = np.dot(_WEIGHTS, moved) / h
        allowed = 1e-8 * np.abs(slope).max() + 1e-11 * size / h
        assert np.all(np.abs(scratch.E[:, k] - slope) < allowed), (k, scratch.E[:, k], slope)


_STEPS, _WEIGHTS = (-2, -1, 1, 2), (1 / 12, -8 / 12, 8 / 12, -1 / 12)


@pytest.mark.parametrize("seed", range(6))
def test_of_the_six_equations_against_complex_steps(seed):
    cell, x, P, u = drawn(seed)
    scratch, force2 = linearised(cell, x, P, u)
    found, unknown, _, by_friction = reference_equations.contact(cell, x, P, u, LOAD, force2)
    for mine, other in (
        (scratch.E, found.E),
        (scratch.R, found.R),
        (scratch.unknown, unknown),
        (scratch.by_friction, by_friction),
    ):
        # Each entry beside its row and column; rounding is 1e-16 of terms up to 1e3 larger.
        rows = np.abs(other).max(axis=1, keepdims=True)
        assert np.abs(mine - other).max(initial=0.0, where=rows > 0) <= 1e-11 * rows.max()
        assert np.all(np.abs(mine - other) <= 1e-10 * rows)


def test_where_the_tilt_ends_and_a_clearance_is_out_of_range():
    """At the bounds both take the value at the bound, with the slopes inside it."""
    cell, x, P, u = drawn(1)
    x[0], x[AT.clearance], x[AT.compliance] = 0.03, 3.5, 0.0
    scratch, force2 = linearised(cell, x, P, u)
    found, *_ = reference_equations.contact(cell, x, P, u, LOAD, force2)
    assert np.allclose(scratch.residual, -found.residual, rtol=1e-9)
    # 1e-5 rad above gamma0 the slopes by the tilt lose half their digits to its rounding.
    assert np.allclose(scratch.E, found.E, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("tilt", [0.0, 1e-3, 0.03])
def test_an_orientation_in_a_tilted_hole(tilt):
    """What is measured in a tilted hole is a peg that is turned: by the rotations themselves."""
    places = places_of(("tilt", "delay"))
    at, n = int(places.tilt), int(places.reactions)
    x, E, residual = np.zeros(n + 3), np.zeros((6, n + 3)), np.zeros(6)
    x[:6] = 0.15, 2.9, -3.0, 0.2, -0.5, 1.0
    x[at : at + 2] = tilt * np.array([0.6, -0.8])

    def measured(values):
        turned = Rotation.from_rotvec([*values[at : at + 2], 0.0]).as_matrix()
        R = turned @ peg_axes(values[:3])
        lean = np.hypot(R[2, 0], R[2, 1])
        return np.array(
            [
                np.arctan2(lean, R[2, 2]),
                np.arctan2(-R[1, 2], -R[0, 2]),
                np.arctan2(-R[2, 1], R[2, 0]),
            ]
        )

    fill_orientation_jacobian(x, places, n, E)
    fill_orientation_residual(x, places, measured(x), E, residual)
    assert np.abs(residual[:3]).max() < 1e-12
    # A truth that is a little off moves the residual by E: to the second order of what it is off.
    for k in [0, 1, 2, at, at + 1]:
        h = 1e-6
        fill_orientation_residual(x, places, measured(x + h * np.eye(n + 3)[k]), E, residual)
        assert np.abs(residual[:3] - h * E[:3, k]).max() < max(200 * h * h, 0.5 * tilt * h)
