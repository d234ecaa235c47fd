"""
Put every fault into every scene, and hold what is said to what has to happen.

    python -m benchmarks.faults.run [--scene NAME...] [--case TEXT] [--page PAGE] --out DIR

Faults go through the stream that node and replay share, without files in between. Ends with 1
where something falls short that is not in short.csv, or no longer does that is.
Figures are kept in DIR, so that a run which was stopped goes on.
"""

import argparse
import os
import sys
from functools import cache
from math import inf
from pathlib import Path

from benchmarks.faults.expected import CASES, CLEAN, Case, shortfalls
from benchmarks.faults.injector import inject
from benchmarks.faults.page import page
from benchmarks.faults.play import play
from benchmarks.faults.scenes import PARTS, WITHIN, scene
from benchmarks.faults.score import score
from benchmarks.faults.short import known
from benchmarks.resumable import ESTIMATE, keep, kept, put_between, sources_key, work_through

HERE = Path(__file__).parent
MARKS = "<!-- faults -->", "<!-- end of faults -->"


@cache
def figures_key() -> str:
    """Return a name for the state of everything that the figures come from."""
    own = [HERE / f"{name}.py" for name in ("injector", "scenes", "play", "score", "expected")]
    return sources_key((*ESTIMATE, "diagnosis", "messages", "ros/diagnostics.py"), own)


@cache
def _said_clean(name, folder):
    recorded = scene(name, folder)
    return play(recorded, recorded.recording)


def figures(name: str, case: Case, folder: Path) -> dict:
    """Return the figures of a case in a scene; `folder` keeps what is simulated."""
    recorded = scene(name, folder)
    clean = said = _said_clean(name, folder)
    begin, end = (0.0, inf) if case.lasts else recorded.part
    if case.fault:
        faulted = inject(
            recorded.recording, case.fault, begin, end, cell=recorded.cell, **case.parameters
        )
        said = play(recorded, faulted)
    return score(recorded, clean, said, begin, end, case.within)._asdict()


def file_of(folder: Path, name: str, case: Case) -> Path:
    """Return where figures are kept."""
    plain = "".join(letter if letter.isalnum() else "_" for letter in case.name)
    return folder / "runs" / f"{name}_{plain}.json"


def compute(task):
    """Compute and keep the figures of a scene's case; returns its name and what fell short."""
    name, case, folder, key = task
    found = figures(name, case, folder)
    keep(file_of(folder, name, case), {"key": key, "figures": found})
    return f"{name}: {case.name}", "done"


def pairs(names, cases) -> list[tuple[str, Case]]:
    """Return each case with the scenes that it is put into."""
    return [
        (name, case) for case in cases for name in names if name not in WITHIN or not case.lasts
    ]


def run(names, cases, folder: Path, workers=1, report=print) -> dict[str, dict[str, dict]]:
    """Compute what is missing; return figures by scene and case, with what fell short."""
    (folder / "runs").mkdir(parents=True, exist_ok=True)
    asked = {"key": figures_key()}
    for name in names:
        scene(name, folder)
    every = pairs(names, cases)
    tasks = [
        (*pair, folder, asked["key"])
        for pair in every
        if kept(file_of(folder, *pair), asked) is None
    ]
    report(f"{len(every)} faults in scenes: {len(tasks)} to compute")
    work_through(compute, tasks, workers, report)
    found = {name: {} for name in names}
    for name, case in every:
        each = kept(file_of(folder, name, case), asked)["figures"]
        found[name][case.name] = {**each, "short": shortfalls(case, each)}
    return found


def surprises(name: str, case: str, short: dict[str, str]) -> list[str]:
    """Return what falls short and is not known to, and what is known to and does not."""
    listed = known(name, case)
    return [f"{name}, {case}: {text}" for kind, text in short.items() if kind not in listed] + [
        f"{name}, {case}: {kind} holds now, and is listed in benchmarks/faults/short.csv"
        for kind in listed
        if kind not in short
    ]


def main(arguments=None) -> int:
    """Run the faults, write the table; return 1 where something surprises."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--scene", nargs="+", choices=list(PARTS), default=list(PARTS))
    parser.add_argument("--case", default="", help="cases whose name holds this text")
    parser.add_argument("--out", type=Path, required=True, help="figures and table")
    parser.add_argument("--page", type=Path, help="renew the table of docs/faults.md")
    parser.add_argument("--workers", type=int, default=min(2, os.cpu_count() or 1))
    options = parser.parse_args(arguments)
    names = options.scene
    chosen = [case for case in (CLEAN, *CASES) if options.case in case.name]
    if not chosen:
        parser.error(f"no case holds {options.case!r}")
    found = run(names, chosen, options.out, options.workers, _say)
    text = page(found, chosen)
    (options.out / "faults.md").write_text(f"{text}\n", encoding="utf-8")
    if options.page:
        put_between(options.page, *MARKS, text)
    lines = [
        line
        for name, cases in found.items()
        for case, each in cases.items()
        for line in surprises(name, case, each["short"])
    ]
    print(text, *lines, sep="\n")
    return 1 if lines else 0


def _say(text):
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
