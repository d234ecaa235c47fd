"""`peg-on-hole stability`: where estimators work, have wrong bounds or diverge."""

from argparse import Namespace
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import NamedTuple

from peg_on_hole_ros.cli import equation_ends
from peg_on_hole_ros.cli.output_paths import out_folder
from peg_on_hole_ros.cli.partial_table import PartialTable
from peg_on_hole_ros.cli.pictures import needed, save
from peg_on_hole_ros.cli.progress import ProgressBar
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.cli.table import table
from peg_on_hole_ros.numba_cache import source_key
from peg_on_hole_ros.study import edges, map_places
from peg_on_hole_ros.study import stability as study
from peg_on_hole_ros.study.map_places import MapPlace

FIRST_SEED = 500
COLUMNS = (*MapPlace._fields, *study.Result._fields)


class Counts(NamedTuple):
    """
    How much of the map is measured.

    Attributes
    ----------
    seeds, other_seeds, pair_seeds : int
        Of the default along an axis, of the others, and of the default on two quantities.
    every : int
        Of the values of an axis, both ends and the usual one beside.
    edge_ratio : float
        Of the values on both sides of an edge.

    """

    seeds: int = 10
    other_seeds: int = 3
    pair_seeds: int = 3
    every: int = 1
    edge_ratio: float = edges.EDGE_RATIO


WHOLE = Counts()
QUICK = Counts(seeds=1, other_seeds=1, pair_seeds=1, every=100, edge_ratio=4.0)


class Job(NamedTuple):
    """One method at one place, over so many seeds."""

    place: MapPlace
    method: str
    seeds: int


def run(arguments: Namespace) -> int:
    """Examine every place, going on where an earlier run was; find edges; draw and write."""
    needed()
    configuration, _ = load(arguments.config)
    folder = out_folder(arguments.out, arguments.config)
    counts = QUICK if arguments.quick else WHOLE
    state = f"# {source_key()} {tuple(counts)} {asdict(configuration)}"
    rows = PartialTable(folder / "stability.csv", COLUMNS, state)
    ends = PartialTable(folder / "equations.csv", equation_ends.EQUATION_COLUMNS, state)
    try:
        found = _examine_all(rows, counts, study.Examiner(configuration))
        with ProgressBar("equations") as progress:
            equation_ends.fill_in(ends, configuration, arguments.quick, progress)
    except BaseException:
        rows.close()
        ends.close()
        raise
    rows.finish()
    ends.finish()
    drawn = equation_ends.drawn_of(ends.rows)
    from peg_on_hole_ros.plots import equations
    from peg_on_hole_ros.plots.stability import figure

    written = [
        rows.path,
        *save(figure(found), folder / "stability"),
        *save(figure(found, narrow=True), folder / "stability_narrow"),
        ends.path,
        *save(equations.figure(*drawn), folder / "equations"),
        *save(equations.figure(*drawn, narrow=True), folder / "equations_narrow"),
    ]
    print(summary(found))
    print()
    print(edges_in_words(found))
    print()
    print(equation_ends.in_words(*drawn))
    print()
    print(", ".join(map(str, written)))
    return 0


def _examine_all(rows, counts, examiner):
    found = found_in(rows.rows)
    jobs = jobs_of(counts)
    # Edges take about as long as all places of the default once more.
    weights = [1.0] * len(jobs) + [1.0 + counts.seeds] * len(map_places.MAP_AXES)
    total, done = sum(weights), 0.0
    with ProgressBar("stability") as progress:

        def take(job):
            if (job.place, job.method) not in found:
                seeds = range(FIRST_SEED, FIRST_SEED + job.seeds)
                result = examiner(job.place, job.method, seeds)
                rows.add([[*job.place, *result._replace(verdict=result.verdict.value)]])
                found.update(found_in(rows.rows[-1:]))

        for job in jobs:
            take(job)
            done += 1.0
            progress(done / total)
        for axis in map_places.MAP_AXES:
            for place in edge_places(found, axis, counts.edge_ratio):
                take(Job(place, study.DEFAULT, counts.seeds))
                progress(done / total)
            done += 1.0 + counts.seeds
    return found


def jobs_of(counts: Counts) -> list[Job]:
    """Return what is examined whatever comes out, each once."""
    jobs = [
        Job(axis.place(value), method, counts.seeds if method == study.DEFAULT
            else counts.other_seeds)
        for axis in map_places.MAP_AXES
        for value in _some(axis, counts.every)
        for method in study.COMPARED_METHODS
    ]  # fmt: skip
    jobs += [
        Job(pair.place(across, up), study.DEFAULT, counts.pair_seeds)
        for pair in map_places.PAIRS
        for up in _some(pair.up, counts.every)
        for across in _some(pair.across, counts.every)
    ]
    # The first stands: places on an axis have the seeds of the axis.
    found: dict = {}
    for job in jobs:
        found.setdefault((job.place, job.method), job)
    return list(found.values())


def _some(axis, every):
    last = len(axis.values) - 1
    return [
        value for k, value in enumerate(axis.values)
        if k % every == 0 or k == last or value == axis.usual
    ]  # fmt: skip


def edge_places(found: edges.Found, axis: map_places.Axis, ratio: float) -> Iterator[MapPlace]:
    """Yield the places that both edges of an axis want, each once the one before is found."""
    for side in edges.SIDES:
        while (value := edges.next_value(edges.edge_of(found, axis, side), ratio)) is not None:
            yield axis.place(value)


def found_in(rows: Sequence[Sequence[str]]) -> dict:
    """Return each place's and method's result of the rows of `stability.csv`."""
    found = {}
    for row in rows:
        named = dict(zip(COLUMNS, row))
        place = MapPlace(*(float(named[name]) for name in MapPlace._fields))
        numbers = {
            name: float(named[name]) if named[name] else float("nan")
            for name in ("inside", "determined", "reactions")
        }
        found[place, named["method"]] = study.Result(
            named["method"], int(named["seeds"]), study.Verdict(named["verdict"]),
            named["worst"], lost=int(named["lost"]), **numbers,
        )  # fmt: skip
    return found


def summary(found: dict) -> str:
    """Return in how many places of the axes each method has which result."""
    shown = [verdict for verdict in study.Verdict if verdict is not study.Verdict.NONE]
    lines = [
        [method, *(str(verdicts.count(verdict)) for verdict in shown)]
        for method, verdicts in verdicts_of(found).items()
    ]
    return table(["places", *(verdict.value for verdict in shown)], lines)


def verdicts_of(found: dict) -> dict[str, list[study.Verdict]]:
    """Return each method's verdicts at the places where all are compared."""
    places = {axis.place(value): None for axis in map_places.MAP_AXES for value in axis.values}
    return {
        method: [found[place, method].verdict for place in places if (place, method) in found]
        for method in study.COMPARED_METHODS
    }


def edge_lines(found: dict) -> list[tuple[str, ...]]:
    """Return each axis with the words for its low and its high side."""
    return [
        (axis.label, *(edges.in_words(edges.edge_of(found, axis, side)) for side in edges.SIDES))
        for axis in map_places.MAP_AXES
    ]


def edges_in_words(found: dict) -> str:
    """Return where the default ends on each axis, a line each."""
    lines = [f"Where {study.DEFAULT} stops working, if one quantity changes:"]
    for label, *sides in edge_lines(found):
        lines.append(f"  {label}: {'; '.join(text for text in sides if text)}")
    return "\n".join(lines)
