"""`peg-on-hole chart`: speed against accuracy of integrators, filters and implementations."""

from argparse import Namespace
from dataclasses import asdict
from time import thread_time

from peg_on_hole_ros.cli.pictures import needed, save
from peg_on_hole_ros.cli.places import out_folder
from peg_on_hole_ros.cli.progress import Progress
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.cli.table import table
from peg_on_hole_ros.edges.c_code.limit import build
from peg_on_hole_ros.edges.partial_table import PartialTable, write_table
from peg_on_hole_ros.numba_cache import source_key
from peg_on_hole_ros.parameter_table import PARAMETERS
from peg_on_hole_ros.study import filtering, front, implementations, integration, scenes
from peg_on_hole_ros.study.problems import YARDSTICKS
from peg_on_hole_ros.study.steps import METHODS

SEEDS, QUICK_SEEDS = 10, 2
QUICK_CASES = 4
REPEATS, QUICK_REPEATS = 9, 3
QUICK_TOLERANCES = (1e-3,)
FIRST_SEED = 100
# Of the thread itself: what else the machine does does not count.
CLOCK = thread_time


def run(arguments: Namespace) -> int:
    """Measure, going on where an earlier run was; draw and write."""
    needed()
    configuration, _ = load(arguments.config)
    folder = out_folder(arguments.out, arguments.config)
    quick = arguments.quick
    state = f"# {source_key()} {quick} {asdict(configuration)}"
    with Progress("chart") as progress:
        cases = scenes.CASES[:QUICK_CASES] if quick else scenes.CASES
        motions = {}
        for case in cases:
            truth = scenes.truth_of(case, configuration)
            motions[case.name] = truth, scenes.bound_along(truth)
            progress(0.15 * len(motions) / len(cases))
        plain = [motions[name] for name in scenes.NAMES]
        truths = [truth for truth, _ in plain]
        bound = scenes.typical_bound(plain)
        costs, note = _costs(
            configuration, truths[0], scenes.recorded(truths[0], FIRST_SEED), quick
        )
        progress(0.25)
        variants = _variants(quick)
        scores = _filters(folder, state, variants, motions, quick, progress)
        predictions = _integrators(folder, state, truths, quick, progress)
    write_table(folder / "chart_implementations.csv", implementations.Cost._fields, costs)
    from peg_on_hole_ros.edges.plots import chart as chart_plots

    limit = next((c.microseconds for c in costs if c.name == implementations.C), None)
    standings = front.standings(scores, variants)
    by_name = {cost.name: cost.microseconds for cost in costs}
    besides = by_name[implementations.PIPELINE] - by_name[implementations.CALLED]
    whole = front.standings(scores, variants, besides)
    pictures = {
        "chart_integrators": chart_plots.integrators(predictions, bound, limit),
        "chart_filters": chart_plots.filters(front.overall(scores), limit),
        "chart_fronts": chart_plots.fronts(scores, standings),
        "chart_implementations": chart_plots.costs(costs, f"\n{note}" if limit is None else ""),
    }
    written = [path for name, fig in pictures.items() for path in save(fig, folder / name)]
    print(summary(front.overall(scores), standings, whole, costs, note))
    print(", ".join(map(str, written)))
    return 0


def _costs(configuration, truth, recording, quick):
    c_step, note = build()
    repeats = QUICK_REPEATS if quick else REPEATS
    found = implementations.costs(configuration, truth, recording, c_step, CLOCK, repeats)
    return found, note


def _variants(quick):
    choices = {parameter.name: parameter.choices for parameter in PARAMETERS}
    found = filtering.variants(choices.get)
    # A quick look leaves out what takes a hundred times as long as the rest.
    return [variant for variant in found if not quick or variant.seeds > filtering.SLOW_SEEDS]


def _filters(folder, state, variants, motions, quick, progress):
    path, group = folder / "chart_filters.csv", len(variants)
    rows = PartialTable(path, filtering.Score._fields, state, group)
    try:
        for k, (case, (truth, bound)) in enumerate(motions.items()):
            if k * group >= len(rows.rows):
                seeds = range(FIRST_SEED, FIRST_SEED + (QUICK_SEEDS if quick else SEEDS))
                recordings = [scenes.recorded(truth, seed) for seed in seeds]
                rows.add(filtering.scores(variants, case, (truth, bound, recordings), CLOCK))
            progress(0.25 + 0.5 * (k + 1) / len(motions))
    except BaseException:
        rows.close()
        raise
    rows.finish()
    return [filtering.Score(*row[:2], *_numbers(row[2:])) for row in rows.rows]


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
            progress(0.75 + 0.25 * (k + 1) / len(jobs))
    except BaseException:
        rows.close()
        raise
    rows.finish()
    return [integration.Prediction(row[0], *_numbers(row[1:])) for row in rows.rows]


def _predicted(kept, ends, method, setting, quick):
    if method in METHODS:
        repeats = QUICK_REPEATS if quick else REPEATS
        return integration.predict_all(kept, ends, method, setting, CLOCK, repeats)
    return integration.yardstick(kept, ends, method, setting, CLOCK)


def _numbers(row):
    return [float(value) if value else float("nan") for value in row]


def summary(overall, standings, whole, costs, note) -> str:
    """Return the figures as three tables."""
    lines = [
        [
            s.name,
            f"{s.state_ratio:.2f}",
            f"{s.reaction_ratio:.2f}",
            f"{s.coverage:.3f}",
            f"{100 * s.lost:.0f}",
            f"{s.microseconds:.1f}",
        ]
        for s in overall
    ]
    head = ["filter", "state/bound", "reactions/bound", "within 95 %", "lost %", "us a ms"]
    text = table(head, lines)
    for found, of in ((standings, "the filter"), (whole, "the pipeline with it")):
        lines = [
            [s.case, "yes" if s.on_front else s.by]
            + (["", ""] if s.on_front else [f"{s.cost:.2f}", f"{s.error:.2f}"])
            for s in found
        ]
        head = ["motion", "default on front, or beaten by", "its cost", "its error"]
        count = f"cost of {of}: on the front in {sum(s.on_front for s in found)} of {len(found)}"
        text += f"\n\n{table(head, lines)}\n{count}"
    lines = [[c.name, f"{c.microseconds:.2f}", f"{c.over_c:.2f}", f"{c.difference:.1e}"]
             for c in costs]  # fmt: skip
    head = ["implementation", "us a step", "over C", "apart [sigma]"]
    return f"{text}\n\n{table(head, lines)}\nC: {note}"
