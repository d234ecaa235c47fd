"""
Whether what `choose` says of cells holds on fresh draws of the noise.

Drawn cells are those of `plans` in which a plan is possible, each with noise of its own; robot
cells are those of `robot_cells`, whose motion is that of a recording that MuJoCo made. Every
method is tried at every rate as `peg-on-hole choose` does; then once more with other seeds.
Counted is in how many cells what was named is enough again, and in how many what was called too
little is too little again: each of them, but for those within MARGIN of what was asked for.

Of a robot cell what was named also replays the engine's own wrenches, thinned to that rate and
with other noise, against the engine's truth. There gears bend, loads rattle and sensors have
filters and zeros, which `choose` does not simulate: it is told beside, and no promise.
"""

from dataclasses import replace
from pathlib import Path
from time import thread_time
from typing import NamedTuple

import numpy as np

from benchmarks import plans
from benchmarks.harness.draw import Draw
from benchmarks.harness.family import ESTIMATE, Family, Report
from benchmarks.harness.tables import table
from benchmarks.robot_cells import __main__ as bags
from benchmarks.robot_cells import drawn, sensing
from benchmarks.robot_cells.arms import ARMS
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.score import Score
from peg_on_hole_ros.bags.truth import read_truth
from peg_on_hole_ros.cli.choose import FIRST_CHOICE_SEED, all_tried, motion_of
from peg_on_hole_ros.config.options import Configuration, JointInput, MonitorOptions, WrenchInput
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.records import CONTACTS
from peg_on_hole_ros.replay.run import replay_bag
from peg_on_hole_ros.sim.truth import Truth
from peg_on_hole_ros.study.choice import Measured, Seeds, Tolerances, Tried, cheapest, tried
from peg_on_hole_ros.study.motions import planned_motion

FRESH_SEED = 70_000
RATE = 1000
# What is so near to a tolerance may fall on either side of it.
MARGIN = 0.1
# What is asked for: usual, and more than is usual, so that something is named in noisy cells, too.
ASKED = (Tolerances(), Tolerances(0.1, 0.2), Tolerances(0.3, 0.5))
# Told of a cell without a motion.
NONE = "no motion"
# Of a robot cell: noise of the recording whose motion is taken, and of the one replayed after.
FIRST_NOISE, OTHER_NOISE = 1, 2
# Contacts of `robot_cells` without chamfers.
SHARP = ("hard", "damped")


class Numbered(NamedTuple):
    """A cell by the number that it is drawn from; of a robot cell also its arm and contacts."""

    number: int
    seeds: int
    arm: str = ""
    contact: str = ""

    def __str__(self):
        """Return a name for files and tables."""
        robot = f"{self.arm}_{self.contact}_" if self.arm else ""
        return f"{robot}{self.number:03d}"


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
    broken : list of str
        What is otherwise afresh, with its figures before and after.
    seconds : float
        Computing time of all that was tried, without the fresh draws.

    """

    named: str
    kept: bool
    too_little: int
    again: int
    broken: list
    seconds: float = 0.0


class OnEngine(NamedTuple):
    """
    What was named, on the engine's own wrenches.

    Attributes
    ----------
    reactions : float
        Root mean square of the determined reactions' error, over their mean.
    covered : float
        Least share of a reaction within its 95 % bounds.

    """

    reactions: float
    covered: float


def cell_of(number: int) -> Configuration:
    """Return a drawn cell with noise of its own."""
    drawn_cell, draw = plans.cell_of(number), Draw([9_300, number])
    return Configuration(
        scene=drawn_cell.scene,
        plan=drawn_cell.cell,
        monitor=MonitorOptions(max_normal=drawn_cell.max_normal),
        wrench=WrenchInput(
            sensor_xyz=(0.0, 0.0, drawn_cell.cell.grip_height * draw.even(1.0, 2.0)),
            force_stddev=draw.log(0.05, 2.0), torque_stddev=draw.log(0.001, 0.05),
        ),
        joints=JointInput(position_stddev=draw.log(3e-5, 5e-4)),
    )  # fmt: skip


def motion(cell: Numbered, folder: Path) -> Truth:
    """Return the simulated motion of a cell: that of its recording, else the one planned."""
    if not cell.arm:
        return planned_motion(cell_of(cell.number), RATE)
    recording = drawn.recorded(_robot(cell), folder, FIRST_NOISE)
    found = motion_of(Bag(recording.path), recording.configuration)
    recording.path.unlink()
    return found.truth


def _robot(cell):
    return drawn.Cell(cell.arm, cell.contact, cell.number)


def score_member(cell: Numbered, folder: Path) -> dict:
    """Return what was named for a cell and what became of it with fresh seeds."""
    begun = thread_time()
    try:
        truth = motion(cell, folder)
    except PegOnHoleError as error:
        none = {"came": Came(NONE, True, 0, 0, [str(error)]), "engine": None}
        return {"told": [none] * len(ASKED)}
    # What is far off the widest of them is far off each.
    found = all_tried(Measured(truth, Seeds(FIRST_CHOICE_SEED, cell.seeds)), ASKED[-1])
    seconds = thread_time() - begun
    anew = Measured(truth, Seeds(FRESH_SEED, cell.seeds))
    fresh = [
        tried(anew, one.method, round(truth.plan.wrench_rate / one.rate), None, ASKED[-1])
        for one in found
    ]
    told = []
    for within in ASKED:
        chosen, engine = cheapest(found, within), None
        if cell.arm and chosen is not None:
            engine = on_engine(cell, chosen, round(truth.plan.wrench_rate / chosen.rate), folder)
        told.append(
            {"came": came_of(found, fresh, within)._replace(seconds=seconds), "engine": engine}
        )
    return {"told": told}


def on_engine(cell: Numbered, chosen: Tried, every: int, folder: Path) -> OnEngine:
    """Return what becomes of a method on a robot cell's own wrenches, with other noise."""
    path, stated, _ = drawn.recorded(_robot(cell), folder, OTHER_NOISE, every)
    bag = Bag(path)
    told = Score(read_truth(bag))
    given = replace(stated, filter=replace(stated.filter, method=chosen.method))
    replay_bag(bag, given, 0.0, [told])
    path.unlink()
    errors, loads, covered = (
        [figures[name] or np.nan for name in CONTACTS]
        for figures in (told.rmse(), told.mean(), told.coverage95())
    )
    reactions = np.sqrt(np.mean(np.square(errors))) / np.mean(loads)
    return OnEngine(float(reactions), float(np.min(covered)))


def came_of(found: list[Tried], fresh: list[Tried], within: Tolerances = ASKED[0]) -> Came:
    """Return what was named of what was found, and what of it holds afresh."""
    chosen = cheapest(found, within)
    little = [k for k, one in enumerate(found) if not one.enough(within)]
    wrong = [k for k in little if fresh[k].enough(within) and not _near(found[k], within)]
    again = len(little) - len(wrong)
    broken = [_beside(found[k], fresh[k]) for k in wrong]
    if chosen is None:
        return Came("", not wrong, len(little), again, broken)
    after = fresh[found.index(chosen)]
    kept = after.enough(within) or _near(chosen, within)
    name = f"{chosen.method} at {chosen.rate:g} Hz"
    return Came(
        name, kept, len(little), again, broken if kept else [_beside(chosen, after), *broken]
    )


def _near(one, within):
    """Return whether an error, or the flag's, is within MARGIN of what was asked for."""
    # A motion without a transition has no flag to be late: of its NaN nothing is near.
    parts = (
        (one.reactions, within.reactions), (one.tilt_rate, within.tilt_rate),
        (one.flag, within.flag),
    )  # fmt: skip
    return any(abs(error / most - 1.0) < MARGIN for error, most in parts)


def _beside(before, after):
    parts = (
        f"{name} {getattr(before, name):.4g}, afresh {getattr(after, name):.4g}"
        for name in ("reactions", "tilt_rate", "covered", "determined", "flag", "lost")
    )
    return f"{before.method} at {before.rate:g} Hz: {'; '.join(parts)}"


def members(options) -> list[Numbered]:
    """Return the cells asked for."""
    numbers = range(options.first, options.first + options.cells)
    robots = [
        (number, arm, contact)
        for number in range(options.first_robot, options.first_robot + options.robots)
        for contact in SHARP
        for arm in ARMS
    ]
    return [
        *(Numbered(number, options.seeds) for number in numbers),
        *(Numbered(n, options.seeds, arm, c) for n, arm, c in robots[: options.robots]),
    ]


def report(found, options) -> Report:
    """Return what was named, how often, and how often it held."""
    parts = []
    for k, within in enumerate(ASKED):
        told = [(cell, figures["told"][k]) for cell, figures in found]
        rows = [(cell, Came(*one["came"]), one["engine"]) for cell, one in told]
        parts.append(
            f"Reactions within {100 * within.reactions:g} %, the tilt's rate within "
            f"{100 * within.tilt_rate:g} %:"
        )
        for words, own in (
            ("drawn cells", [row for row in rows if not row[0].arm]),
            ("robot cells of another engine", [row for row in rows if row[0].arm]),
        ):
            if own:
                parts.append(_part(words, own))
        broken = [f"- {cell}: {text}" for cell, came, _ in rows for text in came.broken
                  if came.named != NONE]  # fmt: skip
        if broken:
            parts.append("\n".join(["Otherwise afresh:", "", *broken]))
    return Report("\n\n".join(parts))


def _part(words, rows):
    moved = [(cell, came, engine) for cell, came, engine in rows if came.named != NONE]
    cells = [came for _, came, _ in moved]
    names = dict.fromkeys(one.named for one in cells)
    lines = []
    for name in names:
        own = [(came, engine) for _, came, engine in moved if came.named == name]
        told = [OnEngine(*engine) for _, engine in own if engine is not None]
        lines.append(
            (
                name or "nothing is enough", str(len(own)), str(sum(one.kept for one, _ in own)),
                ", ".join(f"{100 * one.reactions:.2g} %" for one in told),
                ", ".join(f"{100 * one.covered:.0f} %" for one in told),
            )
        )  # fmt: skip
    right = sum(one.again == one.too_little for one in cells)
    seconds = [one.seconds for one in cells] or [0.0]
    head = ("named", "cells", "holds afresh")
    engine = ("reactions off on the engine's wrenches", "within 95 % there")
    if not any(line[3] for line in lines):
        engine, lines = (), [line[:3] for line in lines]
    return (
        f"{len(cells)} of {len(rows)} {words} have a motion. What was named holds afresh in "
        f"{sum(one.kept for one in cells)}; all that was called too little is so in {right} "
        f"(of each cell's {np.mean([one.too_little for one in cells] or [0]):.0f} on average). "
        f"A cell takes {np.median(seconds):.0f} s of computing, the longest "
        f"{max(seconds):.0f} s.\n\n{table((*head, *engine), lines)}"
    )


def add_options(parser) -> None:
    """Add which cells."""
    parser.add_argument("--first", type=int, default=0, help="number of the first cell (0)")
    parser.add_argument("--cells", type=int, default=30, help="how many cells (30)")
    parser.add_argument("--robots", type=int, default=10, help="robot cells; needs MuJoCo (10)")
    parser.add_argument(
        "--first-robot", type=int, default=0, help="number of their first draw (0)"
    )


FAMILY = Family(
    members, score_member, report, add_options, seeds=12,
    sources=(plans, bags, sensing, drawn, Path(drawn.__file__).with_name("cell.py")),
    parts=(*ESTIMATE, "study", "cli/choose.py"),
)  # fmt: skip
