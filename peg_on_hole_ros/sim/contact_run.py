"""Integrate motion on three contacts until it ends by itself or its time is over."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.integrate import Radau

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.sim.dynamics import determinant
from peg_on_hole_ros.sim.holder import contact_motion, state_rate, state_rate_jacobian

# Where a motion is said to be at gamma0 [rad]: b is 0.07 mm there, B1 and B2 all but one.
TRANSITION_MARGIN = 1e-7
# The rigid model's determinant (1 without friction) at which sliding has no way on.
WEDGED_DETERMINANT = 1e-3
# A reaction below it [N] means that the contact lets go; above it is the integrator's rounding.
OPEN_REACTION = -1e-3
# Longest step [s]: nothing that opens and closes again within it is missed at the samples.
MAX_STEP = 2e-3
EVENTS = ("open K", "open B1", "open B2", "transition", "wedged", "force limit", "torque limit")


class ContactRun(NamedTuple):
    """
    A stretch of motion on three contacts.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Of the samples asked for that were reached [s].
    states : ndarray, shape (n, 6)
    t_end : float
        [s]
    state_end : ndarray, shape (6,)
    ended_by : str
        One of `EVENTS`, or `end`.
    steps : int
        Steps of the integrator.

    """

    t: np.ndarray
    states: np.ndarray
    t_end: float
    state_end: np.ndarray
    ended_by: str
    steps: int


class Model(NamedTuple):
    """The numbers that the compiled right-hand side needs; see `holder.state_rate`."""

    p: np.ndarray
    holder: np.ndarray
    knots: np.ndarray
    coefficients: np.ndarray
    scale: float


class Start(NamedTuple):
    """
    Where a motion on three contacts begins.

    Attributes
    ----------
    t : float
        [s]
    state : ndarray, shape (6,)
        gamma, psi, phi [rad] and rates [rad/s].
    unilateral_from : float
        Before it contacts may pull: a state to begin from is sought, nothing is recorded [s].

    """

    t: float
    state: np.ndarray
    unilateral_from: float = 0.0


def run_contact(
    model: Model,
    start: Start,
    samples: np.ndarray,
    t_end: float,
    limits: tuple[float, float],
    rtol: float,
    progress: Callable[[float], None] | None = None,
) -> ContactRun:
    """
    Integrate by Radau IIA of order 5 with dense output.

    Parameters
    ----------
    model : Model
    start : Start
    samples : ndarray
        Times wanted, rising, none before the start [s].
    t_end : float
        [s]
    limits : tuple of 2 float
        Force [N] and torque [N m] of the holder that end the run.
    rtol : float
        The absolute tolerance is a hundredth of it.
    progress : callable, optional
        Told the time reached.

    """

    def rate(t, y):
        return state_rate(t, y, *model)

    def jacobian(t, y):
        return state_rate_jacobian(t, y, *model)

    solver = Radau(
        rate,
        start.t,
        np.asarray(start.state, float),
        t_end,
        max_step=MAX_STEP,
        rtol=rtol,
        atol=rtol / 100,
        jac=jacobian,
    )
    taken, states, k, steps = [], [], 0, 0
    while solver.status == "running":
        try:
            solver.step()
        except ValueError:  # of scipy, where the rates are not finite
            raise PegOnHoleError(
                f"the motion has no finite acceleration after {solver.t:.6f} s, gamma, psi, phi = "
                f"{solver.y[:3]} rad, rates {solver.y[3:]} rad/s: slow the phase"
            ) from None
        if solver.status == "failed":
            if determinant(model.p, solver.y[:3], solver.y[3:], model.scale) > 0.1:
                raise PegOnHoleError(
                    f"no step of the integrator meets rtol = {rtol:g} at {solver.t:.6f} s, gamma, "
                    f"psi, phi = {solver.y[:3]} rad: loosen simulation.rtol, or slow the phase"
                )
            # The determinant falls through zero within the next step.
            return _run(taken, states, solver.t, solver.y, "wedged", steps)
        steps += 1
        dense = solver.dense_output()
        stop = solver.t
        event = ""
        checks = samples[(samples > solver.t_old) & (samples < solver.t)]
        for t in (*checks, solver.t):
            margins = _margins(model, limits, t, dense(t), start.unilateral_from)
            if margins.min() < 0:
                event, stop = _locate(model, limits, dense, solver.t_old, t, start.unilateral_from)
                break
        while k < len(samples) and samples[k] <= stop and samples[k] <= t_end:
            taken.append(samples[k])
            later = samples[k] > start.t
            states.append(dense(samples[k]) if later else np.array(start.state, float))
            k += 1
        if event:
            return _run(taken, states, stop, dense(stop), event, steps)
        if progress:
            progress(solver.t)
    return _run(taken, states, solver.t, solver.y, "end", steps)


def _run(taken, states, t, state, ended_by, steps):
    return ContactRun(
        np.array(taken), np.array(states).reshape(-1, 6), t, np.array(state), ended_by, steps
    )


def _margins(model, limits, t, state, unilateral_from):
    """Return what is left until each of `EVENTS`; negative once it has happened."""
    y = contact_motion(*model, t, state)  # type: ignore[call-arg]
    if t < unilateral_from:
        y[3:6] = np.abs(y[3:6])
    return np.array(
        [
            *(y[3:6] - OPEN_REACTION),
            state[0] - model.p[7] - TRANSITION_MARGIN,
            determinant(model.p, state[:3], state[3:], model.scale) - WEDGED_DETERMINANT,
            limits[0] - np.linalg.norm(y[6:9]),
            limits[1] - np.linalg.norm(y[9:12]),
        ]
    )


def _locate(model, limits, dense, low, high, unilateral_from):
    """Return the first event in a step and its time, by halving; no event at `low`."""
    while high - low > 1e-10:
        middle = (low + high) / 2
        if _margins(model, limits, middle, dense(middle), unilateral_from).min() < 0:
            high = middle
        else:
            low = middle
    margins = _margins(model, limits, high, dense(high), unilateral_from)
    # Wedging and the transition drive the reactions out of bounds: they are the cause.
    for cause in ("transition", "wedged"):
        if margins[EVENTS.index(cause)] < 0:
            return cause, low
    return EVENTS[int(np.argmin(margins))], low


def contact_samples(
    model: Model, t: np.ndarray, states: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """
    Return accelerations, reactions and the holder's wrench at states of a run.

    Returns
    -------
    acceleration, normal : ndarray, shape (n, 3)
        [rad/s^2], [N]
    force, moment : ndarray, shape (n, 3)
        Of the holder on the peg, about the mass centre, hole axes [N], [N m].

    """
    y = np.array([contact_motion(*model, ti, x) for ti, x in zip(t, states, strict=True)])
    y = y.reshape(-1, 12)
    return y[:, :3], y[:, 3:6], y[:, 6:9], y[:, 9:12]
