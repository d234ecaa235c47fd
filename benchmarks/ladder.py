"""
Hold `auto` to its tolerance in random scenes, and to the cost of the cheapest rung that would do.

    python benchmarks/ladder.py [--scenes 1000] [--seed 11] [--folder out/ladder] [--figure PNG]

Truth is the full model, its motion integrated until its reactions agree. Figures are kept in the
folder as soon as they are there: a run that was stopped goes on where it was. The same seed gives
the same scenes, errors and choices; costs are measured, the least of five, every rung in turn.
"""

import argparse
import csv
import os
import sys
from pathlib import Path

import numpy as np
from peg_on_hole_ros.ladder.rungs import DYNAMIC, RUNGS

from ladder_run import score
from resumable import keep, kept, sources_key, work_through

HERE = Path(__file__).parent
SEED = 11
# Scenes to a file.
CHUNK = 20
LEVELS = {"model_us": "the models alone", "step_us": "the filter's step"}
# Of auto against the cheapest rung that would have done.
COST_LIMIT = 1.3


def key() -> str:
    """Return a name for the state of everything that the figures come from."""
    own = [HERE / name for name in ("ladder_run.py", "ladder_scenes.py")]
    truths = "study/steps.py", "study/problems.py"
    return sources_key(("options.py", "mechanics", "ladder", "estimation", *truths), own)


def chunk(task):
    """Compute and keep some scenes; returns their name and what became of them."""
    seed, indices, path, state = task
    rows = [score((seed, index)) for index in indices]
    keep(path, {"key": state, "indices": indices, "rows": rows})
    met = sum(row["auto"] <= row["tolerance"] for row in rows)
    return f"scenes {indices[0]} to {indices[-1]}", f"auto within tolerance in {met}"


def run(scenes: int, seed: int, folder: Path, workers: int, report) -> list[dict]:
    """Compute what is missing and return the figures of all scenes."""
    folder.mkdir(parents=True, exist_ok=True)
    state = key()
    parts = [list(range(i, min(i + CHUNK, scenes))) for i in range(0, scenes, CHUNK)]
    files = [(part, folder / f"{seed}_{part[0]:05d}.json") for part in parts]
    missing = [
        (seed, part, path, state)
        for part, path in files
        if kept(path, {"key": state, "indices": part}) is None
    ]
    report(f"{scenes} scenes, {sum(len(task[1]) for task in missing)} to compute")
    work_through(chunk, missing, workers, report)
    return [
        row for part, path in files for row in kept(path, {"key": state, "indices": part})["rows"]
    ]


def cheapest(row: dict, level: str) -> int | None:
    """Return the rung of least cost that keeps to the tolerance over the whole scene, or None."""
    costs = row[level]
    enough = [rung for rung in range(len(costs) - 1) if row["errors"][rung] <= row["tolerance"]]
    return min(enough, key=lambda rung: costs[rung]) if enough else None


def ratios(rows: list[dict], level: str) -> np.ndarray:
    """Return costs of auto and of the cheapest rung that would do, a scene a row [us a sample]."""
    pairs = []
    for row in rows:
        if row[level] is None:
            continue
        rung = cheapest(row, level)
        if rung is not None:
            pairs.append((row[level][-1], row[level][rung]))
    return np.array(pairs).reshape(-1, 2)


def summary(rows: list[dict]) -> str:
    """Return the page of figures."""
    lines, met = [], [row["auto"] <= row["tolerance"] for row in rows]
    redrawn = sum(row["redrawn"] for row in rows)
    lines.append(
        f"{len(rows)} scenes ({redrawn} draws had no motion), "
        f"{sum(row['samples'] for row in rows)} samples"
    )
    lines.append(f"auto within its tolerance: {sum(met)} of {len(rows)} ({np.mean(met):.1%})")
    for row, good in zip(rows, met):
        if not good:
            lines.append(
                f"  not in scene {row['index']} ({row['kind']}): {row['auto']:.2%} of "
                f"{row['tolerance']:.0%} allowed"
            )
    for level, name in LEVELS.items():
        pairs = ratios(rows, level)
        if not len(pairs):
            lines.append(f"cost, {name}: no scene has one")
            continue
        ratio = pairs[:, 0] / pairs[:, 1]
        full = [row[level][DYNAMIC] for row in rows if row[level] is not None]
        lines.append(
            f"cost, {name}: auto {pairs[:, 0].mean():.3f} us, cheapest that would do "
            f"{pairs[:, 1].mean():.3f} us, ratio {pairs[:, 0].sum() / pairs[:, 1].sum():.3f} "
            f"(limit {COST_LIMIT}); by scene: median {np.median(ratio):.2f}, "
            f"{np.mean(ratio <= COST_LIMIT):.0%} within the limit, 95th percentile "
            f"{np.quantile(ratio, 0.95):.2f}; always dynamic {np.mean(full):.3f} us"
        )
    lines += _table(rows)
    samples = sum(row["samples"] for row in rows)
    lines.append(
        f"decisions: one in {samples / sum(row['decisions'] for row in rows):.1f} samples; "
        f"changes of rung: {sum(row['changes'] for row in rows)}, in "
        f"{np.mean([row['changes'] > 1 for row in rows]):.0%} of the scenes more than one"
    )
    return "\n".join(lines)


def _table(rows):
    used, total = np.sum([row["used"] for row in rows], axis=0), sum(r["samples"] for r in rows)
    steps = [row["step_us"] for row in rows if row["step_us"] is not None]
    lines = ["", "| rung | us, model | us, step | would do | cheapest, model | cheapest, step "
             "| used by auto |", "|---|---|---|---|---|---|---|"]  # fmt: skip
    best = {level: [cheapest(row, level) for row in rows if row[level]] for level in LEVELS}
    for rung, name in enumerate(RUNGS):
        step = f"{np.median([s[rung] for s in steps]):.2f}" if rung <= DYNAMIC else "as dynamic"
        do = np.mean([row["errors"][rung] <= row["tolerance"] for row in rows])
        parts = [f"{np.mean([b == rung for b in best[level]]):.1%}" for level in LEVELS]
        lines.append(
            f"| `{name}` | {np.median([row['model_us'][rung] for row in rows]):.3f} | {step} | "
            f"{do:.1%} | {parts[0]} | {parts[1]} | {used[rung] / total:.1%} |"
        )
    model, step = (np.median([row[-1] for row in rows]) for rows in (
        [row["model_us"] for row in rows], steps))  # fmt: skip
    return [*lines, f"| `auto` | {model:.3f} | {step:.2f} | | | | |", ""]


def write(rows: list[dict], path: Path):
    """Write every figure, a scene a row."""
    names = ["seed", "index", "kind", "tolerance", "samples", "redrawn", "auto", "decisions",
             "changes"]  # fmt: skip
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        more = [f"{what}_{rung}" for what in ("error", "used", "model_us") for rung in RUNGS]
        steps = [f"step_us_{rung}" for rung in (*RUNGS[: DYNAMIC + 1], "auto")]
        writer.writerow([*names, *more, "model_us_auto", *steps])
        for row in rows:
            step = row["step_us"] or [""] * (DYNAMIC + 2)
            parts = [*row["errors"], *row["used"], *row["model_us"], *step]
            writer.writerow([*(row[name] for name in names), *parts])


def main(arguments=None):
    """Run the scenes, print the page of figures, write table and picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--scenes", type=int, default=1000, help="(1000)")
    parser.add_argument("--seed", type=int, default=SEED, help=f"({SEED})")
    parser.add_argument("--folder", type=Path, default=Path("out/ladder"), help="(out/ladder)")
    parser.add_argument("--figure", type=Path, help="picture (ladder.png in the folder)")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args(arguments)
    if options.scenes < 1:
        parser.error(f"--scenes is {options.scenes}: at least 1")
    rows = run(options.scenes, options.seed, options.folder, options.workers, _say)
    write(rows, options.folder / "ladder.csv")
    print(summary(rows))
    from ladder_plot import draw_page

    path = options.figure or options.folder / "ladder.png"
    draw_page(rows, path)
    print(f"written: {options.folder / 'ladder.csv'}, {path}")


def _say(text):
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
