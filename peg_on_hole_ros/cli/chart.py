"""`peg-on-hole chart`: how far estimators are off against what a wrench costs."""

from argparse import Namespace
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from time import thread_time

from peg_on_hole_ros.cli.output_paths import out_folder
from peg_on_hole_ros.cli.partial_table import PartialTable
from peg_on_hole_ros.cli.pictures import needed, save
from peg_on_hole_ros.cli.progress import ProgressBar
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.cli.table import table
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.numba_cache import source_key
from peg_on_hole_ros.study import chart, scenes
from peg_on_hole_ros.study.estimators import ESTIMATORS

SEEDS, QUICK_SEEDS = 5, 1
FIRST_SEED = 100
# Of the thread itself: what else the machine does does not count.
CLOCK = thread_time


def run(arguments: Namespace) -> int:
    """Measure, going on where an earlier run was; draw and write."""
    needed()
    configuration, _ = load(arguments.config)
    folder = out_folder(arguments.out, arguments.config)
    cases = [case for each in scenes.SCENE_KINDS.values() for case in each]
    if arguments.quick:
        cases = [each[0] for each in scenes.SCENE_KINDS.values()]
    seeds = range(FIRST_SEED, FIRST_SEED + (QUICK_SEEDS if arguments.quick else SEEDS))
    state = f"# {source_key()} {len(cases)} {len(seeds)} {asdict(configuration)}"
    chosen = [one for one in ESTIMATORS if one.shown or not arguments.quick]
    each = len(chosen) + 1
    rows = PartialTable(folder / "chart.csv", chart.ChartScore._fields, state, each)
    try:
        with ProgressBar("chart") as progress:
            for k, case in enumerate(cases):
                if k * each >= len(rows.rows):
                    rows.add(_scores(chosen, case, scenes.truth_of(case, configuration), seeds))
                progress((k + 1) / len(cases))
    except BaseException:
        rows.close()
        raise
    rows.finish()
    found = scores_of(rows.rows)
    whole, limits = chart.limits(chart.overall(found))
    print(summary(whole, limits))
    print(", ".join(map(str, [rows.path, *draw(found, folder), *_cycle(configuration, folder)])))
    return 0


def _cycle(configuration, folder):
    """Measure and draw what a step costs along a working cycle; a cell may have none."""
    from peg_on_hole_ros.plots.chart import cycle_figure

    try:
        truth = scenes.working_cycle(configuration)
    except PegOnHoleError as error:
        print(f"no working cycle of this cell is drawn: {error}")
        return []
    pieces = chart.cycle_costs(truth, CLOCK)
    table_of = PartialTable(folder / "chart_cycle.csv", chart.CyclePiece._fields, "")
    table_of.add(pieces)
    table_of.finish()
    return [
        table_of.path,
        *save(cycle_figure(pieces), folder / "chart_cycle"),
        *save(cycle_figure(pieces, narrow=True), folder / "chart_cycle_narrow"),
    ]


def pieces_of(rows: Iterable[Sequence]) -> list[chart.CyclePiece]:
    """Return what is in rows of `chart_cycle.csv`."""
    return [
        chart.CyclePiece(method, float(t), phase, mode, float(step))
        for method, t, phase, mode, step in rows
    ]


def draw(found: Sequence[chart.ChartScore], folder: Path) -> list[Path]:
    """Draw all pictures of the scores into a folder; return what was written."""
    from peg_on_hole_ros.plots.chart import figure, kinds_figure

    whole = chart.limits(chart.overall(found))
    kinds = {kind: chart.limits(rows) for kind, rows in chart.of_kinds(found).items()}
    return [
        path
        for name, narrow in (("", False), ("_narrow", True))
        for path in (
            *save(figure(*whole, narrow=narrow), folder / f"chart{name}"),
            *save(kinds_figure(kinds, narrow=narrow), folder / f"chart_kinds{name}"),
        )
    ]


def _scores(chosen, case, truth, seeds):
    return [
        *chart.scores(chosen, case, truth, seeds, CLOCK),
        chart.bound_score(case, truth),
    ]


def scores_of(rows: Iterable[Sequence]) -> list[chart.ChartScore]:
    """Return the scores in rows of `chart.csv`."""
    return [chart.ChartScore(*row[:3], *_numbers(row[3:])) for row in rows]


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
