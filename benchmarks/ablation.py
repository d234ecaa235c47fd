"""
What each tuned constant of the estimator is worth, by changing its field in the settings.

Cases are motions of the grid's axes and scenes beyond them, with seeds of their own.
Of each case and seed the logarithm of an error over the shipped estimator's is taken, a mean over
the quantities; a row gives the geometric mean over all, and its standard error in per cent. What
lies within two of them is chance.
"""

from collections.abc import Callable
from functools import cache, partial
from math import inf
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.grid import cells, misstated, pegs
from benchmarks.grid.cells import NOISE, Motion, truth_of, with_noise
from benchmarks.grid.misstated import with_values
from benchmarks.grid.pegs import closing
from benchmarks.harness.errors import REACTIONS, SETTLE_NS, STATES, drawn, inside, runs_of
from benchmarks.harness.exact import exactly
from benchmarks.harness.family import Family, Report
from benchmarks.harness.player import record_of
from benchmarks.harness.tables import table
from peg_on_hole_ros.cli.simulation_file import read_plan
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.records import JointSample, WrenchSample
from peg_on_hole_ros.sim.measure import measure
from peg_on_hole_ros.sim.truth import Truth, integrate
from peg_on_hole_ros.study.runs import LEAST_COVERED

ROOT = Path(__file__).parents[1]
FIRST_SEED = 830_000
FRICTION_SPREAD = 0.05
# A spike of force and torque [N], [N m], in one wrench of so many.
SPIKE, SPIKES_EVERY = 200.0, 97
ROUGHER = 4.0

# What is put in a field's place: without its rule where that is possible, else much of it.
SWITCHED = {
    "mode_stddev": (("mode_stddev", (10.0, 30.0, 500.0)), ("mode_stddev", (1.0, 30.0, 500.0))),
    "mode_rate": (("mode_rate", (0.0, 15.0, 3.0)), ("mode_rate", (0.0, 60.0, 12.0))),
    "mode_time": (("mode_time", (0.02, 0.02, 0.02)), ("mode_time", (0.05, 0.05, 0.05))),
    "around_axes": (("around_axes", 0.0), ("around_axes", 1.0)),
    "friction_hypotheses": (("friction_hypotheses", 1), ("friction_hypotheses", 5)),
    "reach": (("reach", 2.0), ("reach", 3.0)),
    "joined": (("joined", 0.0), ("joined", 0.03)),
    "direction_evidence_time": (
        ("direction_evidence_time", 0.0),
        ("direction_evidence_time", 0.5),
    ),
    "direction_time": (("direction_time", 0.0), ("direction_time", 0.03)),
    "reaction_prior": (("reaction_prior", 1.0), ("reaction_prior", 30.0)),
    "settling": (("settling", 0.002), ("settling", 0.05)),
    "passes": (("passes", 1), ("passes", 2)),
    "free_walk": (("free_walk", 0.1), ("free_walk", 1.0)),
    "bias_time": (("bias_time", 12.0), ("bias_time", inf)),
    "touch_time": (("touch_time", 0.0), ("touch_time", 0.3)),
    "significance": (("significance", 1.0), ("significance", inf)),
    "outlier": (("outlier", inf), ("outlier", 5.0)),
    "noise_count": (("noise_count", 30.0), ("noise_count", 300.0)),
    "noise_most": (("noise_most", 1.0),),
    "top_friction_walk": (("top_friction_walk", 0.0), ("top_friction_walk", 2.0)),
    "least_inherited": (("least_inherited", 0.0), ("least_inherited", 0.1)),
    "direction_share": (("direction_share", 0.0),),
    "products": (("products", 0.0),),
    "top_waits": (("top_waits", 0.0),),
}


class Case(NamedTuple):
    """
    A truth, how it is measured, and what becomes of the samples on their way.

    Attributes
    ----------
    name : str
    truth : Callable
        Returns the Truth, with what is stated.
    on_the_way : Callable
        Changes samples, an iterable of them, by a seed.

    """

    name: str
    truth: Callable
    on_the_way: Callable = lambda samples, seed: samples


def of_grid(clearance, friction, speed, name, noise):
    """Return a case of the grid's axes, with an unknown friction."""
    motion = Motion(clearance, friction, speed, name)
    return Case(
        f"{motion} {noise}",
        lambda: with_noise(truth_of(motion)[0], noise, FRICTION_SPREAD),
    )


def sample_scene(name):
    """Return the truth of a shipped scene."""
    return integrate(read_plan(ROOT / "config" / f"{name}.yaml"))


def spiked(samples, seed):
    """Let one wrench of SPIKES_EVERY be a spike."""
    rng = np.random.default_rng([seed, 3])
    for k, sample in enumerate(samples):
        if isinstance(sample, WrenchSample) and k % SPIKES_EVERY == 0:
            off = SPIKE * rng.choice([-1.0, 1.0], 3)
            force = tuple(float(f + o) for f, o in zip(sample.force, off))
            sample = sample._replace(force=force)
        yield sample


def rougher(samples, seed):
    """Let orientations be noisier than stated."""
    rng = np.random.default_rng([seed, 4])
    more = NOISE["nominal"][2] * (ROUGHER**2 - 1.0) ** 0.5
    for sample in samples:
        if isinstance(sample, JointSample):
            gamma, psi, phi = sample.position
            w = more * rng.standard_normal(3)
            # As a rotation of the peg: psi and phi share what turns about a steep axis.
            turned = w[1] / np.sin(max(gamma, 1e-3))
            position = (gamma + w[0], psi + turned, phi - turned * np.cos(gamma) + w[2])
            sample = sample._replace(position=tuple(map(float, position)))
        yield sample


CASES = (
    of_grid(1e-4, 0.2, 0.16, "slip", "nominal"),
    of_grid(2e-5, 0.05, 0.16, "align", "nominal"),
    of_grid(5e-4, 0.5, 0.16, "reversals", "low"),
    of_grid(1e-4, 0.2, 1.0, "reversals", "nominal"),
    of_grid(2e-3, 0.2, 1.0, "align", "high"),
    of_grid(5e-4, 0.2, 0.01, "slip", "high"),
    of_grid(1e-4, 0.5, 0.01, "reversals", "nominal"),
    of_grid(2e-5, 0.2, 1.0, "helix", "low"),
    of_grid(1e-4, 0.05, 0.16, "weave", "high"),
    of_grid(2e-3, 0.5, 0.16, "weave", "nominal"),
    of_grid(5e-4, 0.05, 0.01, "helix", "nominal"),
    Case("working cycle", partial(sample_scene, "working_cycle")),
    Case(
        "working cycle, bias learnt",
        lambda: with_values(
            sample_scene("working_cycle"),
            "wrench",
            bias_force_stddev=2.0,
            bias_torque_stddev=0.05,
        ),
    ),
    Case("closing, without slip", partial(sample_scene, "closing_without_slip")),
    Case("closing with slip, spikes", partial(sample_scene, "closing_with_slip"), spiked),
    Case("closing with slip, rough", partial(sample_scene, "closing_with_slip"), rougher),
    Case("10 mm peg", partial(closing, "10 mm")),
)


class Score(NamedTuple):
    """
    What one run comes to, over the samples of three contacts whose reactions are known.

    Attributes
    ----------
    rms : list of 9 float
        Of the errors of angles, rates, reactions.
    covered : list of 9 float
        Share of the samples within 95 % bounds.
    determined : float
        Share whose reactions are called determined.
    sure : list of 4 int
        How many those are, and of each reaction how many of them are within 95 % bounds.

    """

    rms: list[float]
    covered: list[float]
    determined: float
    sure: list[int]


def score(case: Case, truth: Truth, seed: int, changed: dict) -> Score:
    """Return what a run with changed constants comes to."""
    configuration = drawn(truth.plan.configuration, seed)

    def make(*given):
        return ContactFilter(*given, settings=default_settings(**changed))

    pipeline = Pipeline(exactly(configuration), make=make)
    samples = case.on_the_way(measure(truth, seed), seed)
    runs = runs_of(truth, [record_of(pipeline, samples)])
    told = (truth.mode == "three_point") & truth.known & (truth.t_ns >= SETTLE_NS)
    error, stddev, determined = (
        each[0][told] for each in (runs.error, runs.stddev, runs.determined)
    )
    # What is not told, or not finite, is as wrong as it can be.
    within = inside(error, stddev)
    rms = np.sqrt(np.mean(np.nan_to_num(error, nan=1e3) ** 2, axis=0))
    sure = [int(determined.sum()), *within[determined, REACTIONS].sum(axis=0).tolist()]
    return Score(rms.tolist(), within.mean(axis=0).tolist(), float(determined.mean()), sure)


class Change(NamedTuple):
    """A case, the constant that is changed in it with its value, and how many seeds."""

    case: str
    field: str
    value: float | tuple
    seeds: int

    @property
    def label(self) -> str:
        """Return the change as text."""
        return _words(self.field, self.value) if self.field else SHIPPED

    def __str__(self):
        """Return a name for files and tables."""
        return f"{self.case}: {self.label}"


SHIPPED = "shipped"
BY_NAME = {case.name: case for case in CASES}


@cache
def _truth(name):
    return BY_NAME[name].truth()


def score_member(change: Change, folder: Path) -> list[Score]:
    """Return the scores of a case with a change, a list over seeds."""
    changed = {change.field: change.value} if change.field else {}
    case, truth = BY_NAME[change.case], _truth(change.case)
    seeds = range(FIRST_SEED, FIRST_SEED + change.seeds)
    return [score(case, truth, seed, changed) for seed in seeds]


def members(options) -> list[Change]:
    """Return the shipped constants and the changes asked for, in each case."""
    changes = [("", 0.0), *(change for name in options.field for change in SWITCHED[name])]
    return [Change(name, *each, options.seeds) for name in BY_NAME for each in changes]


def _words(field, value):
    if isinstance(value, tuple):
        return f"{field} {', '.join(f'{v:g}' for v in value)}"
    return f"{field} {value:g}"


def report(found, options) -> Report:
    """Return a row for each change, over the shipped constants."""
    of: dict[str, list[Score]] = {}
    for change, scores in found:
        of.setdefault(change.label, []).extend(Score(*row) for row in scores)
    head = (
        "change", "error of states over shipped", "error of reactions over shipped",
        "largest error ratio of a case: states, reactions",
        f"runs covered in {100 * LEAST_COVERED:.0f} %: states, reactions", "share determined",
        "share of determined reactions covered, lowest of a case",
    )  # fmt: skip
    return Report(table(head, rows(of, options.seeds)))


def rows(found: dict[str, list[Score]], per_case: int) -> list[tuple]:
    """Return the rows of the table, from scores over cases and seeds of each change."""
    shipped, lines = found[SHIPPED], []
    for label, scores in found.items():
        parts, largest = [], []
        for part in (STATES, REACTIONS):
            off = np.array(
                [
                    np.mean(np.log(np.divide(a.rms[part], b.rms[part])))
                    for a, b in zip(scores, shipped)
                ]
            )
            of_case = off.reshape(-1, per_case).mean(axis=1)
            error = off.std(ddof=1) / len(off) ** 0.5
            parts.append(f"{np.exp(off.mean()):.3f} ± {100 * error:.1f} %")
            largest.append(f"{np.exp(of_case.max()):.2f}")
        counts = [
            sum(min(one.covered[part]) >= LEAST_COVERED for one in scores)
            for part in (STATES, REACTIONS)
        ]
        # Runs of a case count together: of a few samples no share can be told.
        sure = np.array([one.sure for one in scores]).reshape(-1, per_case, 4).sum(axis=1)
        sure = sure[sure[:, 0] > 0]
        lines.append(
            (
                label, *parts, ", ".join(largest),
                f"{counts[0]}, {counts[1]} of {len(scores)}",
                f"{np.mean([one.determined for one in scores]):.2f}",
                f"{(sure[:, 1:] / sure[:, :1]).min():.2f}",
            )
        )  # fmt: skip
    return lines


def add_options(parser) -> None:
    """Add which constants."""
    parser.add_argument("--field", nargs="+", choices=SWITCHED, default=list(SWITCHED))


FAMILY = Family(
    members, score_member, report, add_options, seeds=4,
    group=lambda change: change.case, sources=(cells, pegs, misstated),
)  # fmt: skip
