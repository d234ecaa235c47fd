"""`peg-on-hole chart`: how far estimators are off against what a wrench costs."""

from argparse import Namespace
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from time import thread_time

from peg_on_hole_ros.cli.output_paths import out_folder
from peg_on_hole_ros.cli.partial_table import PartialTable
from peg_on_hole_ros.cli.pictures import needed, save
from peg_on_hole_ros.cli.progress import ProgressBar
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.cli.table import table
from peg_on_hole_ros.numba_cache import source_key
from peg_on_hole_ros.study import chart, scenes

SEEDS, QUICK_SEEDS = 3, 1
QUICK_CASES = 3
FIRST_SEED = 100
# Of the thread itself: what else the machine does does not count.
CLOCK = thread_time


def run(arguments: Namespace) -> int:
    """Measure, going on where an earlier run was; draw and write."""
    needed()
    configuration, _ = load(arguments.config)
    folder = out_folder(arguments.out, arguments.config)
    cases = scenes.CASES[:QUICK_CASES] if arguments.quick else scenes.CASES
    seeds = range(FIRST_SEED, FIRST_SEED + (QUICK_SEEDS if arguments.quick else SEEDS))
    state = f"# {source_key()} {len(cases)} {len(seeds)} {asdict(configuration)}"
    chosen = [one for one in chart.ESTIMATORS if one.shown or not arguments.quick]
    each = len(chosen) + 1
    rows = PartialTable(folder / "chart.csv", chart.ChartScore._fields, state, each)
    try:
        with ProgressBar("chart") as progress:
            for k, case in enumerate(cases):
                if k * each >= len(rows.rows):
                    rows.add(
                        _scores(chosen, case.name, scenes.truth_of(case, configuration), seeds)
                    )
                progress((k + 1) / len(cases))
    except BaseException:
        rows.close()
        raise
    rows.finish()
    found, limits = chart.limits(chart.overall(scores_of(rows.rows)))
    from peg_on_hole_ros.plots.chart import figure

    written = [
        rows.path,
        *save(figure(found, limits), folder / "chart"),
        *save(figure(found, limits, narrow=True), folder / "chart_narrow"),
    ]
    print(summary(found, limits))
    print(", ".join(map(str, written)))
    return 0


def _scores(chosen, case, truth, seeds):
    return [
        *chart.scores(chosen, case, truth, seeds, CLOCK),
        chart.bound_score(case, truth),
    ]


def scores_of(rows: Iterable[Sequence]) -> list[chart.ChartScore]:
    """Return the scores in rows of `chart.csv`."""
    return [chart.ChartScore(*row[:2], *_numbers(row[2:])) for row in rows]


def _numbers(row):
    return [float(value) if value else float("nan") for value in row]


def summary(found: list[chart.Overall], limits: chart.Limits) -> str:
    """Return the figures as a table, and the bound."""
    head = [
        "estimator",
        "reactions %",
        "tilt rate",
        "within 95 %",
        "determined",
        "lost",
        "step us",
        "us a ms",
    ]
    lines = [
        [
            row.name, f"{100 * row.reactions:.2f}", f"{row.tilt_rate:.4f}",
            f"{100 * row.reactions_inside:.0f}", f"{100 * row.determined:.0f} %",
            f"{100 * row.lost:.0f} %", f"{row.step:.1f}", f"{row.whole:.0f}",
        ]
        for row in found
    ]  # fmt: skip
    least = (
        f"bound at 1 kHz: reactions {100 * limits.reactions:.2f} %, tilt rate "
        f"{limits.tilt_rate:.4f}"
    )
    return f"{table(head, lines)}\n{least}"
