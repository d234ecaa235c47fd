"""`peg-on-hole stability`: where each method holds, errs, diverges or refuses."""

from argparse import Namespace
from dataclasses import asdict

import numpy as np

from peg_on_hole_ros.cli.pictures import needed, save
from peg_on_hole_ros.cli.places import out_folder
from peg_on_hole_ros.cli.progress import Progress
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.cli.table import table
from peg_on_hole_ros.edges.partial_table import PartialTable, write_table
from peg_on_hole_ros.numba_cache import source_key
from peg_on_hole_ros.study import regularisation
from peg_on_hole_ros.study import stability as study

COUNT, QUICK_COUNT = 20, 6
_TRUTH, _VERDICT = study.COLUMNS.index("truth"), study.COLUMNS.index("verdict")


def run(arguments: Namespace) -> int:
    """Examine every place of every map, going on where an earlier run was; draw and write."""
    needed()
    configuration, _ = load(arguments.config)
    folder = out_folder(arguments.out, arguments.config)
    count = QUICK_COUNT if arguments.quick else COUNT
    state = f"# {source_key()} {count} {asdict(configuration)}"
    group = len(study.ALL_METHODS) * count
    rows = PartialTable(folder / "stability.csv", study.COLUMNS, state, group)
    try:
        found = _examine_all(rows, count, configuration)
    except BaseException:
        rows.close()
        raise
    rows.finish()
    from peg_on_hole_ros.edges.plots import regularisation as regularisation_plots
    from peg_on_hole_ros.edges.plots import stability as stability_plots

    picture = stability_plots.figure(study.MAPS, study.ALL_METHODS, found)
    written = [rows.path, *save(picture, folder / "stability")]
    effects = regularisation.effects(configuration)
    path = folder / "regularisation.csv"
    write_table(path, regularisation.COLUMNS, effects)
    picture = regularisation_plots.figure(effects, configuration.filter.slip_velocity_scale)
    written += [path, *save(picture, folder / "regularisation")]
    print(summary(found))
    print(", ".join(map(str, written)))
    return 0


def _examine_all(rows, count, configuration):
    width = len(study.ALL_METHODS)
    found, done, total = {}, 0, count * len(study.MAPS)
    with Progress("stability") as progress:
        for map_ in study.MAPS:
            truths, verdicts = [], []
            for line in study.places(map_, count):
                begin = done * width * count
                if begin >= len(rows.rows):
                    rows.add(_line(map_, line, configuration))
                kept = rows.rows[begin : begin + width * count]
                truths.append([study.Truth[row[_TRUTH]] for row in kept[::width]])
                verdicts.append([study.Verdict(row[_VERDICT]) for row in kept])
                done += 1
                progress(done / total)
            found[map_.name, "truth"] = np.array(truths, object)
            for k, method in enumerate(study.ALL_METHODS):
                found[map_.name, method] = np.array([v[k::width] for v in verdicts], object)
    return found


def _line(map_, line, configuration):
    for place in line:
        truth, results = study.examine(place, configuration)
        for result in results:
            yield [map_.name, *place[:6], truth.name, result.method, result.verdict.value,
                   *result[2:]]  # fmt: skip


def summary(found) -> str:
    """Return the shares of the verdicts for each method, by what is true."""
    truth = np.concatenate([found[m.name, "truth"].ravel() for m in study.MAPS])
    real = np.array([t in study.SOLVED for t in truth])
    head = ["%, of places", *(v.value for v in study.Verdict), "refused: no motion"]
    head[2] = "within bounds"
    lines = []
    for method in study.ALL_METHODS:
        verdicts = np.concatenate([found[m.name, method].ravel() for m in study.MAPS])
        shares = [np.mean(verdicts[real] == v) for v in study.Verdict]
        right = np.mean(verdicts[~real] == study.Verdict.REFUSED) if (~real).any() else 1.0
        lines.append([method, *(f"{100 * share:.0f}" for share in shares), f"{100 * right:.0f}"])
    return table(head, lines)
