"""
Tell whether the wedges of rigid contacts stop a peg whose contacts give a little.

    python -m benchmarks.engines.wedge_stiffness [--scenes 20] [--stiffness 1e8 1e9 1e10 1e11]

Each scene of the family `wedge` that rigid contacts bring to a stop is simulated anew from 20 ms
before the stop, with contacts of a stiffness and six degrees of freedom: that model knows no
determinant and solves for no reactions. Told is how many pegs stopped for 2 ms at least, within
60 ms, and the largest reaction.
"""

import argparse

import numpy as np

from benchmarks.scenes.draw import Case, plan_of
from benchmarks.scenes.labels import STILL, labels_of
from benchmarks.scenes.play import truth_of
from peg_on_hole_ros.sim.parted import parted_state, pushes, run_parted
from peg_on_hole_ros.sim.run import Run

BEFORE, SPAN = 0.02, 0.06
AT_REST = 2  # samples


def wedges(count):
    """Yield (plan, truth, when it stopped) of so many scenes that wedge on rigid contacts."""
    number = 0
    while count:
        plan = plan_of(Case("wedge", number))
        truth, _ = truth_of(plan)
        number += 1
        events = labels_of(truth).events if truth else ()
        times = [event.begin for event in events if event.cause == "wedge"]
        if times and times[0] > BEFORE:
            count -= 1
            yield plan, truth, times[0]


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


def main(arguments=None):
    """Print one row a stiffness."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--stiffness", type=float, nargs="+", default=[1e8, 1e9, 1e10, 1e11])
    options = parser.parse_args(arguments)
    found = list(wedges(options.scenes))
    print("| stiffness [N/m] | stopped | largest reaction, median [N] | rigid, median [N] |")
    print("|---|---|---|---|")
    rigid = np.median([truth.normal.max() for _, truth, _ in found])
    for stiffness in options.stiffness:
        ends = [soft(*scene, stiffness) for scene in found]
        largest = np.median([load for _, load in ends])
        stopped = sum(stop for stop, _ in ends)
        print(f"| {stiffness:.0e} | {stopped} of {len(ends)} | {largest:.0f} | {rigid:.0f} |")


if __name__ == "__main__":
    main()
