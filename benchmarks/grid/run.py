"""
Hold the estimator to its promises over the published grid of motions, noise and start errors.

    python -m benchmarks.grid.run [--seeds 32] [--first-seed 140000] [--every 3] [--quick]
        [--held-out] [--against CHECKOUT] [--folder out/grid] [--csv FILE] [--page docs/grid.md]

Each cell is a motion (clearance, friction, speed, kind) at a noise level; its figures are kept in
the folder as soon as they are there, so that a run which was stopped goes on where it was. Figures
of other sources, seeds or settings are not taken for those asked for. `--against` plays the same
samples through another checkout of this repository as well, and prints both side by side.
"""

import argparse
import csv
import os
import random
import sys
from functools import cache, partial
from pathlib import Path

from benchmarks.grid.cells import (
    FULL,
    FULL_HELD_OUT,
    NOISE,
    QUICK,
    SMALLEST,
    Motion,
    truth_of,
)
from benchmarks.grid.player import Elsewhere, play
from benchmarks.grid.score import QUANTITIES, score_cell
from benchmarks.grid.summary import flat_rows, summary
from benchmarks.resumable import (
    ESTIMATE,
    PACKAGE,
    keep,
    put_between,
    sources_key,
    work_through,
)
from benchmarks.resumable import kept as kept_tree
from peg_on_hole_ros.sim.measure import sensor_wrench

HERE = Path(__file__).parent
OWN = [HERE / name for name in ("cells.py", "score.py", "player.py", "consistency.py")]
SPREAD = 0.05
FIRST_SEED = 140_000
# From a noise seed to one with start errors.
TO_START_SEED = 50_000
# Which of the cells are taken with `--every`, whatever the seeds.
CHOICE = 5
MARKS = "<!-- tables -->", "<!-- end of tables -->"


class Asked:
    """
    What figures are asked for, and of which checkout.

    Parameters
    ----------
    folder : Path
        Where they are kept.
    seeds : int
        Noise seeds a cell; a tenth as many, and at least one, with start errors.
    spread : float
        Standard deviation of what is known of friction; what the estimator starts from is drawn.
    checkout : Path or None
        Another than this one.
    first : int
        Of the noise seeds.

    """

    def __init__(
        self,
        folder: Path,
        seeds: int,
        spread: float = SPREAD,
        checkout: Path | None = None,
        first: int = FIRST_SEED,
    ):
        self.folder, self.seeds, self.spread, self.checkout = folder, seeds, spread, checkout
        self.first = first
        package = checkout / PACKAGE.name if checkout else PACKAGE
        self.key = sources_key(ESTIMATE, OWN, package)

    def file(self, motion: Motion, noise: str) -> Path:
        """Return where a cell's figures are kept."""
        return self.folder / f"{motion}_{noise}_{self.key[:8]}.json"

    def kept(self, motion: Motion, noise: str):
        """Return a cell's figures if they are those asked for, else None."""
        asked = {"key": self.key, "seeds_asked": self.seeds, "friction_stddev": self.spread}
        asked["first_seed"] = self.first
        return kept_tree(self.file(motion, noise), asked)

    def score(self, motion: Motion, noise: str, truth, end: str, exact) -> None:
        """Compute and keep the figures of a cell."""
        cell = {
            "key": self.key, "seeds_asked": self.seeds, "first_seed": self.first,
            "motion": motion._asdict(),
            "noise": noise, "friction_stddev": self.spread, "end": end,
            "duration": 0.0 if truth is None else len(truth.t_ns) * 1e-3,
        }  # fmt: skip
        if truth is not None:
            few = max(1, self.seeds // 10)
            first = range(self.first, self.first + self.seeds)
            start = range(first.start + TO_START_SEED, first.start + TO_START_SEED + few)
            player = _elsewhere(self.checkout).play if self.checkout else play
            cell |= score_cell(truth, noise, first, start, exact, self.spread, player)
        keep(self.file(motion, noise), cell)


# One process of another checkout for each of this one's.
_elsewhere = cache(Elsewhere)


def cells_of(motions, levels, every: int = 1) -> list[tuple[Motion, str]]:
    """Return the cells, or a share of them that is spread over motions and noise."""
    cells = [(motion, noise) for motion in motions for noise in levels]
    if every == 1:
        return cells
    chosen = random.Random(CHOICE).sample(range(len(cells)), len(cells) // every)
    return [cells[k] for k in sorted(chosen)]


def score_motion(task):
    """Compute and keep cells of one motion; returns its name and how its truth ended."""
    motion, missing = task
    truth, end = truth_of(motion)
    exact = None if truth is None else sensor_wrench(truth)
    for noise, asked in missing:
        asked.score(motion, noise, truth, end, exact)
    return str(motion), end


def run(cells, asked: list[Asked], workers: int = 2, report=print) -> list[list[dict]]:
    """Compute what is missing of the cells; return all of them, for each of what is asked."""
    tasks: dict[Motion, list] = {}
    for motion, noise in cells:
        for one in asked:
            one.folder.mkdir(parents=True, exist_ok=True)
            if one.kept(motion, noise) is None:
                tasks.setdefault(motion, []).append((noise, one))
    report(f"{len(cells)} cells, {sum(map(len, tasks.values()))} to compute")
    work_through(score_motion, list(tasks.items()), workers, report)
    return collect(cells, asked)


def collect(cells, asked: list[Asked]) -> list[list[dict]]:
    """Return the figures of those cells that all of what is asked has."""
    found = [[one.kept(*cell) for one in asked] for cell in cells]
    return [list(column) for column in zip(*(row for row in found if None not in row))]


def main(arguments=None):
    """Run the grid, print the summary, write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--seeds", type=int, help="noise seeds a cell (32; quick: 4)")
    parser.add_argument("--first-seed", type=int, default=FIRST_SEED, help="(140000)")
    parser.add_argument("--every", type=int, default=1, help="one cell of so many (1: all)")
    parser.add_argument("--quick", action="store_true", help="12 motions, nominal noise")
    parser.add_argument("--held-out", action="store_true", help="two motions kept from tuning")
    parser.add_argument("--against", type=Path, help="another checkout, for the same samples")
    parser.add_argument("--folder", type=Path, default=Path("out/grid"), help="(out/grid)")
    parser.add_argument("--csv", type=Path, help="every figure, one row a cell and class")
    parser.add_argument("--page", type=Path, help="page whose tables are renewed")
    parser.add_argument(
        "--friction-stddev", type=float, default=SPREAD, help="of the start; 0: known (0.05)"
    )
    parser.add_argument("--summary", action="store_true", help="only tell what is there")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args(arguments)
    seeds = options.seeds or (4 if options.quick else 32)
    if seeds < 2:
        parser.error("--seeds is at least 2: scatter over noise cannot be told from one run")
    if options.against and not (options.against / PACKAGE.name).is_dir():
        parser.error(f"--against {options.against}: no folder {PACKAGE.name} there")
    motions = QUICK if options.quick else FULL_HELD_OUT if options.held_out else FULL
    cells = cells_of(motions, ("nominal",) if options.quick else tuple(NOISE), options.every)
    of = partial(Asked, options.folder, seeds, options.friction_stddev, first=options.first_seed)
    asked = [of()] + ([of(checkout=options.against)] if options.against else [])
    found = collect(cells, asked) if options.summary else run(cells, asked, options.workers, _say)
    if not found:
        parser.error(
            f"--summary: no cell in {options.folder} is of these sources and {seeds} seeds"
        )
    _say(f"{len(found[0])} of {len(cells)} cells are there")
    path = options.csv or options.folder / "grid.csv"
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        csv.writer(file).writerows(flat_rows(found[0], QUANTITIES))
    text = summary(*found)
    print(text)
    print(f"written: {path}")
    if options.page:
        put_between(options.page, *MARKS, text)


def _say(text):
    print(text, file=sys.stderr, flush=True)


__all__ = ["SMALLEST", "main", "run"]

if __name__ == "__main__":
    main()
