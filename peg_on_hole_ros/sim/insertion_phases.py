"""The phases of a plan in which the peg is inserted."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from peg_on_hole_ros.sim.command import evaluate
from peg_on_hole_ros.sim.contact_run import contact_samples
from peg_on_hole_ros.sim.dynamics import angular_velocity, rotation
from peg_on_hole_ros.sim.holder import mass_centre
from peg_on_hole_ros.sim.hole_forces import surface_of
from peg_on_hole_ros.sim.insertion import Insertion
from peg_on_hole_ros.sim.insertion_block import insertion_block
from peg_on_hole_ros.sim.insertion_program import begin_of, place_program

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
