"""
What each tuned constant of the estimator earns, by switching its field in the record of settings.

    python -m benchmarks.ablation [--only FIELD ...] [--seeds 4] [--folder out/ablation]
        [--page docs/ablation.md]

Cases are motions of the grid's axes and scenes beyond them, with seeds of their own.
Of each case and seed the logarithm of an error over the shipped estimator's is taken, a mean over
the quantities; a row gives the geometric mean over all, and its standard error in per cent. What
lies within two of them is chance.
"""

import argparse
import hashlib
import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import inf
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.grid.cells import NOISE, Motion, truth_of, with_noise
from benchmarks.grid.pegs import closing
from benchmarks.grid.score import INTERVAL, SETTLE_NS, drawn
from benchmarks.resumable import ESTIMATE, put_between, sources_key
from peg_on_hole_ros.cli.simulation_file import read_plan
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.estimator.held_peg import HeldPeg
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.records import JointSample, WrenchSample
from peg_on_hole_ros.sim.measure import START_NS, measure
from peg_on_hole_ros.sim.truth import Truth, integrate

ROOT = Path(__file__).parents[1]
MARKS = "<!-- ablation -->", "<!-- end of ablation -->"
FIRST_SEED = 830_000
FRICTION_SPREAD = 0.05
# A spike of force and torque [N], [N m], in one wrench of so many.
SPIKE, SPIKES_EVERY = 200.0, 97
ROUGHER = 4.0
LIMIT = 0.9

# What is put in a field's place: without its rule where that is possible, else much of it.
SWITCHED = {
    "level": (("level", (10.0, 30.0, 500.0)), ("level", (1.0, 30.0, 500.0))),
    "up": (("up", (0.0, 15.0, 3.0)), ("up", (0.0, 60.0, 12.0))),
    "time": (("time", (0.02, 0.02, 0.02)), ("time", (0.05, 0.05, 0.05))),
    "around_axes": (("around_axes", 0.0), ("around_axes", 1.0)),
    "frictions": (("frictions", 1), ("frictions", 5)),
    "reach": (("reach", 2.0), ("reach", 3.0)),
    "joined": (("joined", 0.0), ("joined", 0.03)),
    "doubt": (("doubt", 0.0), ("doubt", 0.5)),
    "direction_time": (("direction_time", 0.0), ("direction_time", 0.03)),
    "reaction_prior": (("reaction_prior", 1.0), ("reaction_prior", 30.0)),
    "settling": (("settling", 0.002), ("settling", 0.05)),
    "passes": (("passes", 1), ("passes", 2)),
    "free_walk": (("free_walk", 0.1), ("free_walk", 1.0)),
    "zero_time": (("zero_time", 12.0), ("zero_time", inf)),
    "touch_time": (("touch_time", 0.0), ("touch_time", 0.3)),
    "sure": (("sure", 1.0), ("sure", inf)),
    "outlier": (("outlier", inf), ("outlier", 5.0)),
    "noise_count": (("noise_count", 30.0), ("noise_count", 300.0)),
    "noise_most": (("noise_most", 1.0),),
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


def stated(truth: Truth, **changed) -> Truth:
    """Return a truth of which something else is stated, by groups of parameters."""
    configuration = truth.plan.configuration
    groups = {
        group: replace(getattr(configuration, group), **values)
        for group, values in changed.items()
    }
    plan = replace(truth.plan, configuration=replace(configuration, **groups))
    return replace(truth, plan=plan)


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
        lambda: stated(
            sample_scene("working_cycle"),
            wrench={"bias_force_stddev": 2.0, "bias_torque_stddev": 0.05},
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
        return HeldPeg(*given, constants=default_settings(**changed))

    pipeline = Pipeline(configuration, make=make)
    error = np.full((len(truth.t_ns), 9), np.nan)
    stddev, determined = error.copy(), np.zeros(len(error), bool)
    exact = np.hstack([truth.q, truth.rates, truth.normal])
    for o in pipeline.play(case.on_the_way(measure(truth, seed), seed)):
        k = int(np.searchsorted(truth.t_ns, o.t_ns - START_NS))
        error[k] = np.hstack([o.state, o.normal]) - exact[k]
        stddev[k] = np.hstack([np.sqrt(np.diagonal(o.state_covariance)), o.normal_stddev])
        determined[k] = o.monitor["reactions_determined"]
    error[:, 1:3] -= 2 * np.pi * np.round(error[:, 1:3] / (2 * np.pi))
    told = (truth.mode == "three_point") & truth.known & (truth.t_ns >= SETTLE_NS)
    error, stddev, determined = error[told], stddev[told], determined[told]
    # What is not told, or not finite, is as wrong as it can be.
    inside = np.abs(error) <= INTERVAL * stddev
    rms = np.sqrt(np.mean(np.nan_to_num(error, nan=1e3) ** 2, axis=0))
    sure = [int(determined.sum()), *inside[determined, 6:].sum(axis=0).tolist()]
    return Score(rms.tolist(), inside.mean(axis=0).tolist(), float(determined.mean()), sure)


def scored(names, seeds: int, folder: Path) -> dict[str, list[Score]]:
    """Return scores of the shipped constants and of each change, a list over cases and seeds."""
    folder.mkdir(parents=True, exist_ok=True)
    key = sources_key(ESTIMATE, [Path(__file__)])
    changes = {"shipped": {}}
    changes |= {_words(f, v): {f: v} for name in names for f, v in SWITCHED[name]}
    found = {label: [] for label in changes}
    for case in CASES:
        truth = None
        for label, changed in changes.items():
            of = hashlib.sha256(f"{key} {case.name} {label} {seeds}".encode()).hexdigest()[:20]
            path = folder / f"{of}.json"
            if not path.exists():
                truth = truth or case.truth()
                some = range(FIRST_SEED, FIRST_SEED + seeds)
                rows = [score(case, truth, seed, changed) for seed in some]
                path.write_text(json.dumps(rows))
            found[label] += [Score(*row) for row in json.loads(path.read_text())]
        print(case.name, flush=True)
    return found


def _words(field, value):
    if isinstance(value, tuple):
        return f"{field} {', '.join(f'{v:g}' for v in value)}"
    return f"{field} {value:g}"


def rows(found: dict[str, list[Score]]) -> list[str]:
    """Return the table in Markdown."""
    shipped, lines = found["shipped"], []
    lines.append(
        "| change | states' errors over shipped | reactions' | largest of a case: states, "
        f"reactions | runs covered in {100 * LIMIT:.0f} %: states, reactions | determined "
        "| called determined: covered, least of a case and reaction |"
    )
    lines.append("|---|---|---|---|---|---|---|")
    per_case = len(shipped) // len(CASES)
    for label, scores in found.items():
        parts, largest = [], []
        for part in (slice(0, 6), slice(6, 9)):
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
            sum(min(one.covered[part]) >= LIMIT for one in scores)
            for part in (slice(0, 6), slice(6, 9))
        ]
        # Runs of a case count together: of a few samples no share can be told.
        sure = np.array([one.sure for one in scores]).reshape(-1, per_case, 4).sum(axis=1)
        sure = sure[sure[:, 0] > 0]
        lines.append(
            f"| {label} | {parts[0]} | {parts[1]} | {', '.join(largest)} "
            f"| {counts[0]}, {counts[1]} of {len(scores)} "
            f"| {np.mean([one.determined for one in scores]):.2f} "
            f"| {(sure[:, 1:] / sure[:, :1]).min():.2f} |"
        )
    return lines


def main(arguments=None):
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--only", nargs="+", choices=SWITCHED, default=list(SWITCHED))
    parser.add_argument("--seeds", type=int, default=4, help="of each case (4)")
    parser.add_argument("--folder", type=Path, default=Path("out/ablation"))
    parser.add_argument("--page", type=Path, help="page whose table is renewed")
    options = parser.parse_args(arguments)
    text = "\n".join(rows(scored(options.only, options.seeds, options.folder)))
    print(text)
    if options.page:
        put_between(options.page, *MARKS, text)


if __name__ == "__main__":
    main()
