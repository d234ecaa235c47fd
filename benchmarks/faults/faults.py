"""
Put every fault into every scene, and hold what is said to what has to happen.

Faults go through the stream that node and replay share, without files in between. Ends with 1
where something falls short that is not in short.csv, or no longer does that is.
"""

from functools import cache
from math import inf
from pathlib import Path
from typing import NamedTuple

from benchmarks.faults import expected, injector, scenes
from benchmarks.faults import play as play_
from benchmarks.faults import score as score_
from benchmarks.faults.expected import CASES, CLEAN, Case, shortfalls
from benchmarks.faults.injector import inject
from benchmarks.faults.page import page
from benchmarks.faults.play import play
from benchmarks.faults.scenes import PARTS, WITHIN, scene
from benchmarks.faults.score import score
from benchmarks.faults.short import known
from benchmarks.harness.family import ESTIMATE, Family, Report


class Fault(NamedTuple):
    """A scene, and the case that is put into it."""

    scene: str
    case: Case

    def __str__(self):
        """Return a name for files and tables."""
        return f"{self.scene}: {self.case.name}"


@cache
def _said_clean(name, folder):
    recorded = scene(name, folder)
    return play(recorded, recorded.recording)


def score_member(fault: Fault, folder: Path) -> dict:
    """Return the figures of a case in a scene; `folder` keeps what is simulated."""
    name, case = fault
    recorded = scene(name, folder)
    clean = said = _said_clean(name, folder)
    begin, end = (0.0, inf) if case.lasts else recorded.part
    if case.fault:
        faulted = inject(
            recorded.recording, case.fault, begin, end, cell=recorded.cell, **case.parameters
        )
        said = play(recorded, faulted)
    return score(recorded, clean, said, begin, end, case.within)._asdict()


def pairs(names, cases) -> list[Fault]:
    """Return each case with the scenes that it is put into."""
    return [
        Fault(name, case)
        for case in cases
        for name in names
        if name not in WITHIN or not case.lasts
    ]


def surprises(name: str, case: str, short: dict[str, str]) -> list[str]:
    """Return what falls short and is not known to, and what is known to and does not."""
    listed = known(name, case)
    return [f"{name}, {case}: {text}" for kind, text in short.items() if kind not in listed] + [
        f"{name}, {case}: {kind} holds now, and is listed in benchmarks/faults/short.csv"
        for kind in listed
        if kind not in short
    ]


def report(found, options) -> Report:
    """Return the table, and what surprises."""
    there = {name for (name, _), _ in found}
    rows: dict[str, dict] = {name: {} for name in PARTS if name in there}
    for (name, case), figures in found:
        rows[name][case.name] = {**figures, "short": shortfalls(case, figures)}
    cases = list({case.name: case for (_, case), _ in found}.values())
    lines = [
        line
        for name, of in rows.items()
        for case, each in of.items()
        for line in surprises(name, case, each["short"])
    ]
    return Report(page(rows, cases), problems=lines)


FAMILY = Family(
    lambda options: pairs(PARTS, (CLEAN, *CASES)), score_member, report,
    sources=(expected, injector, play_, scenes, score_),
    parts=(*ESTIMATE, "diagnosis", "messages", "ros/diagnostics.py"),
)  # fmt: skip
