"""`peg-on-hole chart`: speed against accuracy of integrators, filters and implementations."""

from argparse import Namespace
from dataclasses import asdict
from time import thread_time

import numpy as np

from peg_on_hole_ros.cli.pictures import needed, save
from peg_on_hole_ros.cli.progress import Progress
from peg_on_hole_ros.cli.settings import load, out_folder
from peg_on_hole_ros.cli.table import table
from peg_on_hole_ros.edges.c_limit import build
from peg_on_hole_ros.edges.partial_table import PartialTable, write_table
from peg_on_hole_ros.numba_cache import source_key
from peg_on_hole_ros.parameter_table import PARAMETERS
from peg_on_hole_ros.study import filtering, implementations, integration, scenes
from peg_on_hole_ros.study.problems import YARDSTICKS
from peg_on_hole_ros.study.steps import METHODS

SEEDS, QUICK_SEEDS = 10, 2
REPEATS, QUICK_REPEATS = 9, 3
QUICK_TOLERANCES = (1e-3,)
FIRST_SEED = 100
# Of the thread itself: what else the machine does does not count.
CLOCK = thread_time


def run(arguments: Namespace) -> int:
    """Measure, going on where an earlier run was; draw and write."""
    needed()
    configuration, _ = load(arguments.config)
    folder = out_folder(arguments.out)
    quick = arguments.quick
    state = f"# {source_key()} {quick} {asdict(configuration)}"
    with Progress("chart") as progress:
        truths = [scenes.truth_of(name, configuration) for name in scenes.NAMES]
        bounds = [scenes.bound_along(truth) for truth in truths]
        bound = float(np.median([scenes.rotation_bound(t, b) for t, b in zip(truths, bounds)]))
        progress(0.1)
        recordings = _recordings(truths, QUICK_SEEDS if quick else SEEDS)
        progress(0.15)
        costs, note = _costs(configuration, truths[0], recordings[0][0], quick)
        progress(0.25)
        motions = list(zip(truths, bounds, recordings))
        scores = _filters(folder, state, configuration, motions, progress)
        predictions = _integrators(folder, state, truths, quick, progress)
    write_table(folder / "chart_implementations.csv", implementations.Cost._fields, costs)
    from peg_on_hole_ros.edges import chart_plots

    limit = next((c.microseconds for c in costs if c.name == implementations.C), None)
    pictures = {
        "chart_integrators": chart_plots.integrators(predictions, bound, limit),
        "chart_filters": chart_plots.filters(scores, limit),
        "chart_implementations": chart_plots.costs(costs, f"\n{note}" if limit is None else ""),
    }
    written = [path for name, fig in pictures.items() for path in save(fig, folder / name)]
    print(summary(scores, costs, note))
    print(", ".join(map(str, written)))
    return 0


def _recordings(truths, count):
    seeds = range(FIRST_SEED, FIRST_SEED + count)
    return [[scenes.recorded(truth, seed) for seed in seeds] for truth in truths]


def _costs(configuration, truth, recording, quick):
    c_step, note = build()
    repeats = QUICK_REPEATS if quick else REPEATS
    found = implementations.costs(configuration, truth, recording, c_step, CLOCK, repeats)
    return found, note


def _filters(folder, state, configuration, motions, progress):
    choices = {parameter.name: parameter.choices for parameter in PARAMETERS}
    rows = PartialTable(folder / "chart_filters.csv", filtering.Score._fields, state)
    try:
        variants = filtering.variants(choices.get)
        for k, variant in enumerate(variants):
            if k >= len(rows.rows):
                rows.add([filtering.score(variant, configuration, motions, CLOCK)])
            progress(0.25 + 0.35 * (k + 1) / len(variants))
    except BaseException:
        rows.close()
        raise
    rows.finish()
    return [filtering.Score(*_numbers(row)) for row in rows.rows]


def _integrators(folder, state, truths, quick, progress):
    rows = PartialTable(folder / "chart_integrators.csv", integration.Prediction._fields, state)
    jobs = [(method, step) for method in METHODS for step in integration.STEPS]
    tolerances = QUICK_TOLERANCES if quick else integration.TOLERANCES
    jobs += [(name, rtol) for name in YARDSTICKS for rtol in tolerances]
    try:
        kept, ends = integration.solved([integration.stretches(truth) for truth in truths])
        for k, (method, setting) in enumerate(jobs):
            if k >= len(rows.rows):
                rows.add([_predicted(kept, ends, method, setting, quick)])
            progress(0.6 + 0.4 * (k + 1) / len(jobs))
    except BaseException:
        rows.close()
        raise
    rows.finish()
    return [integration.Prediction(*_numbers(row)) for row in rows.rows]


def _predicted(kept, ends, method, setting, quick):
    if method in METHODS:
        repeats = QUICK_REPEATS if quick else REPEATS
        return integration.predict_all(kept, ends, method, setting, CLOCK, repeats)
    return integration.yardstick(kept, ends, method, setting, CLOCK)


def _numbers(row):
    return [row[0], *(float(value) if value else float("nan") for value in row[1:])]


def summary(scores, costs, note) -> str:
    """Return the figures as two tables."""
    lines = [
        [
            s.name,
            f"{s.state_ratio:.2f}",
            f"{s.reaction_ratio:.2f}",
            f"{s.coverage:.3f}",
            f"{100 * s.lost:.0f}",
            f"{s.microseconds:.1f}",
        ]
        for s in scores
    ]
    head = ["filter", "state/bound", "reactions/bound", "within 95 %", "lost %", "us a step"]
    text = table(head, lines)
    lines = [[c.name, f"{c.microseconds:.2f}", f"{c.over_c:.2f}", f"{c.difference:.1e}"]
             for c in costs]  # fmt: skip
    head = ["implementation", "us a step", "over C", "apart [sigma]"]
    return f"{text}\n\n{table(head, lines)}\nC: {note}"
