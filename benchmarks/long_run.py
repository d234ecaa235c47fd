"""
Whether the covariance stays symmetric positive definite over many steps without a restart.

    python benchmarks/long_run.py [--bag BAG --config CONFIG] [--steps 10000000]

The steps of a bag are run over and over in compiled code. At each turn, and where the filter would
begin anew, the state is put back; the covariance never is. Printed are the smallest pivot of the
joint correlation matrix (14: state, wrench, friction, peg diameter) that was met, the largest
difference across its diagonal, and what the steps came to.
"""

import argparse
import sys
from functools import partial
from math import fabs, inf, sqrt
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import numpy as np
from peg_on_hole_ros.estimation.kernel import correction
from peg_on_hole_ros.estimation.kernel.cycle import (
    follow_innovation,
    follow_motion,
    predict_or_bridge,
)
from peg_on_hole_ros.estimation.kernel.held_wrench import hold_wrench
from peg_on_hole_ros.estimation.kernel.memory import CROSS, INTERVAL, SPREAD, R, X, Z
from peg_on_hole_ros.estimation.steps.implicit_euler import CONVERGED

from peg_on_hole_ros.configuration import from_parameters
from peg_on_hole_ros.edges.config_file import read_parameters
from peg_on_hole_ros.mechanics.kernel import compiled
from side_by_side import bag_steps, filters

ROOT = Path(__file__).parents[1]
SAMPLE = "working_cycle"
CHECK_EVERY = 50


class Found(NamedTuple):
    """What a run met; pivot and asymmetry are of the joint correlation matrix."""

    pivot: float
    asymmetry: float
    not_finite: int
    contact: int
    restarts: int
    seconds: float


@compiled
def _check(m, C):
    """Return the smallest pivot of the joint correlation matrix, and its asymmetry."""
    for i in range(12):
        for j in range(12):
            C[i, j] = m[Z + 12 * i + j]
        for k in range(2):
            C[i, 12 + k] = C[12 + k, i] = m[CROSS + 12 * k + i]
    for k in range(2):
        for n in range(2):
            C[12 + k, 12 + n] = m[SPREAD + 2 * k + n]
    asymmetry, least = 0.0, inf
    for i in range(14):
        for j in range(i):
            if C[i, j] != C[j, i]:
                asymmetry = max(asymmetry, fabs(C[i, j] - C[j, i]) / sqrt(C[i, i] * C[j, j]))
    for i in range(14):
        if C[i, i] == 0.0 and i >= 12:
            continue  # a parameter that is known
        variance = C[i, i]
        for j in range(i + 1):
            total = C[i, j]
            for k in range(j):
                total -= C[i, k] * C[j, k]
            if i != j:
                C[i, j] = total / C[j, j] if C[j, j] > 0.0 else 0.0
            else:
                if not total > 0.0:
                    return -1.0, asymmetry
                least = min(least, total / variance)
                C[i, i] = sqrt(total)
    return least, asymmetry


@compiled
def _run(m, dy, slopes, dt, wrenches, angles, covariances, noises, thresholds, steps, C):
    pivot, asymmetry = inf, 0.0
    not_finite = contact = restarts = 0
    n = len(wrenches)
    for step in range(steps):
        k = step % n
        if k == 0:
            for i in range(3):
                m[X + i], m[X + 3 + i] = angles[0, i], 0.0
        hold_wrench(m, wrenches[k])
        status, _ = predict_or_bridge(m, dy, slopes, dt, noises[1], noises[0])
        if status == CONVERGED:
            contact += 1
        for i in range(9):
            m[R + i] = covariances[k, i]
        nis = correction.innovation(m, angles[k])
        follow_innovation(m, nis, dt)
        if not nis < inf:
            not_finite += 1
            nis = inf
        elif nis > thresholds[0]:
            correction.widen_rates(m, dt, nis / 3.0 - 1.0)
            nis = correction.innovation(m, angles[k])
        if nis <= thresholds[1]:
            m[INTERVAL] = dt
            correction.correct(m)
            follow_motion(m, dt)
        else:
            restarts += 1
            for i in range(3):
                m[X + i], m[X + 3 + i] = angles[k, i], 0.0
        if step % CHECK_EVERY == 0:
            least, across = _check(m, C)
            pivot, asymmetry = min(pivot, least), max(asymmetry, across)
    return pivot, asymmetry, not_finite, contact, restarts


def long_run(configuration, bag: Path, steps: int) -> Found:
    """Run so many steps; the bag's joint states carry the stamps of wrenches."""
    chosen = [step for step in bag_steps(bag, configuration) if step.q is not None]
    kalman, _ = filters(configuration, chosen[0])
    options = configuration.filter
    run = partial(
        _run, kalman._memory, kalman._dy, kalman._slopes, 2 * chosen[1].dt,
        np.array([step.u for step in chosen]),
        np.array([step.q for step in chosen]),
        np.array([step.R.ravel() for step in chosen]),
        np.array([options.free_rate_noise, options.acceleration_stddev]),
        np.array([options.inflation_threshold, options.gate_threshold]),
    )  # fmt: skip
    # Compiled before the clock runs.
    run(1, np.zeros((14, 14)))
    begun = perf_counter()
    found = run(steps, np.zeros((14, 14)))
    return Found(*found, perf_counter() - begun)


def main(arguments=None) -> int:
    """Run and print; 1 if the covariance was lost."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--bag", type=Path, default=ROOT / "bags" / f"{SAMPLE}.mcap")
    parser.add_argument("--config", type=Path, default=ROOT / "config" / f"{SAMPLE}.yaml")
    parser.add_argument("--steps", type=int, default=10_000_000)
    options = parser.parse_args(arguments)
    configuration = from_parameters(read_parameters(options.config))
    found = long_run(configuration, options.bag, options.steps)
    print(
        f"{options.bag.name}: {options.steps} steps in {found.seconds:.0f} s; smallest pivot "
        f"{found.pivot:.2g}, asymmetry {found.asymmetry:.2g}, not finite {found.not_finite}, "
        f"contact {found.contact / options.steps:.1%}, put back {found.restarts} times"
    )
    return int(found.pivot <= 0 or found.not_finite > 0)


if __name__ == "__main__":
    sys.exit(main())
