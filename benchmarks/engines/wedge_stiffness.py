"""
Tell whether the wedges of rigid contacts stop a peg whose contacts give a little.

Each scene of the family `wedge` that rigid contacts bring to a stop is simulated anew from 20 ms
before the stop, with contacts of a stiffness and six degrees of freedom: that model knows no
determinant and solves for no reactions. Told is how many pegs stopped for 2 ms at least, within
60 ms, and the largest reaction.
"""

from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.harness.family import Family, Member, Report
from benchmarks.harness.tables import table
from benchmarks.harness.truths import truth_of
from benchmarks.scenes import draw, families, labels
from benchmarks.scenes.draw import Case, plan_of
from benchmarks.scenes.labels import STILL, labels_of
from peg_on_hole_ros.sim.parted import parted_state, pushes, run_parted
from peg_on_hole_ros.sim.run import Run

BEFORE, SPAN = 0.02, 0.06
AT_REST = 2  # samples


@cache
def wedges(count: int) -> list[tuple]:
    """Return (plan, truth, when it stopped) of so many scenes that wedge on rigid contacts."""
    found, number = [], 0
    while len(found) < count:
        plan = plan_of(Case("wedge", number))
        truth, _ = truth_of(plan)
        number += 1
        events = labels_of(truth).events if truth else ()
        times = [event.begin for event in events if event.cause == "wedge"]
        if times and times[0] > BEFORE:
            found.append((plan, truth, times[0]))
    return found


def soft(plan, truth, stopped, stiffness):
    """Return whether a peg on contacts that give stops, and the largest reaction [N]."""
    model = Run(plan, None).model
    k = int(np.searchsorted(truth.t_ns * 1e-9, stopped - BEFORE))
    t0 = truth.t_ns[k] * 1e-9 + plan.lead_in
    state = np.concatenate([truth.q[k], truth.rates[k]])
    y = parted_state(model, state, truth.normal[k], stiffness)
    samples = t0 + np.arange(0, SPAN, 1e-3)
    limits = plan.holder.force_limit, plan.holder.torque_limit
    run = run_parted(model, t0, y, samples, t0 + SPAN, limits, plan.rtol, stiffness)
    slip, largest = [], 0.0
    for s in run.states:
        x = np.zeros((3, 6))
        x[0], x[1] = s[:6], s[6:]
        _, _, normal, speed = pushes(model.p, x, model.scale, stiffness)
        slip.append(speed.max())
        largest = max(largest, normal.max())
    still = np.array(slip) < STILL
    return bool(np.convolve(still, np.ones(AT_REST), "valid").max() == AT_REST), float(largest)


def score_member(contacts: Member, folder: Path) -> dict:
    """Return whether each peg stopped, and its largest reaction, here and on rigid contacts."""
    stiffness, scenes = contacts.of
    found = wedges(scenes)
    return {
        "ends": [soft(*scene, stiffness) for scene in found],
        "rigid": [float(truth.normal.max()) for _, truth, _ in found],
    }


def report(found, options) -> Report:
    """Return a row for each stiffness."""
    rows = []
    for contacts, tree in found:
        stopped = f"{sum(stop for stop, _ in tree['ends'])} of {len(tree['ends'])}"
        medians = np.median([load for _, load in tree["ends"]]), np.median(tree["rigid"])
        rows.append((contacts, stopped, *(f"{load:.0f}" for load in medians)))
    head = "stiffness [N/m]", "stopped", "largest reaction, median [N]", "rigid, median [N]"
    return Report(table(head, rows))


def add_options(parser) -> None:
    """Add how many scenes, and which stiffnesses."""
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--stiffness", type=float, nargs="+", default=[1e8, 1e9, 1e10, 1e11])


def members(options) -> list[Member]:
    """Return each stiffness of all contacts [N/m], with how many scenes."""
    return [Member(f"{each:.0e}", (each, options.scenes)) for each in options.stiffness]


FAMILY = Family(members, score_member, report, add_options, sources=(draw, families, labels))
