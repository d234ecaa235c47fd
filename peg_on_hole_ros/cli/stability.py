"""`peg-on-hole stability`: where estimators hold, err or diverge."""

from argparse import Namespace
from collections.abc import Sequence
from dataclasses import asdict

from peg_on_hole_ros.cli.output_paths import out_folder
from peg_on_hole_ros.cli.partial_table import PartialTable
from peg_on_hole_ros.cli.pictures import needed, save
from peg_on_hole_ros.cli.progress import ProgressBar
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.cli.table import table
from peg_on_hole_ros.numba_cache import source_key
from peg_on_hole_ros.study import stability as study

MAP_PLACES, QUICK_MAP_PLACES = 8, 3
MAP_SEEDS, QUICK_MAP_SEEDS = 3, 1
FIRST_MAP_SEED = 500


def run(arguments: Namespace) -> int:
    """Examine every place along every axis, going on where an earlier run was; draw and write."""
    needed()
    configuration, _ = load(arguments.config)
    folder = out_folder(arguments.out, arguments.config)
    count = QUICK_MAP_PLACES if arguments.quick else MAP_PLACES
    seeds = range(
        FIRST_MAP_SEED, FIRST_MAP_SEED + (QUICK_MAP_SEEDS if arguments.quick else MAP_SEEDS)
    )
    state = f"# {source_key()} {count} {len(seeds)} {asdict(configuration)}"
    rows = PartialTable(
        folder / "stability.csv", study.MAP_COLUMNS, state, len(study.COMPARED_METHODS)
    )
    try:
        found = _examine_all(rows, count, seeds, configuration)
    except BaseException:
        rows.close()
        raise
    rows.finish()
    from peg_on_hole_ros.plots.stability import figure

    written = [
        rows.path,
        *save(figure(found), folder / "stability"),
        *save(figure(found, narrow=True), folder / "stability_narrow"),
    ]
    print(summary(found))
    print(", ".join(map(str, written)))
    return 0


def _examine_all(rows, count, seeds, configuration):
    width, done = len(study.COMPARED_METHODS), 0
    with ProgressBar("stability") as progress:
        for axis in study.MAP_AXES:
            for place in axis.places(count):
                if done * width >= len(rows.rows):
                    rows.add(
                        [axis.name, *place, result.method, result.verdict.value, *result[2:]]
                        for result in study.examine(place, configuration, seeds)
                    )
                done += 1
                progress(done / (count * len(study.MAP_AXES)))
    return found_in(rows.rows)


def found_in(rows: Sequence[Sequence]) -> dict:
    """Return what the picture draws of the rows of `stability.csv`."""
    found, width, first = {}, len(study.COMPARED_METHODS), len(study.MapPlace._fields) + 1
    for begun in range(0, len(rows), width):
        place = rows[begun : begun + width]
        found.setdefault(place[0][0], []).append([_result(row[first:]) for row in place])
    return found


def _result(row):
    numbers = [float(value) if value else float("nan") for value in row[2:]]
    return study.Result(row[0], study.Verdict(row[1]), *numbers)


def summary(found: dict) -> str:
    """Return in how many places each method comes to what, of those with a motion."""
    shown = [verdict for verdict in study.Verdict if verdict is not study.Verdict.NONE]
    lines = []
    for k, method in enumerate(study.COMPARED_METHODS):
        verdicts = [place[k].verdict for places in found.values() for place in places]
        lines.append([method, *(str(verdicts.count(verdict)) for verdict in shown)])
    return table(["places", *(verdict.value for verdict in shown)], lines)
