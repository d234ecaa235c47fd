"""
What each rule of the filter earns: the grid once more for each, with that one switched off.

    python benchmarks/rules_off.py [--rules kink rivals ...] [--seeds 4] [--quick]
        [--folder out/rules_off]

A rule is switched off in a copy of the package, by changed lines of its sources, and the copy
compiles anew. All cells of the grid, friction uncertain by 0.05 and learnt, noise seeds that are
not the grid's, the same for all; so what differs is the rule's doing, but for runs that only just
go one way or another. Some six minutes a rule, two at a time; `--quick` (12 motions, nominal
noise) two. What a rule does beyond the grid
(settings that are wrong, contacts that give, other rates) does not show.
"""

import argparse
import multiprocessing
import os
import pickle
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np

import peg_on_hole_ros
from grid_cells import FULL, NOISE, QUICK, Motion, truth_of
from grid_score import score_cell
from grid_summary import verdicts
from peg_on_hole_ros.simulation.measure import sensor_wrench
from resumable import ESTIMATE, keep, kept, sources_key, work_through
from rules import RULES

HERE = Path(__file__).parent
SOURCES = [
    HERE / name for name in ("grid_cells.py", "grid_score.py", "consistency.py", "rules.py")
]
FIRST_SEED, START_SEED = 50_000, 95_000
SPREAD = 0.05
# Heads of columns, and which of `verdicts` they add up.
PROMISES = {
    "cells near the bound: states; reactions": ((0, 1), (2, 3)),
    "covered: states; reactions": ((7,), (4,)),
    "in windows: states; reactions": ((9,), (6,)),
    "NIS; NEES": ((10,), (11,)),
}
ERRORS = {"rates": slice(3, 6), "reactions": slice(6, 9)}


def copy_without(rule: str, folder: Path) -> None:
    """Copy package and benchmarks into a folder, a rule of RULES switched off."""
    package = Path(peg_on_hole_ros.__file__).parent
    shutil.rmtree(folder, ignore_errors=True)
    for source in (package, HERE):
        skipped = shutil.ignore_patterns("__pycache__", "data", "out")
        shutil.copytree(source, folder / source.name, ignore=skipped)
    if RULES[rule].file:
        path = folder / package.name / RULES[rule].file
        path.write_text(switched_off(path.read_text(), RULES[rule]))


def switched_off(text: str, rule) -> str:
    """Return a source without a rule; ValueError where what it has is not there just once."""
    if text.count(rule.was) != 1:
        raise ValueError(f"{rule.file} has {text.count(rule.was)} times: {rule.was!r}")
    return text.replace(rule.was, rule.becomes)


def measure(truths: Path, out: Path, seeds: int, levels, asked: dict) -> None:
    """Score cells at noise levels with the package that is imported, and keep them."""
    cells = []
    # Written by this script's own run.
    for motion, truth in pickle.loads(truths.read_bytes()).items():
        if truth is None:
            continue
        exact = sensor_wrench(truth)
        for noise in levels:
            scored = score_cell(
                truth, noise, range(FIRST_SEED, FIRST_SEED + seeds),
                range(START_SEED, START_SEED + 1), exact, SPREAD,
            )  # fmt: skip
            cells.append({"motion": Motion(*motion)._asdict(), "noise": noise, "end": ""} | scored)
    keep(out, asked | {"cells": cells})


def measured(task):
    """Measure without a rule, in a process of its own; returns its name and what became of it."""
    rule, folder, asked = task
    copy, log = folder / f"without_{rule}", folder / f"{rule}.log"
    copy_without(rule, copy)
    command = [
        sys.executable, copy / HERE.name / Path(__file__).name, "--measure", rule,
        "--seeds", str(asked["seeds"]), "--folder", folder, "--key", asked["key"],
    ]  # fmt: skip
    command += ["--quick"] * asked["quick"]
    own = {"PYTHONPATH": str(copy), "NUMBA_CACHE_DIR": str(copy / "numba")}
    with log.open("w") as file:
        done = subprocess.run(command, env=os.environ | own, stdout=file, stderr=file)
    shutil.rmtree(copy)
    return rule, "done" if done.returncode == 0 else f"failed, see {log}"


def row(cells, base) -> list[str]:
    """Return what a rule's cells keep of PROMISES, and how their errors are to those of all."""
    kept_of = [entry["kept"] for entry in verdicts(cells)]
    shown = [
        "; ".join(str(sum(kept_of[i] for i in places)) for places in both)
        for both in PROMISES.values()
    ]
    for part in ERRORS.values():
        of_kinds = (_ratios(cells, base, kind, part) for kind in ("outside", "window"))
        shown.append("; ".join(_spread(ratios) for ratios in of_kinds if ratios))
    return shown


def _ratios(cells, base, kind, part):
    """Return each cell's errors over those of all rules, where it has samples of the kind."""
    found = []
    for cell, other in zip(cells, base, strict=True):
        own, of_all = (c["classes"].get(kind) for c in (cell, other))
        if own and of_all:
            ratio = np.array(own["rms"])[part] / np.array(of_all["rms"])[part]
            found.append(np.exp(np.log(ratio).mean()))
    return found


def _spread(ratios):
    mean = np.exp(np.mean(np.log(ratios)))
    return f"{mean:.2f} ({min(ratios):.2g} to {max(ratios):.2g})"


def table(found: dict) -> list[str]:
    """Return the rules' rows as a table; found: cells of each rule, `all` among them."""
    heads = [*PROMISES, *(f"errors of {name}: outside; in windows" for name in ERRORS)]
    lines = [f"| without | {' | '.join(heads)} |", "|---" * (len(heads) + 1) + "|"]
    for rule, cells in found.items():
        lines.append(f"| {rule}: {RULES[rule].does} | {' | '.join(row(cells, found['all']))} |")
    return lines


def _truth(motion):
    return truth_of(motion)[0]


def _integrate(path: Path, motions, workers: int) -> None:
    """Keep the truths of motions in a file, once."""
    if not path.exists():
        print("integrating the truths of the grid", file=sys.stderr, flush=True)
        with multiprocessing.get_context("spawn").Pool(workers) as pool:
            truths = pool.map(_truth, motions, chunksize=1)
        path.write_bytes(pickle.dumps(dict(zip(map(tuple, motions), truths, strict=True))))


def main(arguments=None):
    """Measure what is missing, print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--rules", nargs="+", choices=list(RULES), default=list(RULES))
    parser.add_argument("--seeds", type=int, default=4, help="noise seeds a cell (4)")
    parser.add_argument("--quick", action="store_true", help="12 motions, nominal noise")
    parser.add_argument("--folder", type=Path, default=Path("out/rules_off"))
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--measure", choices=list(RULES), help=argparse.SUPPRESS)
    parser.add_argument("--key", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.seeds < 2:
        parser.error("--seeds is at least 2: scatter over noise cannot be told from one run")
    folder = options.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    key = options.key or sources_key(ESTIMATE, SOURCES)
    asked = {"key": key, "seeds": options.seeds, "quick": options.quick}
    motions, levels = (QUICK, ("nominal",)) if options.quick else (FULL, tuple(NOISE))
    truths = folder / f"truths_{key}{'_quick' * options.quick}.pickle"
    _integrate(truths, motions, options.workers)
    if options.measure:
        out = folder / f"{options.measure}.json"
        measure(truths, out, options.seeds, levels, asked)
        return
    rules = list(dict.fromkeys(["all", *options.rules]))
    tasks = [
        (rule, folder, asked) for rule in rules if kept(folder / f"{rule}.json", asked) is None
    ]
    work_through(measured, tasks, options.workers, partial(print, file=sys.stderr, flush=True))
    trees = {rule: kept(folder / f"{rule}.json", asked) for rule in rules}
    found = {rule: tree["cells"] for rule, tree in trees.items() if tree}
    if "all" not in found:
        sys.exit(f"there is nothing to compare with: see {folder / 'all.log'}")
    print("\n".join(table(found)))


if __name__ == "__main__":
    main()
