"""
How far the kernel's filter step is from the same step as generated C.

    python benchmarks/c_limit.py [--bag BAG --config CONFIG] [--repetitions 15] [--source FILE.c]

The C is translated from the sources that numba compiles (edges/c_code/translation.py), so it is
the same step, and both must give the same numbers. They run the same steps of a bag in turn. The
C compiler's options are fixed: -O3 -march=native -fno-math-errno.
"""

import argparse
import sys
from pathlib import Path
from time import thread_time

import numpy as np
from peg_on_hole_ros.study.step_loop import run_steps

from kernel_step import ROOT, SAMPLE, Bench
from peg_on_hole_ros.configuration import from_parameters
from peg_on_hole_ros.edges.c_code import limit as c_limit
from peg_on_hole_ros.edges.config_file import read_parameters

LARGEST_RATIO = 2.5
# Other orders of rounding over a bag's steps, through corrections that amplify it.
LARGEST_DIFFERENCE = 1e-8


class Race:
    """The steps of a bag for both, from the same start."""

    def __init__(self, configuration, bag: Path):
        self.bench = Bench(configuration, bag)
        wrenches, angles, covariances = (
            np.ascontiguousarray(a).ravel() for a in self.bench._arrays
        )
        kalman, options = self.bench.kalman, configuration.filter
        self.count = len(self.bench.steps)
        self.memory = kalman._memory
        self._arguments = (
            kalman._memory, kalman._dy, kalman._slopes, self.bench.dt, self.count,
            wrenches, angles, covariances, options.acceleration_stddev,
            options.free_rate_noise,
        )  # fmt: skip

    def run(self, function) -> float:
        """Return microseconds a step."""
        self.bench._restore()
        begun = thread_time()
        function(*self._arguments)
        return 1e6 * (thread_time() - begun) / self.count

    def difference(self, function) -> float:
        """Return the largest difference to the kernel in the memory after all steps, relative."""
        self.run(run_steps)
        kept = self.memory.copy()
        self.run(function)
        # Entries that cancel to nothing are compared with the typical size of their kind.
        scale = np.maximum(np.abs(kept), 1e-9)
        unset = np.isnan(kept) & np.isnan(self.memory)
        return float(np.where(unset, 0.0, np.abs(self.memory - kept) / scale).max())


def main(arguments=None) -> int:
    """Measure and print; 1 where the kernel is too far from the limit, or the two differ."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--bag", type=Path, default=ROOT / "bags" / f"{SAMPLE}.mcap")
    parser.add_argument("--config", type=Path, default=ROOT / "config" / f"{SAMPLE}.yaml")
    parser.add_argument("--repetitions", type=int, default=15)
    parser.add_argument("--source", type=Path, help="write the C source here")
    options = parser.parse_args(arguments)
    if options.source:
        options.source.write_text(c_limit.source(), encoding="utf-8")
    limit, text = c_limit.build()
    if limit is None:
        print(f"skipped: {text}")
        return 0
    race = Race(from_parameters(read_parameters(options.config)), options.bag)
    difference = race.difference(limit)
    print(f"{text}; largest relative difference of the results {difference:.1e}")
    # In turn, so that a busy machine slows both alike.
    pairs = np.array([(race.run(run_steps), race.run(limit)) for _ in range(options.repetitions)])
    ratio = float(np.median(pairs[:, 0] / pairs[:, 1]))
    for name, column in zip(("kernel", "C"), pairs.T):
        print(f"{name:8s} median {np.median(column):6.2f} us  least {column.min():6.2f} us")
    least = float(np.divide(*pairs.min(axis=0)))
    print(f"kernel over C: {ratio:.2f} (median of pairs), {least:.2f} (least)")
    return int(ratio > LARGEST_RATIO or not difference < LARGEST_DIFFERENCE)


if __name__ == "__main__":
    sys.exit(main())
