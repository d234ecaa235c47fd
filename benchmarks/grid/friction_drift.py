"""
Friction that drifts while the peg slides, though it is taken for one that hardly wanders.

Motions of the grid whose friction begins at 0.2 and goes up steadily, in steps of 20 ms. Of each
drift and noise, over all samples after 0.2 s: which share of the frictions lies within 95 %
bounds, the root mean square of their errors and of what is stated; which share of the reactions
does, of K, B1 and B2 the least.
"""

from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.grid import cells
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
from benchmarks.harness.errors import coverage, drawn
from benchmarks.harness.exact import exactly
from benchmarks.harness.family import Family, Member, Report
from benchmarks.harness.player import record_of
from benchmarks.harness.tables import percent, table
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.sim.measure import START_NS, measure, sensor_wrench
from peg_on_hole_ros.sim.truth import integrate

# None that the grid has.
FIRST_SEED = 60000
MOTIONS = {
    "slip": Motion(1e-4, 0.2, 0.16, "slip"),
    "slow_slip": Motion(1e-4, 0.2, 0.01, "slip"),
    "align": Motion(5e-4, 0.2, 0.16, "align"),
}
DRIFTS = (0.0, 0.002, 0.02)  # [1/s]
STEP = 0.02  # [s]
LEARNT = 0.05
SETTLED_NS = 200_000_000


@cache
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


def score_member(member: Member, folder: Path) -> dict:
    """Return the figures of one drift at one noise level."""
    name, drift, noise = member.of
    truth, friction = drifting(MOTIONS[name], drift)
    truth = with_noise(truth, noise, LEARNT)
    exact, errors, stated = sensor_wrench(truth), [], []
    for seed in range(FIRST_SEED, FIRST_SEED + member.seeds):
        pipeline = Pipeline(drawn(exactly(truth.plan.configuration), seed))
        record = record_of(pipeline, measure(truth, seed, exact=exact))
        rows = np.searchsorted(truth.t_ns, record.t_ns - START_NS)
        values = np.column_stack([record.monitor["friction"], record.normal])
        stddev = np.column_stack([record.monitor["friction_stddev"], record.normal_stddev])
        later = truth.t_ns[rows] >= SETTLED_NS
        errors.append((values - np.column_stack([friction, truth.normal])[rows])[later])
        stated.append(stddev[later])
    found = coverage(np.concatenate(errors), np.concatenate(stated))
    return {
        "friction": float(found.covered[0]),
        "error": float(found.rms[0]),
        "stated": float(found.stated[0]),
        "reactions": float(found.covered[1:].min()),
    }


def members(options) -> list[Member]:
    """Return the motions with each drift at each noise level."""
    return [
        Member(f"{name}, {drift:g}/s, {noise}", (name, drift, noise), options.seeds)
        for name in MOTIONS
        for drift in DRIFTS
        for noise in NOISE
    ]


def report(found, options) -> Report:
    """Return a row for each motion and drift."""
    rows: dict = {}
    for member, one in found:
        of = f"{1e3 * one['error']:.2g} of {1e3 * one['stated']:.2g}e-3"
        cell = f"{percent(one['friction'])} ({of}); {percent(one['reactions'])}"
        name, drift, noise = member.of
        rows.setdefault((str(MOTIONS[name]), f"{drift:g}"), {})[noise] = cell
    lines = [(*key, *(row.get(noise, "") for noise in NOISE)) for key, row in rows.items()]
    return Report(table(("motion", "drift [1/s]", *NOISE), lines))


FAMILY = Family(
    members, score_member, report, seeds=8,
    group=lambda member: member.of[:2], sources=(cells,),
)  # fmt: skip
