"""
Whether the covariance stays symmetric positive definite over many steps without a restart.

    python -m benchmarks.cost.long_run [--bag BAG --config CONFIG] [--steps 1000000]

The steps of a bag are run over and over. At each turn the means are put back to where the bag
begins; covariances and weights never are. Printed are the smallest pivot of a component's
correlation matrix that was met, the largest difference across its diagonal, and how many checks
found a number that is not finite.
"""

import argparse
import sys
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import numpy as np

from benchmarks.bag_steps import bag_steps
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.parameters_file import read_parameters
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.methods.registry import make_filter
from peg_on_hole_ros.estimator.state import FRICTION
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction

ROOT = Path(__file__).parents[2]
SAMPLE = "closing_with_slip"
CHECK_EVERY = 100


class Found(NamedTuple):
    """Smallest pivot, asymmetry, checks with what is not finite, seconds."""

    pivot: float
    asymmetry: float
    not_finite: int
    seconds: float


def check(covariances) -> tuple[float, float]:
    """
    Return the smallest pivot of the correlation matrices, and the largest asymmetry.

    A matrix that is not positive definite has the pivot -1.

    Parameters
    ----------
    covariances : ndarray, shape (m, w, w)

    """
    pivot, asymmetry = np.inf, 0.0
    for P in covariances:
        scale = np.sqrt(np.maximum(np.diagonal(P), 1e-300))
        correlation = P / np.outer(scale, scale)
        asymmetry = max(asymmetry, float(np.abs(correlation - correlation.T).max()))
        try:
            pivot = min(pivot, float(np.diagonal(np.linalg.cholesky(correlation)).min()) ** 2)
        except np.linalg.LinAlgError:
            pivot = -1.0
    return pivot, asymmetry


def long_run(configuration, bag: Path, steps: int) -> Found:
    """Run so many steps; the bag's joint states carry the stamps of wrenches."""
    taken = bag_steps(bag, configuration)
    first = next(k for k, each in enumerate(taken) if each.q is not None)
    reduction = WrenchReduction(configuration.wrench, configuration.scene)
    offsets = reduction.offsets(configuration)
    kalman = make_filter(configuration.scene, configuration.filter, reduction.covariance, offsets)
    begin, rest = taken[first], taken[first + 1 :]
    kalman.start(begin.q, begin.R)
    s = kalman.mixture
    means = s.x[:, :FRICTION].copy()
    pivot, asymmetry, not_finite, begun = np.inf, 0.0, 0, perf_counter()
    for count in range(steps):
        each = rest[count % len(rest)]
        if count and count % len(rest) == 0:
            s.x[:, :FRICTION] = means
        kalman.predict(each.dt)
        if each.q is not None:
            # A refused orientation would begin the filter anew.
            kalman.fields.refused = 0
            kalman.correct(each.q, each.R)
        kalman.weigh(each.u, ContactSet.THREE)
        if count % CHECK_EVERY == 0:
            alive = s.P[s.weight > 0.0]
            if not np.isfinite(alive).all():
                not_finite += 1
                continue
            least, across = check(alive)
            pivot, asymmetry = min(pivot, least), max(asymmetry, across)
    return Found(pivot, asymmetry, not_finite, perf_counter() - begun)


def main(arguments=None) -> int:
    """Run and print; 1 if the covariance was lost."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--bag", type=Path, default=ROOT / "bags" / f"{SAMPLE}.mcap")
    parser.add_argument("--config", type=Path, default=ROOT / "config" / f"{SAMPLE}.yaml")
    parser.add_argument("--steps", type=int, default=1_000_000)
    options = parser.parse_args(arguments)
    configuration = from_parameters(read_parameters(options.config))
    found = long_run(configuration, options.bag, options.steps)
    print(
        f"{options.bag.name}: {options.steps} steps in {found.seconds:.0f} s; smallest pivot "
        f"{found.pivot:.2g}, asymmetry {found.asymmetry:.2g}, not finite {found.not_finite} times"
    )
    return int(found.pivot <= 0 or found.not_finite > 0)


if __name__ == "__main__":
    sys.exit(main())
