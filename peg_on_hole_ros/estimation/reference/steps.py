"""Steps of the contact equations on the numpy model, with derivatives: slow and readable."""

from dataclasses import asdict
from types import SimpleNamespace

import numpy as np

from peg_on_hole_ros.estimation.steps.second_order import SHARE
from peg_on_hole_ros.mechanics.reference import six_equations
from peg_on_hole_ros.mechanics.scene import Scene

STATE, WRENCH, RATES = slice(0, 6), slice(6, 12), slice(3, 6)
FRICTION, DIAMETER, SIZE = 12, 13, 14
# Of a filter that carries them, bias and tilt come last.
BIAS, TILT = slice(SIZE, SIZE + 6), slice(SIZE + 6, SIZE + 8)
_NEWTON_TOLERANCE = 1e-12
_COMPLEX_STEP = 1e-30


def with_parameters(scene: Scene, friction, peg_diameter):
    """
    Return a scene of another friction and peg diameter, mass and inertia kept.

    It is no Scene: nothing is checked, and both may be complex, for derivatives.
    """
    values = {**asdict(scene), "friction": friction, "peg_diameter": peg_diameter}
    clearance = scene.hole_diameter - peg_diameter
    gamma0 = 2 * np.arcsin(np.sqrt(clearance / (2 * scene.hole_diameter)))
    return SimpleNamespace(**values, gamma0=gamma0)


def solve_with_slopes(scene: Scene, full, slip_velocity_scale):
    """
    Return accelerations and reactions, and their derivatives by a complex step.

    Parameters
    ----------
    scene : Scene
        All but friction and peg diameter.
    full : ndarray, shape (14,)
        State, wrench in peg axes, friction, peg diameter.
    slip_velocity_scale : float or ndarray, shape (3,)
        Of friction, for all contacts or for each [m/s].

    Returns
    -------
    y : ndarray, shape (6,)
    dy : ndarray, shape (6, 14)

    """
    dy = np.empty((6, SIZE))
    for i in range(SIZE):
        moved = full.astype(complex)
        moved[i] += 1j * _COMPLEX_STEP
        dy[:, i] = solve(scene, moved, slip_velocity_scale).imag / _COMPLEX_STEP
    return solve(scene, full, slip_velocity_scale), dy


def slopes_of_answer(scene: Scene, full, slip_velocity_scale, answer):
    """
    Return how the solution of A y = r would move if it were `answer`: inv(A) (dr - dA answer).

    Returns
    -------
    ndarray, shape (6, 14)

    """
    left = np.empty((6, SIZE))
    for i in range(SIZE):
        moved = full.astype(complex)
        moved[i] += 1j * _COMPLEX_STEP
        A, r = _equations(scene, moved, slip_velocity_scale)
        left[:, i] = (r - A @ answer).imag / _COMPLEX_STEP
    A, _ = _equations(scene, full, slip_velocity_scale)
    return np.linalg.solve(A, left)


def _equations(scene, full, slip_velocity_scale):
    here = with_parameters(scene, full[FRICTION], full[DIAMETER])
    return six_equations(here, full[:3], full[RATES], full[WRENCH], slip_velocity_scale)


def solve(scene: Scene, full, slip_velocity_scale):
    """Return accelerations and reactions, shape (6,); arguments as of `solve_with_slopes`."""
    A, r = _equations(scene, full, slip_velocity_scale)
    return np.linalg.solve(A, r)


def implicit_euler(scene: Scene, full, h, slip_velocity_scale):
    """
    Return the state after one implicit Euler step, and its derivatives by all 14 quantities.

    The rates v at the end solve v = v0 + h a(q0 + h v, v, u), here by Newton's method on the
    numpy model, its step halved until the residual falls.

    Returns
    -------
    x1 : ndarray, shape (6,)
    F : ndarray, shape (6, 14)

    """
    q, v0 = full[:3], full[RATES]
    v = v0
    gamma0 = with_parameters(scene, full[FRICTION], full[DIAMETER]).gamma0

    def residual(v):
        moved = np.concatenate([q + h * v, v, full[6:]])
        y, dy = solve_with_slopes(scene, moved, slip_velocity_scale)
        return v - v0 - h * y[:3], dy[:3]

    r, slopes = residual(v)
    for _ in range(50):
        matrix = np.eye(3) - h * (slopes[:, RATES] + h * slopes[:, :3])
        if np.linalg.norm(r) <= _NEWTON_TOLERANCE:
            break
        step = np.linalg.solve(matrix, -r)
        fraction = 1.0
        while True:
            below = q[0] + h * (v + fraction * step)[0] <= gamma0
            if not below:
                trial, trial_slopes = residual(v + fraction * step)
            if fraction < 1e-4 or not below and np.linalg.norm(trial) < np.linalg.norm(r):
                break
            fraction /= 2
        if fraction < 1e-4:
            break
        v, r, slopes = v + fraction * step, trial, trial_slopes
    return np.concatenate([q + h * v, v]), _derivatives_of_step(slopes, h)


def implicit_euler_tangent(scene: Scene, end, h, slip_velocity_scale):
    """
    Return the derivatives of an implicit Euler step as they are where it would end, (6, 14).

    Parameters
    ----------
    end : ndarray, shape (14,)
        State at the end, wrench, friction, peg diameter.

    """
    return _derivatives_of_step(solve_with_slopes(scene, end, slip_velocity_scale)[1][:3], h)


def _derivatives_of_step(slopes, h):
    """Return the derivatives by the begin from those of the accelerations at the end, (3, 14)."""
    matrix = np.eye(3) - h * (slopes[:, RATES] + h * slopes[:, :3])
    by_rates = np.linalg.solve(
        matrix, np.hstack([h * slopes[:, :3], np.eye(3), h * slopes[:, 6:]])
    )
    by_angles = np.hstack([np.eye(3), np.zeros((3, SIZE - 3))]) + h * by_rates
    return np.vstack([by_angles, by_rates])


def second_order(scene: Scene, full, stage_wrench, h, slip_velocity_scale):
    """
    Return what `implicit_euler` does, by two such stages; see `steps.second_order`.

    Parameters
    ----------
    full : ndarray, shape (14,)
        With the wrench at the end of the step.
    stage_wrench : ndarray, shape (6,)
        At the first stage.

    """
    part, beyond = SHARE * h, (1 - SHARE) / SHARE
    begin = np.concatenate([full[STATE], stage_wrench, full[FRICTION:]])
    x1, F1 = implicit_euler(scene, begin, part, slip_velocity_scale)
    state = np.hstack([np.eye(6), np.zeros((6, SIZE - 6))])
    base = np.concatenate([full[STATE] + beyond * (x1 - full[STATE]), full[6:]])
    by_start = np.eye(SIZE)
    by_start[STATE] = state + beyond * (F1 - state)
    x2, F2 = implicit_euler(scene, base, part, slip_velocity_scale)
    return x2, F2 @ by_start
