"""
What a wrench costs in the pipeline, where it goes, and what can be left out.

    python -m benchmarks.cost.pipeline_cost [--sample closing_with_slip] [--repetitions 30]
        [--csv FILE]

All samples of a bag go through one pipeline after another: as configured by default; without what
late messages need (`filter.late_window: 0.0`); without modes, forecast, risk and alarms
(`monitor.modes: false`); without either; and one whose parts are timed. They take turns, so that a
busy machine slows all of them alike; printed are medians and minima over the repetitions, and the
median of the ratio to the default within a turn. Times are of the processor for the whole, and of
the wall clock for the parts; what timing the parts costs is in their shares, mostly the last.
"""

import argparse
import csv
import platform
import sys
from collections import Counter
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from time import perf_counter, process_time
from unittest.mock import patch

import numpy as np

from benchmarks.bag_steps import bag_samples
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.config.parameters_file import read_parameters
from peg_on_hole_ros.engine import engine, pipeline
from peg_on_hole_ros.engine.pipeline import Pipeline

ROOT = Path(__file__).parents[2]
ALL, NONE_LATE, NO_MODES, NEITHER = (
    "as configured",
    "no message can be late",
    "no modes, forecast, risk, alarms",
    "neither",
)
ENGINE, OUTPUTS, INPUT, REST = (
    "estimate, modes, alarms, compiled",
    "outputs built",
    "samples to measurements",
    "the rest",
)


def variants(configuration: Configuration) -> dict[str, Configuration]:
    """Return the configurations that are compared, by what they leave out."""
    kalman = replace(configuration.filter, late_window=0.0)
    monitor = replace(configuration.monitor, modes=False)
    return {
        ALL: configuration,
        NONE_LATE: replace(configuration, filter=kalman),
        NO_MODES: replace(configuration, monitor=monitor),
        NEITHER: replace(configuration, filter=kalman, monitor=monitor),
    }


def timed(line: Pipeline) -> list:
    """Return (owner, name of a function, part) of all that is timed in a pipeline."""
    return [
        (engine, "push", ENGINE),
        (pipeline, "OutputView", OUTPUTS),
        (line, "orientation", INPUT),
    ]


class Parts:
    """
    Seconds that functions take by themselves, without those that they call, by part.

    Attributes
    ----------
    spent : Counter
        By part [s].

    """

    def __init__(self):
        self.spent: Counter[str] = Counter()
        self._inner = [0.0]

    def timing(self, function, part: str):
        """Return the function, timed."""

        def call(*arguments):
            self._inner.append(0.0)
            begun = perf_counter()
            found = function(*arguments)
            seconds = perf_counter() - begun
            self.spent[part] += seconds - self._inner.pop()
            self._inner[-1] += seconds
            return found

        return call


def whole(configuration: Configuration, samples) -> float:
    """Return seconds a wrench."""
    line = Pipeline(configuration)
    begun = process_time()
    wrenches = sum(1 for _ in line.play(samples))
    return (process_time() - begun) / wrenches


def in_parts(configuration: Configuration, samples) -> dict[str, float]:
    """Return seconds a wrench by part."""
    line, parts = Pipeline(configuration), Parts()
    with ExitStack() as stack:
        for owner, name, part in timed(line):
            function = parts.timing(getattr(owner, name), part)
            stack.enter_context(patch.object(owner, name, function))
        begun = perf_counter()
        wrenches = sum(1 for _ in line.play(samples))
        seconds = perf_counter() - begun
    parts.spent[REST] = seconds - parts.spent.total()
    return {part: spent / wrenches for part, spent in parts.spent.items()}


def measured(configuration: Configuration, samples, repetitions: int):
    """Return microseconds a wrench, an array over the repetitions, by variant and by part."""
    told = variants(configuration)
    for variant in told.values():
        whole(variant, samples)
    by_variant, by_part = {name: [] for name in told}, {}
    for _ in range(repetitions):
        for name, variant in told.items():
            by_variant[name].append(whole(variant, samples))
        for part, seconds in in_parts(configuration, samples).items():
            by_part.setdefault(part, []).append(seconds)
    return tuple(
        {name: 1e6 * np.array(found) for name, found in by.items()} for by in (by_variant, by_part)
    )


def main(arguments=None) -> int:
    """Measure, print the tables, write the CSV."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument(
        "--sample", default="closing_with_slip", help="a bag and its configuration"
    )
    parser.add_argument("--repetitions", type=int, default=30)
    parser.add_argument("--csv", type=Path)
    options = parser.parse_args(arguments)
    configuration = from_parameters(read_parameters(ROOT / "config" / f"{options.sample}.yaml"))
    samples = list(bag_samples(ROOT / "bags" / f"{options.sample}.mcap", configuration))
    by_variant, by_part = measured(configuration, samples, options.repetitions)
    print(
        f"{options.sample}: {options.repetitions} repetitions; "
        f"{platform.processor() or platform.machine()}, Python {platform.python_version()}"
    )
    total = np.sum(list(by_part.values()), axis=0)
    rows = []
    for name, found in by_variant.items():
        rows.append(("variant", name, np.median(found), found.min(), found / by_variant[ALL]))
    for name, found in sorted(by_part.items(), key=lambda item: -np.median(item[1])):
        rows.append(("part", name, np.median(found), found.min(), found / total))
    print(f"{'':8s} {'':34s} {'us a wrench':>11s} {'least':>7s} {'share':>7s}")
    table = []
    for kind, name, median, least, share in rows:
        texts = f"{median:.2f}", f"{least:.2f}", f"{np.median(share):.3f}"
        print(f"{kind:8s} {name:34s} {texts[0]:>11s} {texts[1]:>7s} {texts[2]:>7s}")
        table.append((kind, name, *texts))
    if options.csv:
        with options.csv.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(("kind", "name", "median_us", "least_us", "share"))
            writer.writerows(table)
    return 0


if __name__ == "__main__":
    sys.exit(main())
