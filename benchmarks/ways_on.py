"""
Follow in simulation what is said beside an alarm, in the drawn cells of `plans.py`, and time it.

The peg closes without turning, and is asked for a way on 0.2 s before that fails. What is said is
then done, with the friction and clearance that hold.
"""

from collections import Counter
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np

from benchmarks import plans
from benchmarks.harness.family import Family, Report
from benchmarks.harness.tables import table
from benchmarks.plans import Numbered, cell_of, foreseen
from peg_on_hole_ros.mechanics.planning.motion import motion_of
from peg_on_hole_ros.mechanics.planning.way_on import way_on

# Before the failure that is foreseen [s].
AHEAD = 0.2


def asked(number: int, seed: int):
    """Return a cell, where it is asked, and at which rates; None where plain closing does."""
    drawn = cell_of(number, seed)
    scene, cell = drawn.true, drawn.cell
    rate = cell.max_closing_rate
    plain = motion_of(
        cell.start_tilt, (0, 0, 0), [((-rate, 0, 0), scene.gamma0)], scene.gamma0,
        cell.max_acceleration,
    )  # fmt: skip
    said, tilt = foreseen(drawn, plain)
    if said == "through":
        return None
    # Before that the peg is not closing yet.
    return drawn, min(tilt + AHEAD * rate, cell.start_tilt - 0.02), rate


def followed(drawn, found, tilt, rate) -> plans.Came:
    """Return what comes of closing to a tilt, and then doing what is said."""
    cell, end = drawn.cell, drawn.true.gamma0
    legs = [((-rate, 0, 0), tilt), (found.motion.stages[-1].rates, end)]
    motion = motion_of(cell.start_tilt, (0, 0, 0), legs, end, cell.max_acceleration)
    # The simulated peg is pushed with the share from the begin.
    pushed = replace(cell, press=tuple(found.share * x for x in cell.press))
    return plans.came_of(drawn._replace(cell=pushed), motion, np.inf)


def score_member(cell: Numbered, folder: Path) -> dict:
    """Return which way on there is, what came of it, and how long it took to find [s]."""
    given = asked(cell.number, cell.seed)
    if given is None:
        return {"kind": "plain closing does", "seconds": {}}
    drawn, tilt, rate = given
    seconds = {}
    # Last by the spread that is stated: that is what is followed.
    for name, stddev in (("known", 0.0), ("uncertain", drawn.scene.clearance_stddev)):
        scene, begin = replace(drawn.scene, clearance_stddev=stddev), perf_counter()
        found = way_on(scene, drawn.cell, drawn.max_normal, tilt, (-rate, 0.0, 0.0))
        seconds[name] = perf_counter() - begin
    if not found.possible:
        return {"kind": "none: lift", "seconds": seconds}
    kind = "another turn" if found.share == 1 else "less push"
    came = followed(drawn, found, tilt, rate)
    kept = came.outcome == "through"
    return {
        "kind": "as it is" if found.goes_on else kind,
        "kept": kept,
        "as_said": bool(kept and came.peak[found.contact] < found.load),
        "seconds": seconds,
    }


def report(found, options) -> Report:
    """Return how often each way on was there and held, and how long it took."""
    counts: Counter = Counter()
    for _, row in found:
        kind = row["kind"]
        counts[kind] += 1
        if "kept" in row:
            counts[f"{kind}: limits kept"] += row["kept"]
            counts[f"{kind}: load as said"] += row["as_said"]
    taken = []
    for name in ("known", "uncertain"):
        seconds = [row["seconds"][name] for _, row in found if row["seconds"]]
        if seconds:
            ms = 1e3 * np.quantile(seconds, (0.5, 0.95, 1))
            taken.append((name, *(f"{each:.0f}" for each in ms)))
    text = table(("way on", "cells"), sorted(counts.items()))
    head = "clearance", "median [ms]", "95 % [ms]", "longest [ms]"
    return Report(f"{text}\n\n{table(head, taken)}")


def add_options(parser) -> None:
    """Add which cells."""
    parser.add_argument("--cells", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)


FAMILY = Family(
    lambda options: [Numbered(number, options.seed) for number in range(options.cells)],
    score_member, report, add_options,
    sources=(plans,), parts=plans.FAMILY.parts,
)  # fmt: skip
