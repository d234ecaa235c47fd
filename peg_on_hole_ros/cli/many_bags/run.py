"""`peg-on-hole replay` of many bags: each one's outcome, one table, one page."""

import argparse
import hashlib
from collections import Counter
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path

from peg_on_hole_ros.cli.bag_and_configuration import Reading, print_line
from peg_on_hole_ros.cli.many_bags.progress import Bar
from peg_on_hole_ros.cli.many_bags.table import PARQUET, rows_of, write_tables
from peg_on_hole_ros.cli.many_bags.task import Task, settings_hash
from peg_on_hole_ros.cli.many_bags.which_bags import named_bags
from peg_on_hole_ros.cli.many_bags.workers import on_cluster, on_this_machine
from peg_on_hole_ros.cli.output_paths import alone_in, out_folder, write_text
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.config.configuration import to_parameters
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.messages.warm_up import warm
from peg_on_hole_ros.report.many_bags_page import shift_page
from peg_on_hole_ros.report.page import library
from peg_on_hole_ros.robot.urdf_source import FROM_TOPIC, urdf_path

PAGE = "index.html"
# From the least to the worst.
_EXIT_CODES = (0, 4, 3, 2, 70)
_MEANINGS = {
    0: "read whole",
    4: "ended early, with what was read kept",
    3: "unreadable or without the needed topics",
    2: "not with this configuration",
    70: "given up",
}
_MOST_JOBS = 256


def run(arguments: argparse.Namespace) -> int:
    """Replay all bags; return the worst of their exit codes."""
    _check(arguments)
    configuration, _ = load(arguments.config)
    out = out_folder(arguments.out, arguments.config)
    with alone_in(out):
        return _run(arguments, configuration, out)


def _run(arguments, configuration, out):
    tasks = _tasks(arguments, configuration, out)
    if arguments.dask:
        found = on_cluster(tasks, arguments.dask)
    else:
        # Compiled once, and told, before several processes would each do so.
        warm(configuration)
        # More processes than bags would only start.
        found = on_this_machine(tasks, min(arguments.jobs or 1, len(tasks)))
    results = {}
    with Bar(len(tasks)) as bar:
        for result in found:
            results[result["name"]] = result
            bar.done(f"{result['path']}: {outcome(result)}")
            for note in result["notes"]:
                print_line(note)
    # Whoever was first, the order is that of the arguments.
    ordered = [results[task.name] for task in tasks]
    _write(out, ordered)
    print("\n".join(_totals(ordered)))
    return max((result["exit_code"] for result in ordered), key=_EXIT_CODES.index)


def _check(arguments):
    for name in ("summary", "cycles"):
        if getattr(arguments, name):
            raise PegOnHoleError(
                f"--{name} is for one bag: with many bags each has its summary, with the tries, "
                "in --out"
            )
    if arguments.smooth:
        raise PegOnHoleError("--smooth is for one bag")
    if arguments.report not in (None, True):
        raise PegOnHoleError(
            f"--report {arguments.report} is for one bag: with many bags each has its own "
            "report, in --out; give --report alone"
        )
    if not arguments.out:
        raise PegOnHoleError("many bags need a folder for their results: name one with --out DIR")
    if arguments.jobs is not None and not 1 <= arguments.jobs <= _MOST_JOBS:
        raise PegOnHoleError(f"--jobs = {arguments.jobs} is not within 1 to {_MOST_JOBS}")
    if arguments.jobs is not None and arguments.dask:
        raise PegOnHoleError("--jobs and --dask exclude each other: a cluster has its workers")
    if arguments.report:
        library()  # Missing, it is told before the work.


def _tasks(arguments, configuration: Configuration, out: Path):
    reading = Reading.of(arguments)
    report = arguments.report is True
    given = to_parameters(configuration) if arguments.config else None
    joints = configuration.joints
    described = arguments.config and joints.source == "robot" and joints.urdf != FROM_TOPIC
    urdf = hashlib.sha256(urdf_path(joints).read_bytes()).hexdigest() if described else ""
    settings = settings_hash(given, urdf, reading, report, arguments.estimates)
    config = str(Path(arguments.config).absolute()) if arguments.config else None
    return [
        Task(
            bag.path,
            bag.path.absolute(),
            (out / bag.name).absolute(),
            settings,
            config,
            reading,
            report,
            arguments.estimates,
        )
        for bag in named_bags(arguments.bags, out)
    ]


def outcome(result: dict) -> str:
    """Return what became of a bag, in a line."""
    told = []
    if result["summary"]:
        cycles = result["summary"]["cycles"]
        told = [_try(cycle) for cycle in cycles[:3]] or ["no try"]
        if len(cycles) > len(told):
            told.append(f"{len(cycles) - len(told)} more tries")
        changes = sum(alarm["level"] != "OK" for alarm in result["summary"]["alarms"])
        told += [f"{changes} alarms"] if changes else []
        told += [f"{len(result['doubts'])} warnings"] if result["doubts"] else []
    if result["error"]:
        told.append(f"error: {result['error']}")
    return ", ".join(told) + (" (done before)" if result["done_before"] else "")


def _try(cycle):
    after = cycle["transition_time"]
    return cycle["outcome"] + ("" if after is None else f" after {after:.3f} s")


def _write(out, results):
    rows = [row for result in results for row in rows_of(result)]
    written = write_tables(out, rows)
    if not any(path.name == PARQUET for path in written):
        print_line("no Parquet is written: pip install pyarrow")
    if find_spec("plotly"):
        write_text(out / PAGE, shift_page(results, rows))
    else:
        print_line(f"no {PAGE} is written: pip install plotly")


def _totals(results: Iterable[dict]):
    results = list(results)
    codes = Counter(result["exit_code"] for result in results)
    parts = (f"{codes[code]} {_MEANINGS[code]}" for code in _EXIT_CODES if codes[code])
    before = sum(result["done_before"] for result in results)
    yield f"{len(results)} bags: {'; '.join(parts)}" + (
        f"; {before} done before" if before else ""
    )
    tries = Counter(
        cycle["outcome"]
        for result in results
        if result["summary"]
        for cycle in result["summary"]["cycles"]
    )
    told = ", ".join(f"{count} {name}" for name, count in sorted(tries.items()))
    yield f"{sum(tries.values())} tries" + (f": {told}" if told else "")
