"""
Whether what `choose` says of drawn cells holds on fresh draws of the noise.

Cells are those of `plans` in which a plan is possible, each with noise of its own. Every method
is tried at every rate as `peg-on-hole choose` does; then once more with other seeds. Counted is
in how many cells what was named is enough again, and in how many what was called too little is
too little again: each of them, but for those within MARGIN of what was asked for.
"""

from pathlib import Path
from time import thread_time
from typing import NamedTuple

import numpy as np

from benchmarks import plans
from benchmarks.harness.draw import Draw
from benchmarks.harness.family import ESTIMATE, Family, Report
from benchmarks.harness.tables import table
from peg_on_hole_ros.cli.choose import COMPARED, FIRST_CHOICE_SEED
from peg_on_hole_ros.config.options import Configuration, JointInput, MonitorOptions, WrenchInput
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.study.choice import THINNED, Seeds, Tolerances, Tried, cheapest, tried
from peg_on_hole_ros.study.motions import planned_motion

FRESH_SEED = 70_000
RATE = 1000
# What is so near to a tolerance may fall on either side of it.
MARGIN = 0.1
WITHIN = Tolerances()
# Told of a cell without a motion.
NONE = "no motion"


class Numbered(NamedTuple):
    """A cell by the number that it is drawn from."""

    number: int
    seeds: int

    def __str__(self):
        """Return a name for files and tables."""
        return f"{self.number:03d}"


class Came(NamedTuple):
    """
    What was named for a cell, and whether it holds.

    Attributes
    ----------
    named : str
        Method and rate; empty: nothing is enough; NONE: there is no motion.
    kept : bool
        What was named is enough again; where nothing was, nothing is.
    too_little, again : int
        How many were called too little, and of these too little again.

    """

    named: str
    kept: bool
    too_little: int
    again: int


def cell_of(number: int) -> Configuration:
    """Return a drawn cell with noise of its own."""
    drawn, draw = plans.cell_of(number), Draw([9_300, number])
    return Configuration(
        scene=drawn.scene,
        plan=drawn.cell,
        monitor=MonitorOptions(max_normal=drawn.max_normal),
        wrench=WrenchInput(
            sensor_xyz=(0.0, 0.0, drawn.cell.grip_height * draw.even(1.0, 2.0)),
            force_stddev=draw.log(0.05, 2.0), torque_stddev=draw.log(0.001, 0.05),
        ),
        joints=JointInput(position_stddev=draw.log(3e-5, 5e-4)),
    )  # fmt: skip


def score_member(cell: Numbered, folder: Path) -> Came:
    """Return what was named for a cell and what became of it with fresh seeds."""
    try:
        truth = planned_motion(cell_of(cell.number), RATE)
    except PegOnHoleError:
        return Came(NONE, True, 0, 0)
    both = [
        [
            tried(truth, method, every, Seeds(first, cell.seeds), thread_time)
            for every in THINNED
            for method in COMPARED
        ]
        for first in (FIRST_CHOICE_SEED, FRESH_SEED)
    ]
    return came_of(*both)


def came_of(found: list[Tried], fresh: list[Tried]) -> Came:
    """Return what was named of what was found, and what of it holds afresh."""
    chosen = cheapest(found, WITHIN)
    little = [k for k, one in enumerate(found) if not one.enough(WITHIN)]
    again = sum(not fresh[k].enough(WITHIN) or _near(found[k]) for k in little)
    if chosen is None:
        return Came("", again == len(little), len(little), again)
    kept = fresh[found.index(chosen)].enough(WITHIN) or _near(chosen)
    return Came(f"{chosen.method} at {chosen.rate:g} Hz", kept, len(little), again)


def _near(one):
    """Return whether an error is within MARGIN of what was asked for."""
    parts = ((one.reactions, WITHIN.reactions), (one.tilt_rate, WITHIN.tilt_rate))
    return any(abs(error / most - 1.0) < MARGIN for error, most in parts)


def members(options) -> list[Numbered]:
    """Return the cells asked for."""
    return [
        Numbered(number, options.seeds)
        for number in range(options.first, options.first + options.cells)
    ]


def report(found, options) -> Report:
    """Return what was named, how often, and how often it held."""
    all_cells = [Came(*row) for _, row in found]
    cells = [one for one in all_cells if one.named != NONE]
    names = dict.fromkeys(one.named for one in cells)
    lines = [
        (name or "nothing is enough", str(len(own)), str(sum(one.kept for one in own)))
        for name in names
        for own in [[one for one in cells if one.named == name]]
    ]
    right = sum(one.again == one.too_little for one in cells)
    text = (
        f"{len(cells)} of {len(all_cells)} cells have a motion. What was named holds afresh in "
        f"{sum(one.kept for one in cells)}; all that was called too little is so in {right} "
        f"(of each cell's {np.mean([one.too_little for one in cells] or [0]):.0f} on average)."
    )
    return Report(f"{text}\n\n{table(('named', 'cells', 'holds afresh'), lines)}")


def add_options(parser) -> None:
    """Add which cells."""
    parser.add_argument("--first", type=int, default=0, help="number of the first cell (0)")
    parser.add_argument("--cells", type=int, default=30, help="how many cells (30)")


FAMILY = Family(
    members, score_member, report, add_options, seeds=12, sources=(plans,),
    parts=(*ESTIMATE, "study", "cli/choose.py"),
)  # fmt: skip
