"""
How often the 95 % intervals of `calibrate` hold the truth, over drawn cells and starts.

    python -m benchmarks.calibration_intervals [--runs 50] [--seed 1]

Each run draws what a cell is (bias, delay, noise) and a start that is off it in all that is
searched for, simulates a recording of one of three motions, and calibrates: ten seconds each.
"""

import argparse
from dataclasses import replace

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.identification.calibration import calibrate
from peg_on_hole_ros.identification.quantities import (
    BIAS,
    CLEARANCE,
    DELAY,
    FRICTION,
    NOISE,
    QUANTITIES,
    TILT,
    configured,
    coordinates,
    natural,
)
from peg_on_hole_ros.identification.recording import recording
from peg_on_hole_ros.measurements.orientation import PegJoints
from peg_on_hole_ros.records import WrenchSample
from peg_on_hole_ros.sim.measure import measure
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.truth import integrate

# Rates at the ends of the legs [rad/s], and how long each lasts [s].
MOTIONS = {
    "turns both ways": ([(-0.25, 0.6, 1.2), (0.02, -0.6, -1.2), (-0.1, 0.4, -1.0)], 0.5),
    "one way": ([(-0.12, 0.1, 2.0), (-0.12, 0.1, 2.0)], 0.5),
    "leans round": ([(-0.1, 1.5, 1.0), (-0.05, 1.5, -2.0), (-0.1, 1.5, -1.0)], 0.4),
}


def truth_of(name):
    """Return the motion of a name, integrated."""
    legs, duration = MOTIONS[name]
    phases = {
        f"leg{i}": {"kind": "contact", "duration": duration, "rates": list(rates)}
        for i, rates in enumerate(legs)
    }
    tree = {
        "lead_in": 0.1,
        "start": {
            "angles": [0.3, 0.6, 0.4],
            "rates": [0.0, 0.0, 1.0],
            "offset": [-0.0005, 0.0, -0.0015],
        },
        "phases": phases,
    }
    return integrate(plan_from_tree(Configuration(), tree))


def drawn(truth, seed):
    """Return a recording, the start, and the truth in the start's coordinates, by a seed."""
    random = np.random.default_rng(seed)
    cell = truth.plan.configuration
    x = coordinates(cell)
    x[BIAS] = random.normal(size=6) * [1.0, 1.0, 1.0, 0.05, 0.05, 0.05]
    x[DELAY] = random.uniform(0.0, 0.005)
    x[NOISE] += random.uniform(-0.5, 0.5, 3)
    cell = configured(cell, x)
    off = np.zeros(len(x))
    off[FRICTION] = random.uniform(-0.1, 0.1)
    off[BIAS], off[DELAY] = -x[BIAS], -x[DELAY]
    off[TILT] = 0.005 * random.normal(size=2)
    off[CLEARANCE] = 0.1 * random.normal()
    off[NOISE] = random.uniform(-0.3, 0.3, 3)
    start = configured(cell, x + off)
    true = x.copy()
    true[TILT] = -off[TILT]
    truth = replace(truth, plan=replace(truth.plan, configuration=cell, seed=seed))
    wrenches, angles, read = [], [], PegJoints(start.joints)
    for sample in measure(truth):
        if isinstance(sample, WrenchSample):
            wrenches.append(sample)
        else:
            angles.append(read(sample))
    return recording(wrenches, angles), start, true


def main():
    """Print of each quantity how many intervals hold the truth, and how wide they are."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    truths = [truth_of(name) for name in MOTIONS]
    held, seen, off, failed = [], [], [], 0
    for run in range(asked.runs):
        record, start, true = drawn(truths[run % len(truths)], asked.seed + run)
        try:
            found = calibrate(record, start)
        except PegOnHoleError as error:
            failed += 1
            print(f"run {run}: {error}", flush=True)
            continue
        at = [natural(quantity, x) for quantity, x in zip(QUANTITIES, true)]
        held.append([e.low <= t <= e.high for e, t in zip(found.estimates, at)])
        seen.append([one.seen for one in found.estimates])
        half = [max(e.high - e.best, 1e-12) / 1.96 for e in found.estimates]
        off.append([(e.best - t) / h for e, t, h in zip(found.estimates, at, half)])
        missed = [e.name for e, ok in zip(found.estimates, held[-1]) if not ok]
        print(f"run {run}: NIS {found.nis:.2f}, missed {missed}", flush=True)
    held, seen, off = np.array(held), np.array(seen), np.array(off)
    for i, quantity in enumerate(QUANTITIES):
        print(
            f"{quantity.name}: held {held[:, i].mean():.0%} of {len(held)}, seen "
            f"{seen[:, i].mean():.0%}, rms of the error over the stated deviation "
            f"{np.sqrt((off[:, i] ** 2).mean()):.2f}"
        )
    print(f"all: held {held.mean():.1%} of {held.size}; failed {failed}")


if __name__ == "__main__":
    main()
