"""
Errors over the bound, coverage and sharpness over the published grid of motions and noise.

Each cell is a motion (clearance, friction, speed, kind) at a noise level. `--against` plays the
same samples through another checkout of this repository as well, and prints both side by side.
"""

import random
from functools import cache
from pathlib import Path
from typing import NamedTuple

from benchmarks.grid import cells, score, summary
from benchmarks.grid.cells import FULL, FULL_HELD_OUT, NOISE, QUICK, Motion, truth_of
from benchmarks.grid.score import score_cell
from benchmarks.harness.errors import QUANTITIES
from benchmarks.harness.family import Family, Report
from benchmarks.harness.player import player_of
from peg_on_hole_ros.sim.measure import sensor_wrench

# Standard deviation of what is known of friction; what the estimator starts from is drawn.
SPREAD = 0.05
FIRST_SEED = 140_000
# From a noise seed to one with start errors.
TO_START_SEED = 50_000
# Which of the cells are taken with `--every`, whatever the seeds.
CHOICE = 5


class Cell(NamedTuple):
    """
    A motion at a noise level, and how it is scored.

    Attributes
    ----------
    motion : Motion
    noise : str
        Of NOISE.
    seeds : int
        Noise seeds; a tenth as many, and at least one, with start errors.
    first_seed : int
        Of the noise seeds.
    friction_stddev : float
    checkout : str
        Folder of another checkout; empty: this one.

    """

    motion: Motion
    noise: str
    seeds: int
    first_seed: int = FIRST_SEED
    friction_stddev: float = SPREAD
    checkout: str = ""

    def __str__(self):
        """Return a name for files and tables."""
        return f"{self.motion}_{self.noise}{'_other' if self.checkout else ''}"


@cache
def _truth(motion):
    truth, end = truth_of(motion)
    return truth, end, None if truth is None else sensor_wrench(truth)


def score_member(cell: Cell, folder: Path) -> dict:
    """Return the figures of a cell, and how its truth ended."""
    truth, end, exact = _truth(cell.motion)
    found = {
        "motion": cell.motion._asdict(), "noise": cell.noise, "end": end,
        "duration": 0.0 if truth is None else len(truth.t_ns) * 1e-3,
    }  # fmt: skip
    if truth is None:
        return found
    first = range(cell.first_seed, cell.first_seed + cell.seeds)
    few, begin = max(1, cell.seeds // 10), first.start + TO_START_SEED
    start = range(begin, begin + few)
    player = player_of(cell.checkout)
    return found | score_cell(truth, cell.noise, first, start, exact, cell.friction_stddev, player)


def some(motions, levels, every: int = 1) -> list[tuple[Motion, str]]:
    """Return motions at noise levels, or a share of them that is spread over both."""
    every_one = [(motion, noise) for motion in motions for noise in levels]
    if every == 1:
        return every_one
    chosen = random.Random(CHOICE).sample(range(len(every_one)), len(every_one) // every)
    return [every_one[k] for k in sorted(chosen)]


def members(options) -> list[Cell]:
    """Return the cells asked for."""
    motions = QUICK if options.quick else FULL_HELD_OUT if options.held_out else FULL
    levels = ("nominal",) if options.quick else tuple(NOISE)
    return [
        Cell(*one, _seeds(options), options.first_seed, options.friction_stddev)
        for one in some(motions, levels, options.every)
    ]


def _seeds(options) -> int:
    return options.seeds or (4 if options.quick else 32)


def add_options(parser) -> None:
    """Add what is asked for."""
    parser.add_argument("--seeds", type=int, help="noise seeds a cell (32; quick: 4)")
    parser.add_argument("--first-seed", type=int, default=FIRST_SEED, help="(140000)")
    parser.add_argument("--every", type=int, default=1, help="one cell of so many (1: all)")
    parser.add_argument("--quick", action="store_true", help="12 motions, nominal noise")
    parser.add_argument("--held-out", action="store_true", help="two motions kept from tuning")
    parser.add_argument(
        "--friction-stddev", type=float, default=SPREAD, help="of the start; 0: known (0.05)"
    )


def check(options) -> str:
    """Return what is wrong with options."""
    if _seeds(options) < 2:
        return "--seeds is at least 2: scatter over noise cannot be told from one run"
    return ""


def report(found, options) -> Report:
    """Return the tables of the cells that all checkouts have."""
    of = {
        other: {
            cell._replace(checkout=""): row for cell, row in found if bool(cell.checkout) == other
        }
        for other in (False, True)
    }
    both = [cell for cell in of[False] if not options.against or cell in of[True]]
    this, other = ([rows[cell] for cell in both if cell in rows] for rows in of.values())
    text = summary.summary(this, other or None)
    return Report(text, {"grid": summary.flat_rows(this, QUANTITIES)})


FAMILY = Family(
    members, score_member, report, add_options, check,
    group=lambda cell: cell.motion, sources=(cells, score), against=True,
)  # fmt: skip
