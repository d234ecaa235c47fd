"""
Settings that are wrong in drawn cells of one's own: whether the cause is named first.

A cell is an arm with a wrist as a description, whose base is turned or stands on `world`, a tool
that is turned, a hole that leans, and a sensor with a zero and a payload, in the axes of the base
or its own. The simulator has it go through a cycle, and `replay` is given what it would send, as
it is and with one thing wrong. `named`: the first line about a cause names it, with its number
where it has one; `withheld`: reactions are not told; `refused`: the exit code is another than 0,
and the error names it; `sure`: reactions are told, and less than `COVERED` of them lie within
their bounds. What has to come out is named, withheld or refused, with the right exit code; of
right settings, nothing.
"""

import io
import json
import re
from argparse import Namespace
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from pathlib import Path
from typing import NamedTuple

from benchmarks.harness.family import ESTIMATE, Family, Member, Report
from benchmarks.harness.tables import table
from benchmarks.own_cells import arms, cells, wrong
from benchmarks.own_cells.cells import drawn_cell, write, write_parameters
from benchmarks.own_cells.wrong import WRONG, names
from peg_on_hole_ros.cli.main import main

RIGHT = "right"
CELLS = 6
# Share of reactions within bounds of 95 % below which they are wrong and sure.
COVERED = 0.85
# What begins a line that names a cause.
CAUSE = re.compile(r"^(wrench|joints|scene)[.:]|^peg-on-hole: error|^\d+ of \d+ messages")


class Said(NamedTuple):
    """
    What `replay` said.

    Attributes
    ----------
    exit_code : int
    causes : list of str
        Lines about causes, in their order.
    withheld : bool
    covered : float or None
        Least share of K, B1, B2 within their bounds; None: none is told.
    alarms : int
        Alarms of level ERROR.

    """

    exit_code: int
    causes: list[str]
    withheld: bool
    covered: float | None
    alarms: int


def said_of(bag: Path, parameters: Path) -> Said:
    """Return what `replay` says of a bag by a parameters file."""
    summary = bag.with_suffix(".json")
    summary.unlink(missing_ok=True)
    out, errors = io.StringIO(), io.StringIO()
    arguments = ["replay", str(bag), "--config", str(parameters), "--summary", str(summary)]
    with redirect_stdout(out), redirect_stderr(errors):
        code = main(arguments)
    lines = [*out.getvalue().splitlines(), *errors.getvalue().splitlines()]
    causes = [line for line in lines if CAUSE.match(line)]
    if not summary.exists():
        return Said(code, causes, False, None, 0)
    told = json.loads(summary.read_text())
    shares = [told.get("coverage95", {}).get(name) for name in ("K", "B1", "B2")]
    known = [share for share in shares if share is not None]
    alarms = sum(alarm["level"] == "ERROR" for alarm in told["alarms"])
    return Said(code, causes, bool(told["reactions_void"]), min(known, default=None), alarms)


@cache
def _cell(number: int, folder: Path):
    return drawn_cell(number, folder)


def members(options: Namespace) -> list[Member]:
    """Return every cell with everything that may be wrong, and right."""
    return [
        Member(f"{number}_{kind}", (number, kind))
        for number in range(options.first, options.first + options.cells)
        for kind in (RIGHT, *WRONG)
    ]


def score(member: Member, folder: Path) -> dict:
    """Return what came of one thing that is wrong."""
    number, kind = member.of
    place = folder / f"cell_{number}"
    place.mkdir(parents=True, exist_ok=True)
    right = _cell(number, place)
    cell = right if kind == RIGHT else WRONG[kind].change(right)
    bag, parameters = place / f"{kind}.mcap", place / f"{kind}.yaml"
    write(bag, cell)
    write_parameters(parameters, cell)
    said = said_of(bag, parameters)
    bag.unlink()
    return {"outcome": outcome(kind, right, said), **said._asdict()}


def outcome(kind: str, right: cells.Cell, said: Said) -> str:
    """Return in a word what came out: first what has to, then what may not."""
    if kind == RIGHT:
        return "false cause" if said.causes or said.withheld else "quiet"
    it = WRONG[kind]
    by = [names(it, right, line) for line in said.causes]
    if said.exit_code not in it.exits:
        return "exit code"
    if by and by[0]:
        return "named" if said.exit_code == 0 else "refused"
    if said.withheld:
        return "withheld"
    if said.causes and not any(by):
        return "false cause"
    if said.covered is not None and said.covered < COVERED:
        return "sure"
    return "untold" if it.must else "harmless"


RIGHTLY = ("named", "refused", "withheld", "harmless", "quiet")


def report(found: list, options: Namespace) -> Report:
    """Return a table of kinds by cells, and how many came out as they have to."""
    by: dict[str, dict[int, str]] = {}
    for member, figures in found:
        number, kind = member.of
        by.setdefault(kind, {})[number] = figures["outcome"]
    numbers = sorted({number for row in by.values() for number in row})
    rows = [(kind, *(row.get(number, "") for number in numbers)) for kind, row in by.items()]
    counts = []
    for number in numbers:
        outcomes = [row[number] for kind, row in by.items() if number in row and kind != RIGHT]
        counts.append(f"{sum(each in RIGHTLY for each in outcomes)} of {len(outcomes)}")
    rows.append(("as it has to", *counts))
    return Report(table(("", *(f"cell {number}" for number in numbers)), rows))


def add_options(parser) -> None:
    """Add which cells are drawn."""
    parser.add_argument("--cells", type=int, default=CELLS, help=f"how many ({CELLS})")
    parser.add_argument("--first", type=int, default=0, help="number of the first (0)")


FAMILY = Family(
    members, score, report, add_options, group=lambda member: member.of[0],
    sources=(arms, cells, wrong),
    parts=(*ESTIMATE, "cli", "replay", "robot", "messages", "bags"),
)  # fmt: skip
