"""
How often the 95 % intervals of `calibrate` hold the truth, over drawn cells and starts.

Each run draws what a cell is (bias, delay, noise) and a start that is off it in all that is
searched for, simulates a recording of one of three motions, and calibrates: ten seconds each.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.harness.errors import INTERVAL
from benchmarks.harness.family import ESTIMATE, Family, Member, Report
from benchmarks.harness.tables import percent, table
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.identification.calibration import calibrate
from peg_on_hole_ros.identification.quantities import (
    BIAS_AT,
    CALIBRATED_QUANTITIES,
    CLEARANCE_AT,
    DELAY_AT,
    FRICTION_AT,
    NOISE_AT,
    TILT_AT,
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


@cache
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
    x[BIAS_AT] = random.normal(size=6) * [1.0, 1.0, 1.0, 0.05, 0.05, 0.05]
    x[DELAY_AT] = random.uniform(0.0, 0.005)
    x[NOISE_AT] += random.uniform(-0.5, 0.5, 3)
    cell = configured(cell, x)
    off = np.zeros(len(x))
    off[FRICTION_AT] = random.uniform(-0.1, 0.1)
    off[BIAS_AT], off[DELAY_AT] = -x[BIAS_AT], -x[DELAY_AT]
    off[TILT_AT] = 0.005 * random.normal(size=2)
    off[CLEARANCE_AT] = 0.1 * random.normal()
    off[NOISE_AT] = random.uniform(-0.3, 0.3, 3)
    start = configured(cell, x + off)
    true = x.copy()
    true[TILT_AT] = -off[TILT_AT]
    truth = replace(truth, plan=replace(truth.plan, configuration=cell, seed=seed))
    wrenches, angles, read = [], [], PegJoints(start.joints)
    for sample in measure(truth):
        if isinstance(sample, WrenchSample):
            wrenches.append(sample)
        else:
            angles.append(read(sample))
    return recording(wrenches, angles), start, true


def score_member(run: Member, folder: Path) -> dict:
    """Return of each quantity whether its interval holds the truth, or why there is none."""
    seed, motion = run.of
    record, start, true = drawn(truth_of(motion), seed)
    try:
        found = calibrate(record, start)
    except PegOnHoleError as error:
        return {"failed": str(error)}
    at = [natural(quantity, x) for quantity, x in zip(CALIBRATED_QUANTITIES, true)]
    half = [max(e.high - e.best, 1e-12) / INTERVAL for e in found.estimates]
    return {
        "nis": float(found.nis),
        "held": [bool(e.low <= t <= e.high) for e, t in zip(found.estimates, at)],
        "seen": [bool(one.seen) for one in found.estimates],
        "off": [float((e.best - t) / h) for e, t, h in zip(found.estimates, at, half)],
    }


def members(options) -> list[Member]:
    """Return the runs asked for, motions in turn."""
    names = list(MOTIONS)
    drawn_by = [(options.seed + k, names[k % len(names)]) for k in range(options.runs)]
    return [Member(f"{seed:03d}_{motion}", (seed, motion)) for seed, motion in drawn_by]


FIGURES = ("held", "seen", "off")


def report(found, options) -> Report:
    """Return how many intervals of each quantity hold the truth, and how wide they are."""
    done = [tree for _, tree in found if "held" in tree]
    rows = []
    for i, quantity in enumerate(CALIBRATED_QUANTITIES):
        held, seen, off = np.array([[tree[k][i] for tree in done] for k in FIGURES])
        rms = np.sqrt((off**2).mean())
        rows.append((quantity.name, percent(held.mean()), percent(seen.mean()), f"{rms:.2f}"))
    head = "quantity", "intervals that hold it", "seen", "RMS error over stated deviation"
    held = np.array([tree["held"] for tree in done])
    lines = [f"all: held {held.mean():.1%} of {held.size}; failed {len(found) - len(done)}"]
    for run, tree in found:
        if "failed" in tree:
            lines.append(f"run {run}: {tree['failed']}")
            continue
        missed = [q.name for q, ok in zip(CALIBRATED_QUANTITIES, tree["held"]) if not ok]
        lines.append(f"run {run}: NIS {tree['nis']:.2f}, missed {', '.join(missed) or 'none'}")
    return Report(f"{table(head, rows)}\n\n" + "\n".join(lines))


def add_options(parser) -> None:
    """Add how many runs, and from which seed on."""
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)


FAMILY = Family(members, score_member, report, add_options, parts=(*ESTIMATE, "identification"))
