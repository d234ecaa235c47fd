"""The phases of a plan in which the peg is inserted, and what the holder is told to do in them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from peg_on_hole_ros.sim.command import evaluate, quintic
from peg_on_hole_ros.sim.contact_run import contact_samples
from peg_on_hole_ros.sim.dynamics import (
    angular_acceleration,
    angular_velocity,
    rotation,
)
from peg_on_hole_ros.sim.holder import mass_centre
from peg_on_hole_ros.sim.hole_forces import surface_of
from peg_on_hole_ros.sim.insertion import Insertion
from peg_on_hole_ros.sim.insertion_block import insertion_block
from peg_on_hole_ros.sim.plan import PlanPhase

if TYPE_CHECKING:
    from peg_on_hole_ros.sim.run import Run


def insert(run: Run) -> None:
    """
    Go into the hole and down it; only insert phases follow.

    Parameters
    ----------
    run : run.Run
        Simulated up to here; it gets the samples, and what ended them.

    """
    plan, begin = run.plan, run.t
    first = run.phase_index(begin)
    start = begin_of(run.knots, run.coefficients, run.model.p, begin - 1e-12)
    knots, pieces = place_program(plan.phases[first:], start, run.coefficients[first:, :3])
    run.take_friction()
    p = run.model.p
    insertion = Insertion(
        p,
        plan.configuration.scene.peg_height,
        run.model.holder,
        knots + begin,
        pieces,
        surface_of(p[3], plan.contact_stiffness),
    )
    x = np.zeros((3, 6))
    normal = None
    if run.state is None:
        x[:2] = evaluate(run.knots, run.coefficients, begin)[:2]
        x[:2, 3:] = 0
    else:
        x[0, :3], x[1, :3] = run.state[:3], run.state[3:]
        normal = contact_samples(run.model, np.array([begin]), run.state[None])[1][0]
    C, v, _ = mass_centre(p, x)
    V = np.concatenate([v, angular_velocity(x[0, :3], x[1, :3])])
    body = insertion.body(begin, C, rotation(x[0, :3]), V, normal)
    limits = plan.holder.force_limit, plan.holder.torque_limit
    passed, total = False, run.knots[-1]
    told = (lambda t: run.progress(t / total)) if run.progress else None  # type: ignore[misc]
    while not run.done():
        run.take_friction()
        insertion.take(run.model.p)
        end = run.stretch_end(("insert",))
        rows, body, run.t, ended = insertion.run(run.t, body, run.until(end), end, limits, told)
        if rows is not None:
            block = insertion_block(run.model.p, rows)
            run.blocks.append(block)
            below = (block["q"][:, 0] < run.model.p[7]) & block["closed"].any(axis=1)
            if not passed and below.any():
                passed = True
                k = int(below.argmax())
                run.events.append((float(rows.t[k]), "transition: the tilt is below gamma0"))
        if ended != "end":
            run.event(f"{ended} of the holder reached in the hole")
            run.ended_by = ended
    run.ended_by = run.ended_by or "end"


def place_program(
    phases: Sequence[PlanPhase], begin: np.ndarray, angles: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the commanded angles and place of phases in the hole, as knots and quintics.

    Parameters
    ----------
    phases : sequence of PlanPhase
        All of kind `insert`.
    begin : ndarray, shape (3, 3)
        Place x, y and depth of the lower end's centre when they begin [m], with rates and
        accelerations.
    angles : ndarray, shape (n, 3, 6)
        Quintics of gamma, psi, phi in these phases.

    Returns
    -------
    knots : ndarray, shape (n + 1,)
        From the begin of the first [s].
    coefficients : ndarray, shape (n, 6, 6)

    """
    now, knots, pieces = begin.copy(), [0.0], []
    for phase, turning in zip(phases, angles, strict=True):
        end = np.zeros((3, 3))
        end[1, 2] = phase.depth_rate
        end[0, :2] = now[0, :2] if phase.place is None else phase.place
        mean = (now[1, 2] + end[1, 2]) / 2
        end[0, 2] = now[0, 2] + mean * phase.duration if phase.depth is None else phase.depth
        pieces.append(np.concatenate([turning, quintic(now, end, phase.duration)]))
        knots.append(knots[-1] + phase.duration)
        now = end
    return np.array(knots), np.array(pieces)


def end_motion(p: np.ndarray, x: np.ndarray) -> np.ndarray:
    """
    Return place x, y and depth of the lower end's centre, with rates and accelerations.

    Parameters
    ----------
    p : ndarray
        Scene.
    x : ndarray, shape (3, 6)
        Angles and offset from the touching pose with rates and accelerations.

    Returns
    -------
    ndarray, shape (3, 3)
        [m], [m/s], [m/s^2] as rows.

    """
    q, rates = x[0, :3].copy(), x[1, :3].copy()
    w, zeta = angular_velocity(q, rates), rotation(q)[:, 2]
    alpha = angular_acceleration(q, rates, x[2, :3].copy())
    lever = -p[2] * np.array(
        [zeta, np.cross(w, zeta), np.cross(alpha, zeta) + np.cross(w, np.cross(w, zeta))]
    )
    return (mass_centre(p, x) + lever) * [1.0, 1.0, -1.0]


def begin_of(knots: np.ndarray, coefficients: np.ndarray, p: np.ndarray, t: float) -> np.ndarray:
    """Return what `end_motion` does, of where a program of angles and offsets is at t [s]."""
    return end_motion(p, evaluate(knots, coefficients, t))
