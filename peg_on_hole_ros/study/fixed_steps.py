"""How long a step may be that integrates the equations of three contacts with a given wrench."""

from math import pi
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.sim.dynamics import TILT_FLOOR, motion, scene_numbers
from peg_on_hole_ros.sim.truth import Truth

EULER, RUNGE_KUTTA, ROSENBROCK = "Euler", "Runge-Kutta of order 4", "Rosenbrock of order 2"
INTEGRATORS = (EULER, RUNGE_KUTTA, ROSENBROCK)
# Slip speeds at which friction reaches 71 % of its law [m/s].
SLIP_SCALES = (1e-6, 3e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2)
# Of the motion; in it the turns reverse once, so that two slips pass through zero [s].
LASTS = 0.15
# Steps in each interval of the wrench, the coarsest first, and of what all are compared with.
_STEPS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256)
_FINEST = 512
# A step is short enough where the way of each angle is off by no more than this share of it.
_OFF = 0.01
_DIFFERENCE = 1e-7
_L_STABLE = 1.0 - 0.5**0.5


class Steps(NamedTuple):
    """
    What integrators make of the equations with one slip scale.

    Attributes
    ----------
    slip_scale : float
        Of the regularised friction law [m/s].
    law_off : float
        What the law is off by itself, in steps that are short enough: of an angle's way.
    longest : dict of str to float
        Of each integrator the longest step that keeps the equations [s]; NaN where none of those
        tried does.

    """

    slip_scale: float
    law_off: float
    longest: dict[str, float]


def longest_steps(truth: Truth, slip_scale: float) -> Steps:
    """
    Return the longest steps with which integrators follow a motion.

    Integrated are the equations of motion with the true wrench of the holder, in straight lines
    between its samples, from the true start: what an estimator does that is driven by the wrench.
    Compared is each angle with that in steps of a 512th of a sample, in shares of its way.

    Parameters
    ----------
    truth : Truth
        On three contacts for LASTS at least.
    slip_scale : float
        Of the regularised friction law [m/s].

    """
    exact = angles_of(truth, ROSENBROCK, slip_scale, _FINEST)
    sample = 1.0 / truth.plan.wrench_rate
    longest = dict.fromkeys(INTEGRATORS, float("nan"))
    for integrator in INTEGRATORS:
        for steps in reversed(_STEPS):
            if _off(angles_of(truth, integrator, slip_scale, steps), exact) > _OFF:
                break
            longest[integrator] = sample / steps
    return Steps(slip_scale, _off(exact, truth.q[: len(exact)]), longest)


def _off(angles, exact):
    """Return the largest error of an angle in shares of its way."""
    way = np.abs(np.diff(exact, axis=0)).sum(axis=0)
    off = np.abs(angles - exact).max(axis=0) / way
    return float(off.max()) if np.isfinite(off).all() else float("inf")


def angles_of(truth: Truth, integrator: str, slip_scale: float, steps: int) -> np.ndarray:
    """
    Return gamma, psi, phi of an integration at each sample [rad], shape (n, 3).

    Parameters
    ----------
    truth : Truth
    integrator : str
    slip_scale : float
        [m/s]
    steps : int
        In an interval of the wrench.

    Returns
    -------
    ndarray
        NaN from where the motion leaves the tilts at which the equations hold.

    """
    count = 1 + round(LASTS * truth.plan.wrench_rate)
    p = scene_numbers(truth.plan.configuration.scene)
    loads = np.hstack([truth.force[:count], truth.moment[:count]])
    start = np.hstack([truth.q[0], truth.rates[0]])
    interval = 1.0 / truth.plan.wrench_rate
    return _followed(p, start, loads, interval, steps, INTEGRATORS.index(integrator), slip_scale)


@compiled
def _rate(p: np.ndarray, state: np.ndarray, load: np.ndarray, scale: float) -> np.ndarray:
    """Return the rate of gamma, psi, phi and of their rates, shape (6,)."""
    out = np.empty(6)
    out[:3] = state[3:]
    out[3:] = motion(p, state[:3].copy(), state[3:].copy(), load[:3].copy(), load[3:].copy(),
                     scale)[:3]  # fmt: skip
    return out


@compiled
def _jacobian(p: np.ndarray, state: np.ndarray, load: np.ndarray, scale: float) -> np.ndarray:
    """Return the derivative of `_rate` by the state, by differences, shape (6, 6)."""
    base = _rate(p, state, load, scale)
    out = np.empty((6, 6))
    for j in range(6):
        moved = state.copy()
        # Of rates: far below the slip at which friction turns.
        by = _DIFFERENCE if j < 3 else _DIFFERENCE * (1.0 + 1e4 * scale)
        moved[j] += by
        out[:, j] = (_rate(p, moved, load, scale) - base) / by
    return out


@compiled
def _followed(
    p: np.ndarray, start: np.ndarray, loads: np.ndarray, interval: float, steps: int,
    kind: int, scale: float,
) -> np.ndarray:  # fmt: skip
    """Integrate over all intervals of the wrench; kinds are the places in INTEGRATORS."""
    n = loads.shape[0]
    out = np.full((n, 3), np.nan)
    state = start.copy()
    h = interval / steps
    for i in range(n):
        tilt = state[0]
        if not np.isfinite(state).all() or tilt < p[7] + TILT_FLOOR or tilt > pi / 2:
            break
        out[i] = state[:3]
        if i == n - 1:
            break
        slope = (loads[i + 1] - loads[i]) / interval
        for k in range(steps):
            load = loads[i] + k * h * slope
            middle, end = load + 0.5 * h * slope, load + h * slope
            k1 = _rate(p, state, load, scale)
            if kind == 0:
                state = state + h * k1
            elif kind == 1:
                k2 = _rate(p, state + 0.5 * h * k1, middle, scale)
                k3 = _rate(p, state + 0.5 * h * k2, middle, scale)
                k4 = _rate(p, state + h * k3, end, scale)
                state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
            else:
                # Verwer and others (1999), linearly implicit and L-stable.
                W = np.eye(6) - _L_STABLE * h * _jacobian(p, state, load, scale)
                s1 = np.linalg.solve(W, k1)
                s2 = np.linalg.solve(W, _rate(p, state + h * s1, end, scale) - 2.0 * s1)
                state = state + h * (1.5 * s1 + 0.5 * s2)
    return out
