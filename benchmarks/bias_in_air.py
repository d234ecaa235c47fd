"""
What the time in the air before contact is worth to a sensor whose zero is not known.

    python benchmarks/bias_in_air.py [--seeds 12]

The sample plan `working_cycle`, 1.2 s in the air before it touches; biases are drawn for each seed
from what is stated. Of each statement, with what the air tells and without: how long after the
touch-down contact is found (median); the normalised error squared of the bias then, mean; which
share of the reactions that are determined lies within 95 % bounds, of K, B1 and B2 the least, and
the root mean square of their errors; the wrenches without a step in a direction that is told.
"""

import argparse
import os
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from grid_score import INTERVAL
from peg_on_hole_ros.edges.simulation_file import read_plan
from peg_on_hole_ros.estimation.filters.methods import make_filter
from peg_on_hole_ros.estimation.filters.offset import OffsetFilter
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.simulation.measure import START_NS, measure, sensor_wrench
from peg_on_hole_ros.simulation.truth import integrate

PLAN = Path(__file__).parents[1] / "config" / "working_cycle.yaml"
# None that a setting of the filter was chosen on.
FIRST_SEED = 6100
# Force [N] and torque [N m], standard deviations.
STATED = ((0.0, 0.0), (0.5, 0.005), (1.0, 0.01), (2.0, 0.02))


class Deaf(OffsetFilter):
    """The filter that learns nothing in the air."""

    def in_the_air(self, hangs):
        """Learn nothing."""


def _deaf(scene, options, noise, offsets=None):
    made = Deaf if offsets is not None and offsets.variance.any() else make_filter
    return made(scene, options, noise, offsets)


def run(truth, exact, stated, seed, told):
    """
    Return what became of one cycle.

    Returns
    -------
    tuple of 5 float
        Latency [ms], normalised error squared of the bias at the touch-down (NaN: none), least
        share within bounds, root mean square of the reactions' errors [N], wrenches without a step
        in a direction.

    """
    plain = truth.plan.configuration
    wrench = replace(plain.wrench, bias_force_stddev=stated[0], bias_torque_stddev=stated[1])
    pipeline = Pipeline(replace(plain, wrench=wrench), make=make_filter if told else _deaf)
    bias = np.random.default_rng(seed).normal(size=6) * np.repeat(stated, 3)
    down = next(t_ns for t_ns, text in truth.events if text.startswith("touch-down"))
    row_of = {int(t): k for k, t in enumerate(truth.t_ns)}
    late = normalised = np.nan
    off, inside = [], []
    for outputs in pipeline.play(measure(truth, seed, exact=exact + bias)):
        t_ns = outputs.t_ns - START_NS
        if t_ns == down and wrench.bias_force_stddev:
            error, P = pipeline.filter.offset[:6] - bias, pipeline.filter.offset_spread[:6, 2:8]
            normalised = error @ np.linalg.solve(P, error)
        if t_ns > down and late != late and outputs.contact_mode != "open":
            late = (t_ns - down) * 1e-6
        if outputs.contact_mode == "three_point" and outputs.monitor["reactions_determined"]:
            error = np.abs(outputs.normal - truth.normal[row_of[t_ns]])
            off.append(error)
            inside.append(error <= INTERVAL * np.asarray(outputs.normal_stddev))
    slow = float(pipeline.counts["step_without_direction"])
    share, root = np.mean(inside, axis=0).min(), np.sqrt(np.mean(np.square(off)))
    return late, normalised, share, root, slow


def compute(task):
    """Return the rows of all seeds of one statement."""
    stated, told, seeds = task
    truth = integrate(read_plan(PLAN))
    exact = sensor_wrench(truth)
    return [run(truth, exact, stated, FIRST_SEED + seed, told) for seed in range(seeds)]


def main():
    """Print one row for each statement."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--seeds", type=int, default=12)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args()
    tasks = [(stated, told, options.seeds) for stated in STATED for told in (True, False)]
    tasks.remove(((0.0, 0.0), False, options.seeds))
    print("| stated | the air | contact found after | normalised | reactions | no direction |")
    print("|---|---|---|---|---|---|")
    with get_context("spawn").Pool(options.workers) as pool:
        for (stated, told, _), rows in zip(tasks, pool.imap(compute, tasks), strict=True):
            late, normalised, share, root, slow = np.array(rows).T
            root = np.sqrt(np.mean(root**2))
            cells = (
                f"{stated[0]:g} N, {stated[1]:g} N m",
                "tells" if told else "tells nothing",
                f"{np.median(late):.0f} ms",
                f"{normalised.mean():.1f}",
                f"{share.mean():.1%}, {root:.2g} N",
                f"{np.median(slow):.0f}",
            )
            print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
