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
from math import inf, isnan, nan
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np

from grid_score import INTERVAL
from peg_on_hole_ros.edges.simulation_file import read_plan
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.simulation.measure import START_NS, measure, sensor_wrench
from peg_on_hole_ros.simulation.truth import integrate

PLAN = Path(__file__).parents[1] / "config" / "working_cycle.yaml"
# None that a setting of the filter was chosen on.
FIRST_SEED = 6100
# Force [N] and torque [N m], standard deviations.
STATED = ((0.0, 0.0), (0.5, 0.005), (1.0, 0.01), (2.0, 0.02))


class Cycle(NamedTuple):
    """
    What became of one cycle.

    Attributes
    ----------
    late : float
        How long after the first touch-down contact was found [ms].
    share : float
        Of the reactions that were determined, within 95 % bounds, of K, B1 and B2 the least.
    root : float
        Root mean square of their errors [N].
    slow : float
        Wrenches without a step in a direction that is told.
    told : dict of str to float
        `~/monitor` at the touch-down.
    normalised : float
        Error squared of the bias then, normalised; NaN: none is stated.

    """

    late: float
    share: float
    root: float
    slow: float
    told: dict
    normalised: float


def cycle(truth, stated, bias, seed, hears=True, seconds=inf) -> Cycle:
    """
    Play a truth whose sensor is off.

    Parameters
    ----------
    truth : Truth
    stated : tuple of 2 float
        Standard deviations of force [N] and torque [N m].
    bias : ndarray, shape (6,)
        [N], [N m].
    seed : int
        Of the noise.
    hears : bool
        Whether anything is learnt in the air.
    seconds : float
        After the touch-down, until which it is played [s].

    """
    plain = truth.plan.configuration
    wrench = replace(plain.wrench, bias_force_stddev=stated[0], bias_torque_stddev=stated[1])
    pipeline = Pipeline(replace(plain, wrench=wrench))
    if not hears:
        pipeline.filter.in_the_air = lambda hangs: None
    down = next(t_ns for t_ns, text in truth.events if text.startswith("touch-down"))
    row_of = {int(t): k for k, t in enumerate(truth.t_ns)}
    late = normalised = nan
    told, off, inside = {}, [], []
    for outputs in pipeline.play(measure(truth, seed, exact=sensor_wrench(truth) + bias)):
        t_ns = outputs.t_ns - START_NS
        if t_ns > down + seconds * 1e9:
            break
        if t_ns == down:
            told = outputs.monitor
            if wrench.bias_force_stddev:
                error = pipeline.filter.offset[:6] - bias
                P = pipeline.filter.offset_spread[:6, 2:8]
                normalised = float(error @ np.linalg.solve(P, error))
        if t_ns > down and isnan(late) and outputs.contact_mode != "open":
            late = (t_ns - down) * 1e-6
        if outputs.contact_mode == "three_point" and outputs.monitor["reactions_determined"]:
            error = np.abs(outputs.normal - truth.normal[row_of[t_ns]])
            off.append(error)
            inside.append(error <= INTERVAL * np.asarray(outputs.normal_stddev))
    share, root = np.mean(inside, axis=0).min(), np.sqrt(np.mean(np.square(off)))
    slow = float(pipeline.counts["step_without_direction"])
    return Cycle(late, float(share), float(root), slow, told, normalised)


def compute(task):
    """Return the cycles of all seeds of one statement."""
    stated, hears, seeds = task
    truth, found = integrate(read_plan(PLAN)), []
    for seed in range(FIRST_SEED, FIRST_SEED + seeds):
        bias = np.random.default_rng(seed).normal(size=6) * np.repeat(stated, 3)
        found.append(cycle(truth, stated, bias, seed, hears))
    return found


def main():
    """Print one row for each statement."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--seeds", type=int, default=12)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args()
    tasks = [(stated, hears, options.seeds) for stated in STATED for hears in (True, False)]
    tasks.remove(((0.0, 0.0), False, options.seeds))
    print("| stated | the air | contact found after | normalised | reactions | no direction |")
    print("|---|---|---|---|---|---|")
    with get_context("spawn").Pool(options.workers) as pool:
        for (stated, hears, _), found in zip(tasks, pool.imap(compute, tasks), strict=True):
            root = np.sqrt(np.mean([one.root**2 for one in found]))
            cells = (
                f"{stated[0]:g} N, {stated[1]:g} N m",
                "tells" if hears else "tells nothing",
                f"{np.median([one.late for one in found]):.0f} ms",
                f"{np.mean([one.normalised for one in found]):.1f}",
                f"{np.mean([one.share for one in found]):.1%}, {root:.2g} N",
                f"{np.median([one.slow for one in found]):.0f}",
            )
            print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
