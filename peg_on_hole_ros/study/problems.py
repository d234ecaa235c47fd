"""Motions to integrate under a wrench that is a known function of time, and their solutions."""

from math import ceil, inf
from typing import NamedTuple

import numpy as np
from scipy import integrate

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.kernel import (
    WIDTH,
    SceneScalars,
    accelerate,
    accelerate_with_derivatives,
    compiled,
    scene_scalars,
    workspace,
)
from peg_on_hole_ros.mechanics.reference import six_equations
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.study.steps import CONVERGED, FAILED, METHODS, NOT_FINITE, SCRATCH, advance

YARDSTICKS = ("Radau", "LSODA", "DOP853")
# Of what counts as the solution; a hundredth of it absolute.
REFERENCE_RTOL = 1e-10
# A yardstick that takes more evaluations than this for one problem is taken off it.
MAX_EVALUATIONS = 200_000
# Time of a cubic that does not end [s].
FOREVER = 1e9


class Problem(NamedTuple):
    """
    A motion on three contacts from a known state.

    Attributes
    ----------
    p : SceneScalars
    scales : ndarray, shape (3,)
        Velocity scales of friction at K, B1, B2 [m/s].
    coefficients : ndarray, shape (n, 4, 6)
        Cubics in time of the wrench about the mass centre, peg axes [N], [N m]; from time 0.
    interval : float
        Time of one cubic [s].
    start : float
        Time at the start [s].
    state : ndarray, shape (6,)
        At the start: gamma, psi, phi [rad] and their rates [rad/s].
    duration : float
        [s].

    """

    p: SceneScalars
    scales: np.ndarray
    coefficients: np.ndarray
    interval: float
    start: float
    state: np.ndarray
    duration: float


class Solution(NamedTuple):
    """
    What a method makes of a problem.

    Attributes
    ----------
    status : int
        CONVERGED, FAILED (the method says so by itself) or NOT_FINITE.
    state : ndarray, shape (6,)
        At the end.
    evaluations : int
        Of the six equations.
    lowest : float
        Smallest tilt that was tried [rad]; inf where the method does not tell.

    """

    status: int
    state: np.ndarray
    evaluations: int
    lowest: float = inf


def held(scene: Scene, state, wrench, duration: float, slip_velocity_scale: float) -> Problem:
    """Return the motion under a wrench that is held in peg axes, as the filter predicts it."""
    coefficients = np.zeros((1, 4, 6))
    coefficients[0, 0] = wrench
    scales = np.full(3, float(slip_velocity_scale))
    state = np.array(state, float)
    return Problem(scene_scalars(scene), scales, coefficients, FOREVER, 0.0, state, duration)


def solve(problem: Problem, method: str, step: float) -> Solution:
    """
    Solve by equal steps of a method of METHODS.

    Parameters
    ----------
    problem : Problem
    method : str
    step : float
        Longest step [s]; the duration is divided into equal ones.

    """
    count = max(1, ceil(problem.duration / step - 1e-9))
    x, x1 = problem.state.copy(), np.empty(6)
    status, evaluations = advance(
        METHODS.index(method), problem.p, problem.scales, problem.coefficients, problem.interval,
        problem.start, problem.duration / count, count, x, x1, np.zeros(SCRATCH),
    )  # fmt: skip
    return Solution(status, x1, evaluations)


@compiled
def _wrench_at(coefficients, interval, t):
    k = min(max(int(t / interval), 0), coefficients.shape[0] - 1)
    r = t - k * interval if k > 0 else t
    c = coefficients[k]
    return c[0] + r * (c[1] + r * (c[2] + r * c[3]))


@compiled
def _rate(t, x, p, scales, coefficients, interval, work):
    out, y = np.empty(6), np.empty(6)
    accelerate(p, scales, x, _wrench_at(coefficients, interval, t), work, y)
    out[:3], out[3:] = x[3:], y[:3]
    return out


@compiled
def _jacobian(t, x, p, scales, coefficients, interval, work):
    out, y, dy = np.zeros((6, 6)), np.empty(6), np.empty((6, WIDTH))
    u = _wrench_at(coefficients, interval, t)
    accelerate_with_derivatives(p, scales, x, u, work, y, dy)
    out[:3, 3:] = np.eye(3)
    out[3:] = dy[:3, :6]
    return out


class _GivenUp(Exception):
    pass


def by_scipy(problem: Problem, name: str = "Radau", rtol: float = REFERENCE_RTOL) -> Solution:
    """
    Solve by one of scipy's integrators with step control.

    Parameters
    ----------
    problem : Problem
    name : str
        Of YARDSTICKS.
    rtol : float
        Relative tolerance; the absolute is a hundredth of it.

    """
    work, count, lowest = workspace(), 0, inf
    p, scales, coefficients, interval = problem[:4]

    def rate(t, x):
        nonlocal count, lowest
        count += 1
        lowest = min(lowest, x[0])
        value = _rate(t, x, p, scales, coefficients, interval, work)
        if count > MAX_EVALUATIONS or not np.isfinite(value).all():
            raise _GivenUp
        return value

    def jacobian(t, x):
        return _jacobian(t, x, p, scales, coefficients, interval, work)

    more = {"jac": jacobian} if name in ("Radau", "LSODA") else {}
    span = (problem.start, problem.start + problem.duration)
    try:
        found = integrate.solve_ivp(
            rate, span, problem.state, method=name, rtol=rtol, atol=rtol / 100, **more
        )
    except (_GivenUp, ValueError):
        return Solution(FAILED, np.full(6, np.nan), count, lowest)
    end = found.y[:, -1]
    if not found.success:
        return Solution(FAILED, end, count, lowest)
    status = CONVERGED if np.isfinite(end).all() else NOT_FINITE
    return Solution(status, end, count, lowest)


def reactions(problem: Problem, state) -> np.ndarray:
    """Return N_K, N_B1, N_B2 at the end of a problem, at a state there [N]."""
    y = np.empty(6)
    t = problem.start + problem.duration
    u = _wrench_at(problem.coefficients, problem.interval, t)
    accelerate(problem.p, problem.scales, np.ascontiguousarray(state), u, workspace(), y)
    return y[3:]


def balancing_wrench(scene: Scene, state, normal, acceleration=(0.0, 0.0, 0.0), scale=0.0):
    """
    Return the wrench under which a state has given reactions and accelerations.

    Parameters
    ----------
    scene : Scene
    state : array_like, shape (6,)
    normal : array_like, shape (3,)
        N_K, N_B1, N_B2 [N].
    acceleration : array_like, shape (3,)
        gamma'', psi'', phi'' [rad/s^2].
    scale : float
        Velocity scale of friction [m/s].

    Returns
    -------
    ndarray, shape (6,)
        About the mass centre, peg axes [N], [N m].

    """
    q, rates = np.array(state[:3], float), np.array(state[3:], float)
    A, r0 = six_equations(scene, q, rates, np.zeros(6), scale)
    columns = [six_equations(scene, q, rates, unit, scale)[1] - r0 for unit in np.eye(6)]
    y = np.concatenate([acceleration, normal])
    wrench = np.linalg.solve(np.transpose(columns), A @ y - r0)
    if not np.isfinite(wrench).all():
        raise PegOnHoleError(f"no wrench balances the peg at gamma = {q[0]:g} rad")
    return wrench
