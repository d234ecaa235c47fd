"""Predictions by each integrator over stretches of known motions: error, failures, cost."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from peg_on_hole_ros.mechanics.kernel import compiled, scene_scalars
from peg_on_hole_ros.study.problems import Problem, by_scipy
from peg_on_hole_ros.study.scenes import true_wrench
from peg_on_hole_ros.study.stability import ANGLE_LOST, SPEED_LOST, differences
from peg_on_hole_ros.study.steps import CONVERGED, METHODS, SCRATCH, advance

STRETCH = 0.02
STEPS = (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2)
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-6, 1e-8)


class Prediction(NamedTuple):
    """
    One method at one step over all stretches.

    Attributes
    ----------
    method : str
    setting : float
        Step [s], or relative tolerance of a yardstick.
    error : float
        Root mean square of the rotation from the solution after STRETCH [rad]; what is lost
        counts as ANGLE_LOST.
    speed_error : float
        The same of the fastest contact's speed [m/s]; what is lost counts as SPEED_LOST.
    lost : float
        Share of the stretches that fail, or end further off than ANGLE_LOST or SPEED_LOST.
    evaluations : float
        Of the six equations, a stretch.
    microseconds : float
        A millisecond of motion.

    """

    method: str
    setting: float
    error: float
    speed_error: float
    lost: float
    evaluations: float
    microseconds: float


def stretches(truth) -> list[Problem]:
    """Return the motion cut into stretches, each from a true state, its wrench a cubic spline."""
    plan = truth.plan
    dt = 1.0 / plan.wrench_rate
    t = dt * np.arange(len(truth.t_ns))
    coefficients = np.ascontiguousarray(
        np.transpose(CubicSpline(t, true_wrench(truth)).c[::-1], (1, 0, 2))
    )
    scales = np.full(3, plan.slip_velocity_scale)
    p = scene_scalars(plan.configuration.scene)
    state, length = np.hstack([truth.q, truth.rates]), int(round(STRETCH / dt))
    return [
        Problem(p, scales, coefficients, dt, k * dt, state[k], STRETCH)
        for k in range(0, len(t) - length - 1, length)
    ]


@compiled
def _sweep(method, p, scales, coefficients, interval, starts, states, h, count, ends, status, m):
    total = 0
    x = states[0].copy()
    for k in range(len(starts)):
        x[:] = states[k]
        status[k], evaluations = advance(
            method, p, scales, coefficients, interval, starts[k], h, count, x, ends[k], m
        )
        total += evaluations
    return total


def sweep(problems: list[Problem], method: str, step: float):
    """Return ends (n, 6), status (n,) and evaluations of the stretches of one motion."""
    starts = np.array([problem.start for problem in problems])
    states = np.array([problem.state for problem in problems])
    ends, status = np.empty_like(states), np.zeros(len(problems), np.int64)
    count = max(1, round(STRETCH / step))
    first = problems[0]
    evaluations = _sweep(
        METHODS.index(method), first.p, first.scales, first.coefficients, first.interval,
        starts, states, STRETCH / count, count, ends, status, np.zeros(SCRATCH),
    )  # fmt: skip
    return ends, status, evaluations


def predict_all(scenes, solutions, method, step, clock: Callable[[], float], repeats=5):
    """
    Return the Prediction of a method at a step.

    Parameters
    ----------
    scenes : list of list of Problem
        The stretches of each motion.
    solutions : list of ndarray, shape (n, 6)
        From `solved`.
    method, step
        Of METHODS, and [s].
    clock : callable
        Returns a time [s].
    repeats : int
        The least of so many times counts.

    """
    least, found = np.inf, None
    for _ in range(repeats):
        begun = clock()
        found = [sweep(problems, method, step) for problems in scenes]
        least = min(least, clock() - begun)
    parts = [(problems, ends, status == CONVERGED, evaluations)
             for problems, (ends, status, evaluations) in zip(scenes, found)]  # fmt: skip
    return _scored(method, step, parts, solutions, least)


def yardstick(scenes, solutions, name, rtol, clock: Callable[[], float]) -> Prediction:
    """Return the Prediction of a scipy integrator; its time is that of Python code around it."""
    parts, begun = [], clock()
    for problems in scenes:
        found = [by_scipy(problem, name, rtol) for problem in problems]
        parts.append((problems, np.array([f.state for f in found]),
                      np.array([f.status == CONVERGED for f in found]),
                      sum(f.evaluations for f in found)))  # fmt: skip
    return _scored(name, rtol, parts, solutions, clock() - begun)


def solved(scenes) -> tuple[list, list]:
    """
    Return the stretches that have a solution, and their ends.

    A stretch along which rigid motion ends (a contact wedges under the held spline) is left out.
    """
    kept, ends = [], []
    for problems in scenes:
        found = [(problem, by_scipy(problem)) for problem in problems]
        found = [(problem, end.state) for problem, end in found if end.status == CONVERGED]
        kept.append([problem for problem, _ in found])
        ends.append(np.array([state for _, state in found]))
    return kept, ends


def _scored(method, setting, parts, solutions, seconds):
    errors, speeds, lost, total, evaluations = [], [], 0, 0, 0
    for (problems, ends, good, count), exact in zip(parts, solutions):
        evaluations += count
        for problem, end, fine, true in zip(problems, ends, good, exact):
            total += 1
            angle, speed = differences(problem, end, true)
            if not (fine and angle < ANGLE_LOST and speed < SPEED_LOST):
                # Left out, what is lost would make a method look better the more it loses.
                lost, angle, speed = lost + 1, ANGLE_LOST, SPEED_LOST
            errors.append(angle)
            speeds.append(speed)
    rms = [float(np.sqrt(np.mean(np.square(values)))) for values in (errors, speeds)]
    per_ms = 1e6 * seconds / (total * STRETCH * 1e3)
    return Prediction(method, setting, *rms, lost / total, evaluations / total, per_ms)
