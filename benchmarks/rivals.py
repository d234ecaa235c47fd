"""
The process noise with which each method of the chart has the least error, by one rule for all.

Motions are `bend`, `sway` and `turn` of the grid, which no published figure uses, at three speeds
and two noises. The best process noise has the least geometric mean of the errors of reactions and
of the tilt rate, among those whose 95 % bounds contain LEAST_COVERED of the determined samples, at
least half of all, over the motions of each name. If no value does, a method has the value of the
method on which it is built. The default's three values are scaled together.
"""

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.grid import cells
from benchmarks.grid.cells import Motion, truth_of, with_noise
from benchmarks.harness.exact import exactly
from benchmarks.harness.family import Family, Report
from benchmarks.harness.tables import table
from peg_on_hole_ros.estimator.methods.method import of_settings
from peg_on_hole_ros.estimator.methods.registry import METHODS
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.sim.measure import measure
from peg_on_hole_ros.study.chart import LEAST_DETERMINED
from peg_on_hole_ros.study.estimators import NEAREST_LEVELS
from peg_on_hole_ros.study.runs import LEAST_COVERED, always_in_contact, errors, run

FIRST_SEED = 840_000
LEVELS = (0.3, 1.0, 3.0, 10.0, 30.0, 100.0)
# The default's are these times its own.
SCALES = (0.1, 1 / 3, 1.0, 3.0)
NAMES = ("bend", "sway", "turn")
MOTIONS = tuple(
    (Motion(clearance, 0.2, speed, name), noise)
    for name in NAMES
    for clearance, speed, noise in (
        (1e-4, 0.01, "nominal"), (1e-4, 0.16, "nominal"), (5e-4, 0.16, "high"),
        (5e-4, 1.0, "nominal"),
    )
)  # fmt: skip
FRICTION_SPREAD = 0.05
# The wrench alone drives its motion: levels beyond what one wrench tells of an acceleration.
DRIVEN_LEVELS = (1e3, 1e4, 1e5, 1e6)
# A tilt that is lost, and what is not finite, counts as so far off [of the load], [rad/s].
LOST = 1.0


class Setting(NamedTuple):
    """A method with levels [rad/s^2]."""

    method: str
    levels: tuple[float, ...]
    seeds: int

    def __str__(self):
        """Return a name for files and tables."""
        return f"{self.method}, {_words(self.levels)} rad/s2"


class Score(NamedTuple):
    """Of one run: as of `study.runs.Errors`."""

    reactions: float
    tilt_rate: float
    reactions_inside: float
    determined: float
    lost: bool


@cache
def _truth(motion, noise):
    return with_noise(truth_of(motion)[0], noise, FRICTION_SPREAD)


def score_member(setting: Setting, folder: Path) -> list[Score]:
    """Return the scores of a setting over all motions and seeds."""
    settings = METHODS[setting.method].settings or {}
    make = of_settings({**settings, "mode_stddev": setting.levels}).make
    found = []
    for motion, noise in MOTIONS:
        truth = _truth(motion, noise)
        configuration = always_in_contact(exactly(truth.plan.configuration))
        for seed in range(FIRST_SEED, FIRST_SEED + setting.seeds):
            with np.errstate(invalid="ignore", over="ignore"):
                track = run(configuration, list(measure(truth, seed)), lambda: 0.0, make)
                off = errors(truth, track)
            found.append(
                Score(off.reactions, off.tilt_rate, off.reactions_inside, off.determined,
                      bool(off.lost))
            )  # fmt: skip
    return found


def members(options) -> list[Setting]:
    """Return every setting of the methods asked for."""
    return [
        Setting(method, levels, options.seeds)
        for method in options.method
        for levels in _levels_of(method)
    ]


def _levels_of(method):
    if method == "mixture":
        own = default_settings()
        return [
            tuple(scale * float(own.mode_stddev[k]) for k in range(own.modes)) for scale in SCALES
        ]
    return [(level,) for level in (DRIVEN_LEVELS if method == "dde_driven" else LEVELS)]


class Pooled(NamedTuple):
    """A setting over all motions: geometric means of errors, pooled shares."""

    reactions: float
    tilt_rate: float
    covered: float
    determined: float
    lost: float
    holds: bool = False

    @property
    def off(self) -> float:
        """Return what settings are compared by."""
        return float(np.sqrt(self.reactions * self.tilt_rate))


def pooled(scores: list[Score]) -> Pooled:
    """Return the scores of a setting together; it holds where it does for each name of motion."""
    whole = _pooled(scores)
    each = len(scores) // len(NAMES)
    parts = [_pooled(scores[k * each : (k + 1) * each]) for k in range(len(NAMES))]
    return whole._replace(holds=all(_holds(part) for part in parts))


def _holds(part):
    covered = part.covered >= LEAST_COVERED and part.determined >= LEAST_DETERMINED
    return covered and part.lost == 0.0


def _pooled(scores):
    reactions, rates = (
        np.exp(np.mean(np.log(np.nan_to_num(part, nan=LOST, posinf=LOST))))
        for part in ([s.reactions for s in scores], [s.tilt_rate for s in scores])
    )
    weight = np.array([s.determined for s in scores])
    inside = np.nan_to_num([s.reactions_inside for s in scores])
    return Pooled(
        float(reactions), float(rates),
        float((weight * inside).sum() / weight.sum()) if weight.sum() > 0 else 0.0,
        float(weight.mean()), float(np.mean([s.lost for s in scores])),
    )  # fmt: skip


def best(found: dict[Setting, Pooled]) -> Setting:
    """Return the setting that the rule chooses of one method's."""
    holding = [setting for setting in found if found[setting].holds]
    return min(holding or found, key=lambda setting: found[setting].off)


def report(found, options) -> Report:
    """Return a row for each method: what it does best with, and what it has."""
    of: dict[str, dict[Setting, Pooled]] = {}
    for setting, scores in found:
        setting = Setting(*setting)
        of.setdefault(setting.method, {})[setting] = pooled([Score(*row) for row in scores])
    lines = []
    for method, settings in of.items():
        chosen = best(settings)
        own = _own(method, options.seeds)
        came, now = settings[chosen], settings.get(own)
        lines.append(
            (
                f"`{method}`", _words(chosen.levels) if came.holds else "none covers",
                f"{100 * came.reactions:.2f}", f"{came.tilt_rate:.3f}",
                f"{100 * came.covered:.0f} %", f"{100 * came.determined:.0f} %",
                _words(own.levels), f"{now.off / came.off:.2f}" if now else "",
            )
        )  # fmt: skip
    head = (
        "method", "best process noise [rad/s^2]", "error of the reactions [%]",
        "error of the tilt rate [rad/s]", "coverage of 95 % bounds", "determined",
        "process noise used [rad/s^2]", "error, ratio to the best",
    )  # fmt: skip
    return Report(table(head, lines))


def _own(method, seeds):
    """Return what the chart has a method with."""
    settings = default_settings(**(METHODS[method].settings or {}))
    levels = tuple(float(settings.mode_stddev[k]) for k in range(settings.modes))
    return Setting(
        method, (NEAREST_LEVELS[method],) if method in NEAREST_LEVELS else levels, seeds
    )


def _words(levels):
    return ", ".join(f"{level:.3g}" for level in levels)


def add_options(parser) -> None:
    """Add which methods."""
    parser.add_argument("--method", nargs="+", choices=METHODS, default=list(METHODS))


FAMILY = Family(
    members, score_member, report, add_options, seeds=2,
    group=lambda setting: setting.method, sources=(cells,),
)  # fmt: skip
