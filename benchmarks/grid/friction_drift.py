"""
Friction that drifts while the peg slides, though it is taken for one that hardly wanders.

    python -m benchmarks.grid.friction_drift [--seeds 8]

Motions of the grid whose friction begins at 0.2 and goes up steadily, in steps of 20 ms. Of each
drift and noise, over all samples after 0.2 s: which share of the frictions lies within 95 %
bounds, the root mean square of their errors and of what is stated; which share of the reactions
does, of K, B1 and B2 the least. A run that was stopped goes on.
"""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.grid.cells import (
    ENOUGH,
    NOISE,
    PRESSES,
    Motion,
    first_samples,
    plan_of,
    touching,
    with_noise,
)
from benchmarks.grid.score import INTERVAL, drawn
from benchmarks.resumable import ESTIMATE, figures_of, keep, parsed, sources_key
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.sim.measure import START_NS, measure, sensor_wrench
from peg_on_hole_ros.sim.truth import integrate

# None that the grid has.
FIRST_SEED = 60000
SOURCES = ("friction_drift.py", "cells.py", "score.py")
MOTIONS = {
    "slip": Motion(1e-4, 0.2, 0.16, "slip"),
    "slow_slip": Motion(1e-4, 0.2, 0.01, "slip"),
    "align": Motion(5e-4, 0.2, 0.16, "align"),
}
DRIFTS = (0.0, 0.002, 0.02)  # [1/s]
STEP = 0.02  # [s]
LEARNT = 0.05
SETTLED_NS = 200_000_000


def drifting(motion, drift):
    """
    Return the truth of a motion whose friction drifts [1/s], and friction at each sample.

    Raises
    ------
    RuntimeError
        No press keeps three contacts.

    """
    for press in PRESSES:
        plan, duration = plan_of(motion, press)
        phases = [plan.phases[0]]
        for before, leg in pairwise(plan.phases):
            count = round(leg.duration / STEP)
            for i in range(count):
                share = (i + 1) / count
                rates = tuple((1 - share) * a + share * b for a, b in zip(before.rates, leg.rates))
                friction = motion.friction + drift * STEP * (len(phases) - 0.5)
                phases.append(
                    replace(
                        leg, name=f"{leg.name}_{i}", duration=STEP, rates=rates, friction=friction
                    )
                )
        truth = integrate(replace(plan, phases=tuple(phases)))
        count = touching(truth)
        if count >= ENOUGH * duration * plan.wrench_rate:
            truth = first_samples(truth, count)
            at = (truth.t_ns * 1e-9 // STEP + 0.5) * STEP
            return truth, motion.friction + drift * at
    raise RuntimeError(f"{motion}: no three-point contact with a drift of {drift:g}/s")


def followed(truth, friction, seeds):
    """Return the figures of one drift at one noise level."""
    exact, errors, stated = sensor_wrench(truth), [], []
    row_of = {int(t): k for k, t in enumerate(truth.t_ns)}
    for seed in seeds:
        pipeline = Pipeline(drawn(truth.plan.configuration, seed))
        for outputs in pipeline.play(measure(truth, seed, exact=exact)):
            k = row_of[outputs.t_ns - START_NS]
            if truth.t_ns[k] < SETTLED_NS:
                continue
            values = np.r_[outputs.monitor["friction"], outputs.normal]
            errors.append(values - np.r_[friction[k], truth.normal[k]])
            stated.append(np.r_[outputs.monitor["friction_stddev"], outputs.normal_stddev])
    errors, stated = np.array(errors), np.array(stated)
    covered = (np.abs(errors) <= INTERVAL * stated).mean(axis=0)
    return {
        "friction": float(covered[0]),
        "error": float(np.sqrt((errors[:, 0] ** 2).mean())),
        "stated": float(np.sqrt((stated[:, 0] ** 2).mean())),
        "reactions": float(covered[1:].min()),
    }


def compute(task):
    """Keep the figures of one motion and drift at all noise levels; returns (name, "done")."""
    name, drift, seeds, path, asked = task
    truth, friction = drifting(MOTIONS[name], drift)
    seeds = range(FIRST_SEED, FIRST_SEED + seeds)
    figures = {
        noise: followed(with_noise(truth, noise, LEARNT), friction, seeds) for noise in NOISE
    }
    keep(path, asked | {"figures": figures})
    return f"{name}, {drift:g}/s", "done"


def main(arguments=None):
    """Compute the motions asked for, print them as a table, keep the figures."""
    options = parsed(__doc__, MOTIONS, 8, Path("out/friction_drift"), arguments)
    key = sources_key(ESTIMATE, [Path(__file__).with_name(name) for name in SOURCES])
    asked = {"key": key, "seeds": options.seeds}
    tasks = [
        (name, drift, options.seeds, options.folder / f"{name}_{drift:g}.json", asked)
        for name in options.part
        for drift in DRIFTS
    ]
    found = figures_of(compute, tasks, options.workers)
    print("\n| motion | drift [1/s] |", " | ".join(NOISE), "|")
    print("|---" * (2 + len(NOISE)) + "|")
    for (name, drift, *_), row in zip(tasks, found, strict=True):
        cells = [
            f"{100 * one['friction']:.0f} % ({1e3 * one['error']:.2g} of {1e3 * one['stated']:.2g}"
            f"e-3); {100 * one['reactions']:.0f} %"
            for one in (row[noise] for noise in NOISE)
        ]
        print(f"| {MOTIONS[name]} | {drift:g} |", " | ".join(cells), "|")


if __name__ == "__main__":
    main()
