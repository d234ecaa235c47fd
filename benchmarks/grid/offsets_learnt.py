"""
Bias and tilt that are learnt: how far off they are, and whether reactions keep to their bounds.

`drawn`: bias, tilt and the stated friction are drawn from what is stated, anew for each seed. Of
each motion and statement the normalised error squared at the end, mean over the seeds, of all that
is learnt, and that of the draws; the mean error of friction in its stated deviations; which share
of the reactions that are determined lies within 95 % bounds from 50 ms on, of K, B1 and B2 the
least, and the root mean square of their errors. `one`: 2 N untared across the peg, and a hole that
leans by 0.2 degrees. Motions of the grid at 0.16 rad/s, nominal noise.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.grid import cells, misstated
from benchmarks.grid.cells import Motion, truth_of, with_noise
from benchmarks.grid.misstated import tilted
from benchmarks.harness.errors import SETTLE_NS, coverage
from benchmarks.harness.exact import exactly
from benchmarks.harness.family import Family, Member, Report
from benchmarks.harness.player import record_of
from benchmarks.harness.tables import percent, table
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.estimator.state import FRICTION
from peg_on_hole_ros.measurements.rotations import tilt_axes
from peg_on_hole_ros.sim.measure import START_NS, measure, sensor_wrench

# None that a setting of the filter was chosen on.
FIRST_SEED = 5300
MOTIONS = [
    *(Motion(c, 0.2, 0.16, "slip") for c in (1e-4, 5e-4)),
    Motion(1e-4, 0.5, 0.16, "slip"),
    *(Motion(c, 0.2, 0.16, "reversals") for c in (1e-4, 5e-4)),
    *(Motion(c, 0.2, 0.16, "align") for c in (1e-4, 5e-4)),
]


class Stated(NamedTuple):
    """Standard deviations: force bias [N], torque bias [N m], tilt [rad], friction."""

    force: float
    torque: float
    tilt: float
    friction: float

    def __str__(self):
        """Return them as text."""
        parts = []
        if self.force:
            parts.append(f"{self.force:g} N, {self.torque:g} N m")
        if self.tilt:
            parts.append(f"{1e3 * self.tilt:g} mrad")
        parts.append(f"friction {self.friction:g}" if self.friction else "friction known")
        return ", ".join(parts)


DRAWN = [
    Stated(0.1, 0.002, 0.0, 0.05),
    Stated(0.5, 0.01, 3.5e-3, 0.05),
    Stated(0.5, 0.01, 0.0, 0.05),
    Stated(2.0, 0.02, 0.0, 0.05),
    Stated(2.0, 0.02, 0.0, 0.0),
    Stated(0.0, 0.0, 3.5e-3, 0.05),
]
# Stated, true bias and tilt by name.
ONE = {
    "2 N untared, 3 N stated": (Stated(3.0, 0.0, 0.0, 0.05), (2.0, 0, 0, 0, 0, 0), (0.0, 0.0)),
    "0.2 degrees, 5 mrad stated": (
        Stated(0.0, 0.0, 5e-3, 0.05), (0.0,) * 6, (0.0, float(np.radians(0.2))),
    ),
}  # fmt: skip


def uncertain(configuration, stated: Stated, **scene):
    """Return a configuration that states so much, and scene values."""
    return replace(
        configuration,
        wrench=replace(
            configuration.wrench,
            bias_force_stddev=stated.force,
            bias_torque_stddev=stated.torque,
        ),
        joints=replace(configuration.joints, hole_tilt_stddev=stated.tilt),
        scene=replace(configuration.scene, friction_stddev=stated.friction, **scene),
    )


def pipeline_of(configuration, tilt=(0.0, 0.0)):
    """Return the pipeline of a level cell whose hole leans by a tilt [rad]."""
    gravity = tuple((tilt_axes(tilt) @ configuration.scene.gravity).tolist())
    scene = replace(configuration.scene, gravity=gravity)
    return Pipeline(exactly(replace(configuration, scene=scene)))


def _normalised(kalman, bias, tilt, friction):
    """Return the normalised error squared of friction and offsets, of what is not known."""
    mixture, rows, true = kalman.mixture, [FRICTION], [friction]
    for first, values in ((kalman.places.bias, bias), (kalman.places.tilt, tilt)):
        if first >= 0:
            rows += range(first, first + len(values))
            true += list(values)
    off, P = mixture.mean[rows] - true, mixture.covariance[np.ix_(rows, rows)]
    unknown = np.diagonal(P) > 0.0
    return float(off[unknown] @ np.linalg.solve(P[np.ix_(unknown, unknown)], off[unknown]))


def run(truth, configuration, seed, bias, tilt, exact):
    """Return normalised error squared, friction's in deviations, shares within bounds, RMS [N]."""
    friction = truth.plan.configuration.scene.friction
    pipeline = pipeline_of(configuration, tilt)
    samples = (tilted(sample, tilt) for sample in measure(truth, seed, exact=exact + bias))
    record = record_of(pipeline, samples)
    rows = np.searchsorted(truth.t_ns, record.t_ns - START_NS)
    chosen = (truth.t_ns[rows] >= SETTLE_NS) & record.determined
    off = (record.normal - truth.normal[rows])[chosen]
    stddev = record.monitor["friction_stddev"][-1]
    deviations = (record.monitor["friction"][-1] - friction) / stddev if stddev else 0.0
    normalised = _normalised(pipeline.filter, bias, tilt, friction)
    shares = coverage(off, record.normal_stddev[chosen]).covered
    root = np.sqrt(np.mean(np.square(off))) if len(off) else np.nan
    return normalised, float(deviations), *shares.tolist(), float(root)


def drawn(truth, stated: Stated, seeds):
    """Return a row for each seed: `run`, and the normalised square of what was drawn."""
    right, exact, rows = truth.plan.configuration, sensor_wrench(truth), []
    for seed in seeds:
        random = np.random.default_rng(seed)
        z = random.normal(size=9)
        bias = z[:6] * np.repeat([stated.force, stated.torque], 3)
        tilt = tuple((z[6:8] * stated.tilt).tolist())
        friction = max(right.scene.friction + stated.friction * z[8], 0.01)
        used = np.repeat([stated.force > 0, stated.tilt > 0, stated.friction > 0], [6, 2, 1])
        told = uncertain(right, stated, friction=friction)
        rows.append((*run(truth, told, seed, bias, tilt, exact), float(z[used] @ z[used])))
    return rows


def one(truth, stated: Stated, bias, tilt, seeds):
    """Return a row for each seed of one error that is always the same."""
    told, exact = uncertain(truth.plan.configuration, stated), sensor_wrench(truth)
    return [(*run(truth, told, seed, np.array(bias), tilt, exact), np.nan) for seed in seeds]


STATED = {"drawn": {str(stated): stated for stated in DRAWN}, "one": ONE}


@cache
def _truth(motion):
    return with_noise(truth_of(motion)[0], "nominal", 0.05)


def score_member(case: Member, folder: Path) -> list:
    """Return a row for each seed."""
    seeds = range(FIRST_SEED, FIRST_SEED + case.seeds)
    part, motion, name = case.of
    stated = STATED[part][name]
    if part == "drawn":
        return drawn(_truth(motion), stated, seeds)
    return one(_truth(motion), *stated, seeds)


def members(options) -> list[Member]:
    """Return what is stated of each motion."""
    return [
        Member(f"{part}: {motion}, {name}", (part, motion, name), options.seeds)
        for part in STATED
        for motion in MOTIONS
        for name in STATED[part]
    ]


def cell(rows):
    """Return the figures of all seeds as text."""
    rows = np.array(rows, float)
    normalised, deviations, draws = rows[:, 0].mean(), rows[:, 1].mean(), rows[:, 6].mean()
    share = np.nanmean(rows[:, 2:5], axis=0).min()
    of_draws = "" if np.isnan(draws) else f" ({draws:.1f})"
    root = np.sqrt(np.nanmean(rows[:, 5] ** 2))
    return f"{normalised:.1f}{of_draws}; {deviations:+.1f}; {percent(share)}, {root:.2g} N"


def report(found, options) -> Report:
    """Return a table of each part: motions, and what is stated."""
    of: dict[str, dict] = {}
    for case, figures in found:
        part, motion, name = case.of
        of.setdefault(part, {}).setdefault(str(motion), {})[name] = cell(figures)
    tables = []
    for part, rows in of.items():
        heads = list(STATED[part])
        lines = [(name, *(row.get(head, "") for head in heads)) for name, row in rows.items()]
        tables.append(table((part, *heads), lines))
    return Report("\n\n".join(tables))


FAMILY = Family(
    members, score_member, report, seeds=24,
    group=lambda case: case.of[1],
    sources=(cells, misstated),
)  # fmt: skip
