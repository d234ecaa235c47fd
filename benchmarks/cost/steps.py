"""
What the compiled step of the estimator costs, and what an older checkout's does in the same run.

    python -m benchmarks.cost.steps [--repetitions 15] [--against CHECKOUT]

A step takes what one pair of messages brings: predict over 2 ms, hold against and correct by the
orientation, weigh by the wrench, reactions with their covariance. The steps are those of the
sample bag `closing_with_slip`, the first 50 left out: by then the mixture has settled to one
friction. The other checkout has its own script for the same, `benchmarks/kernel_step.py` (commit
5136dcb and before).
"""

import argparse
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np

from benchmarks.bag_steps import bag_steps
from benchmarks.cost.turns import in_turns
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.parameters_file import read_parameters
from peg_on_hole_ros.estimator import filter_steps
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.methods.registry import METHODS
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.mechanics.kernel import compiled

ROOT = Path(__file__).parents[2]
SAMPLE = "closing_with_slip"
STARTED = 50
LIMITS = {"friction known, one level": 5.0, "friction learnt, all levels": 25.0}
# How far friction is stated from what it is, and to what deviation.
OFF, SPREAD = 0.05, 0.05


@compiled
def run(memory, gates, dt, wrenches, angles, covariances):
    """Take all steps."""
    for k in range(len(wrenches)):
        filter_steps.predict(memory, dt)
        filter_steps.correct(memory, gates, angles[k], covariances[k])
        filter_steps.correct_by_wrench(memory, wrenches[k], 3)


class Bench:
    """The steps of the bag, and an estimator that has been through the first of them."""

    def __init__(self, one_level: bool):
        configuration = from_parameters(read_parameters(ROOT / "config" / f"{SAMPLE}.yaml"))
        steps = bag_steps(ROOT / "bags" / f"{SAMPLE}.mcap", configuration)
        self.dt = 2 * steps[1].dt
        steps = [step for step in steps if step.q is not None]
        scene = replace(configuration.scene, friction_stddev=0.0)
        if not one_level:
            scene = replace(scene, friction=scene.friction + OFF, friction_stddev=SPREAD)
        settings = default_settings(**METHODS["one_level" if one_level else "mixture"].settings)
        reduction = WrenchReduction(configuration.wrench, scene)
        self.kalman = ContactFilter(
            scene, configuration.filter, reduction.covariance, settings=settings
        )
        self.arrays = (
            np.array([step.u for step in steps]),
            np.array([step.q for step in steps]),
            np.array([step.R for step in steps]),
        )
        self.kalman.start(steps[0].q, steps[0].R)
        self._take(0, STARTED)
        self.hypotheses = self.kalman.hypotheses
        self._started = self.kalman.snapshot()

    def _take(self, first, last):
        run(self.kalman.memory, self.kalman.gates, self.dt, *(a[first:last] for a in self.arrays))

    def begin(self) -> None:
        """Go back to where the first steps are taken."""
        self.kalman.restore(self._started)

    def take(self) -> None:
        """Take all steps but the first."""
        self._take(STARTED, None)

    @property
    def steps(self) -> int:
        """Return how many steps that are."""
        return len(self.arrays[0]) - STARTED


def elsewhere(checkout: Path) -> float:
    """Return the median of another checkout's compiled step [us]."""
    folder = Path(os.environ.get("NUMBA_CACHE_DIR", checkout / ".numba_cache")).parent
    environment = dict(os.environ, PYTHONPATH=str(checkout), NUMBA_CACHE_DIR=str(folder))
    told = subprocess.run(
        [sys.executable, "benchmarks/kernel_step.py", "--repetitions", "5"],
        cwd=checkout, env=environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    return float(re.search(r"in compiled code\s+([\d.]+) us", told.stdout)[1])


def main(arguments=None):
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--repetitions", type=int, default=15)
    parser.add_argument("--against", type=Path, help="an older checkout")
    options = parser.parse_args(arguments)
    benches = {name: Bench(one_level) for name, one_level in zip(LIMITS, (True, False))}
    ways = {name: bench.take for name, bench in benches.items()}

    def begin(name):
        benches[name].begin()

    in_turns(ways, 1, perf_counter, begin)
    turns = in_turns(ways, options.repetitions, perf_counter, begin)
    other = elsewhere(options.against.resolve()) if options.against else None
    print("| step | frictions | median [us] | least [us] | limit [us] | over the other's |")
    print("|---|---|---|---|---|---|")
    for name, bench in benches.items():
        median, least = (1e6 * t(name) / bench.steps for t in (turns.median, turns.least))
        ratio = f"{median / other:.1f}" if other else ""
        print(
            f"| {name} | {bench.hypotheses} | {median:.1f} | {least:.1f} "
            f"| {LIMITS[name]:g} | {ratio} |"
        )
    if other:
        print(f"| the other's | | {other:.1f} | | | 1 |")


if __name__ == "__main__":
    main()
