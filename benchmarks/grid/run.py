"""
Hold the estimator to its promises over the published grid of motions, noise and start errors.

    python -m benchmarks.grid.run [--seeds 200] [--quick] [--held-out] [--folder out/grid] [--csv FILE]

Each cell is a motion (clearance, friction, speed, kind) at a noise level; its figures are kept in
the folder as soon as they are there, so that a run which was stopped goes on where it was. Figures
of other sources, seeds or settings are not taken for those asked for.
"""

import argparse
import csv
import os
import sys
from pathlib import Path

from benchmarks.grid.cells import FULL, FULL_HELD_OUT, NOISE, QUICK, SMALLEST, Motion, truth_of
from benchmarks.grid.score import QUANTITIES, score_cell
from benchmarks.grid.summary import flat_rows, summary
from benchmarks.resumable import ESTIMATE, keep, work_through
from benchmarks.resumable import kept as kept_tree
from benchmarks.resumable import sources_key as sources_key_of
from peg_on_hole_ros.simulation.measure import sensor_wrench

HERE = Path(__file__).parent
SPREAD = 0.0
FIRST_SEED = 40_000
FIRST_START_SEED = 90_000


def sources_key() -> str:
    """Return a name for the state of everything that the figures come from."""
    own = ("cells.py", "score.py", "consistency.py")
    return sources_key_of(ESTIMATE, [HERE / name for name in own])


def file_of(folder: Path, motion: Motion, noise: str) -> Path:
    """Return where a cell's figures are kept."""
    return folder / f"{motion}_{noise}.json"


def kept(path: Path, key: str, seeds: int, spread: float):
    """Return a cell's figures if they are those asked for, else None."""
    asked = {"key": key, "seeds_asked": seeds, "friction_stddev": spread}
    return kept_tree(path, asked)


def score_motion(task):
    """Compute and keep the cells of one motion; returns its name and how its truth ended."""
    motion, levels, seeds, start_seeds, folder, key, spread = task
    truth, end = truth_of(motion)
    exact = None if truth is None else sensor_wrench(truth)
    for noise in levels:
        cell = {
            "key": key, "seeds_asked": seeds, "motion": motion._asdict(), "noise": noise,
            "friction_stddev": spread, "end": end,
            "duration": 0.0 if truth is None else len(truth.t_ns) * 1e-3,
        }  # fmt: skip
        if truth is not None:
            first = range(FIRST_SEED, FIRST_SEED + seeds)
            start = range(FIRST_START_SEED, FIRST_START_SEED + start_seeds)
            cell |= score_cell(truth, noise, first, start, exact, spread)
        keep(file_of(folder, motion, noise), cell)
    return str(motion), end


def run(motions, levels, seeds, folder: Path, workers=2, report=print, spread=SPREAD):
    """
    Compute what is missing of the cells and return all of them.

    Parameters
    ----------
    motions : sequence of Motion
    levels : sequence of str
        Of NOISE.
    seeds : int
        Noise seeds a cell; a tenth as many, and at least one, with start errors.
    folder : Path
    workers : int
    report : callable
        Told of the progress.
    spread : float
        Standard deviation of what is known of friction; what the estimator starts from is drawn.

    Returns
    -------
    list of dict
        Figures of each cell.

    """
    folder.mkdir(parents=True, exist_ok=True)
    key, start_seeds = sources_key(), max(1, seeds // 10)
    tasks = []
    for motion in motions:
        paths = {noise: file_of(folder, motion, noise) for noise in levels}
        missing = [n for n, path in paths.items() if kept(path, key, seeds, spread) is None]
        if missing:
            tasks.append((motion, missing, seeds, start_seeds, folder, key, spread))
    report(f"{len(motions)} motions at {len(levels)} noise levels, {len(tasks)} to compute")
    work_through(score_motion, tasks, workers, report)
    return collect(motions, levels, seeds, folder, spread)


def collect(motions, levels, seeds, folder: Path, spread=SPREAD):
    """Return the figures of those cells that are in the folder."""
    key = sources_key()
    cells = [kept(file_of(folder, m, n), key, seeds, spread) for m in motions for n in levels]
    return [cell for cell in cells if cell is not None]


def main(arguments=None):
    """Run the grid, print the summary, write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--seeds", type=int, help="noise seeds a cell (200; quick: 8)")
    parser.add_argument("--quick", action="store_true", help="12 motions, nominal noise")
    parser.add_argument("--held-out", action="store_true", help="two motions kept from tuning")
    parser.add_argument("--folder", type=Path, default=Path("out/grid"), help="(out/grid)")
    parser.add_argument("--csv", type=Path, help="every figure, one row a cell and class")
    parser.add_argument(
        "--friction-stddev", type=float, default=SPREAD, help="of the start; 0: known (0)"
    )
    parser.add_argument("--summary", action="store_true", help="only tell what is there")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args(arguments)
    seeds = options.seeds or (8 if options.quick else 200)
    if seeds < 2:
        parser.error("--seeds is at least 2: scatter over noise cannot be told from one run")
    spread = options.friction_stddev
    motions = QUICK if options.quick else FULL_HELD_OUT if options.held_out else FULL
    levels = ("nominal",) if options.quick else tuple(NOISE)
    if options.summary:
        cells = collect(motions, levels, seeds, options.folder, spread)
        _say(f"{len(cells)} of {len(motions) * len(levels)} cells are there")
    else:
        cells = run(motions, levels, seeds, options.folder, options.workers, _say, spread)
    path = options.csv or options.folder / "grid.csv"
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerows(flat_rows(cells, QUANTITIES))
    text = summary(cells)
    print(text)
    print(f"written: {path}")


def _say(text):
    print(text, file=sys.stderr, flush=True)


__all__ = ["SMALLEST", "main", "run"]

if __name__ == "__main__":
    main()
