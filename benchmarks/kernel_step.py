"""
What a filter step costs: compiled, called from Python, in the pipeline, and by filterpy.

    python benchmarks/kernel_step.py [--bag BAG --config CONFIG] [--repetitions 9] [--csv FILE]

A step is all that one pair of messages asks for: hold the wrench, predict state and covariance,
correct with the orientation, reactions with their covariance. Every way is run over the same
steps, repetition by repetition in turn, so that a busy machine slows all of them alike; printed
are medians and minima over the repetitions of the mean over the steps. filterpy's
ExtendedKalmanFilter runs on the numpy model with derivatives by complex steps, which is the
reference that the tests hold the kernel to.
"""

import argparse
import csv
import platform
import sys
from pathlib import Path
from time import perf_counter

import numpy as np
from peg_on_hole_ros.estimation.kernel import correction, prediction
from peg_on_hole_ros.estimation.kernel.cycle import correct_and_follow
from peg_on_hole_ros.estimation.kernel.held_wrench import hold_wrench
from peg_on_hole_ros.estimation.kernel.memory import SIZE, R
from peg_on_hole_ros.estimation.kernel.reactions import react

from peg_on_hole_ros.configuration import from_parameters
from peg_on_hole_ros.edges.config_file import read_parameters
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.pipeline import Pipeline
from side_by_side import bag_samples, bag_steps, filters

ROOT = Path(__file__).parents[1]
SAMPLE = "closing_with_slip"


@compiled
def run_compiled(m, dy, slopes, dt, wrenches, angles, covariances, acceleration_stddev):
    """Run all steps; return how often the six equations were solved."""
    total = 0
    for k in range(len(wrenches)):
        hold_wrench(m, wrenches[k])
        _, evaluations, _ = prediction.predict_contact(m, dy, slopes, dt)
        total += evaluations
        for i in range(9):
            m[R + i] = covariances[k, i]
        correct_and_follow(m, correction.innovation(m, angles[k]), dt)
        react(m, dy, acceleration_stddev)
    return total


class Bench:
    """The steps of a bag, and one method for each way to run them; all return seconds."""

    def __init__(self, configuration: Configuration, bag: Path):
        self.configuration = configuration
        self.samples = list(bag_samples(bag, configuration))
        steps = [step for step in bag_steps(bag, configuration) if step.q is not None]
        # The first few find the rates; what is timed is the filter under way.
        self.start, self.steps = steps[:50], steps[50:]
        self.dt = 2 * steps[1].dt
        kalman, reference = filters(configuration, self.start[0])
        for step in self.start[1:]:
            self._step(kalman, step)
        self.kalman, self.reference = kalman, reference
        self._started = kalman._memory.copy()
        self._joint = kalman.joint_covariance()
        self._arrays = (
            np.array([step.u for step in self.steps]),
            np.array([step.q for step in self.steps]),
            np.array([step.R.ravel() for step in self.steps]),
        )
        self.evaluations = 0

    def _step(self, kalman, step):
        kalman.hold(step.u)
        kalman.predict(self.dt, in_contact=True)
        kalman.correct(step.q, step.R)
        kalman.reactions()

    def _restore(self):
        self.kalman._memory[:] = self._started

    def compiled(self) -> float:
        """Run all steps in one compiled function."""
        self._restore()
        kalman, spread = self.kalman, self.configuration.filter.acceleration_stddev
        begun = perf_counter()
        self.evaluations = run_compiled(
            kalman._memory, kalman._dy, kalman._slopes, self.dt, *self._arrays, spread
        )
        return perf_counter() - begun

    def called(self) -> float:
        """Call the filter's methods from Python."""
        self._restore()
        begun = perf_counter()
        for step in self.steps:
            self._step(self.kalman, step)
        return perf_counter() - begun

    def pipeline(self) -> float:
        """Put all samples through the pipeline; a wrench with its outputs is a step."""
        pipeline = Pipeline(self.configuration)
        begun = perf_counter()
        wrenches = sum(1 for _ in pipeline.play(self.samples))
        return (perf_counter() - begun) / wrenches * len(self.steps)

    def filterpy(self) -> float:
        """Run the EKF of filterpy on the numpy model."""
        reference = self.reference
        self._restore()
        kalman = self.kalman
        parameters = kalman.friction[0], kalman.peg_diameter[0]
        reference.x = np.concatenate([kalman.x, kalman.u, parameters])
        reference.P = self._joint.copy()
        begun = perf_counter()
        for step in self.steps:
            reference.hold(step.u)
            reference.predict_contact(self.dt)
            reference.correct(step.q, step.R)
            reference.reactions(self.configuration.filter.acceleration_stddev)
        return perf_counter() - begun


WAYS = {
    "compiled": "kernel step, in compiled code",
    "called": "the same, filter's methods called from Python",
    "pipeline": "pipeline: a wrench and its joint states to outputs",
    "filterpy": "filterpy's EKF on the numpy model",
}


def measured(bench: Bench, repetitions: int) -> dict[str, np.ndarray]:
    """Return microseconds a step for each way and repetition, interleaved."""
    seconds = {way: [] for way in WAYS}
    for way in ("compiled", "called", "pipeline"):
        getattr(bench, way)()
    for _ in range(repetitions):
        for way, found in seconds.items():
            found.append(getattr(bench, way)())
    return {way: 1e6 * np.array(found) / len(bench.steps) for way, found in seconds.items()}


def main(arguments=None) -> int:
    """Measure, print the table, write the CSV."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--bag", type=Path, default=ROOT / "bags" / f"{SAMPLE}.mcap")
    parser.add_argument("--config", type=Path, default=ROOT / "config" / f"{SAMPLE}.yaml")
    parser.add_argument("--repetitions", type=int, default=9)
    parser.add_argument("--csv", type=Path)
    options = parser.parse_args(arguments)
    configuration = from_parameters(read_parameters(options.config))
    bench = Bench(configuration, options.bag)
    found = measured(bench, options.repetitions)
    count = len(bench.steps)
    print(
        f"{options.bag.name}: {count} steps of {bench.dt * 1e3:g} ms, "
        f"{bench.evaluations / count:.1f} solutions of the six equations a prediction, "
        f"{8 * SIZE / 1024:.0f} KiB of memory; {options.repetitions} repetitions; "
        f"{platform.processor() or platform.machine()}, Python {platform.python_version()}"
    )
    rows = []
    for way, text in WAYS.items():
        median, least = np.median(found[way]), found[way].min()
        # Within one repetition both saw the same machine.
        ratio = np.median(found["filterpy"] / found[way])
        rows.append((way, f"{median:.2f}", f"{least:.2f}", f"{ratio:.0f}"))
        print(f"{text:52s} {median:9.2f} us  (least {least:9.2f})  filterpy / this {ratio:6.0f}")
    if options.csv:
        with options.csv.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(("way", "median_us", "least_us", "filterpy_over_this"))
            writer.writerows(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
