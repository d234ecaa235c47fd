"""
Draw what the monitor saves a robot program, by docs/figures/loop.csv; needs matplotlib.

    PYTHONPATH=. python docs/figures/loop.py
"""

import csv
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from benchmarks.harness.pooled import wilson
from benchmarks.loop.drawn import MOST_LOAD
from benchmarks.loop.variants import VARIANTS

HERE = Path(__file__).parent
COLORS = {
    "plain": "#718096", "stop": "#d69e2e", "advice": "#38a169", "plan": "#9f7aea",
    "all": "#2b6cb0",
}  # fmt: skip


def draw(folder):
    """Write loop.png and loop_narrow.png."""
    with (HERE / "loop.csv").open() as file:
        runs = list(csv.DictReader(file))
    plt.rcParams.update({"font.size": 9})
    for name, size, rows in (("loop", (9, 3.4), (1, 2)), ("loop_narrow", (4.2, 6.4), (2, 1))):
        figure, (loads, shares) = plt.subplots(*rows, figsize=size, dpi=110)
        for k, (variant, color) in enumerate(COLORS.items()):
            label = VARIANTS[variant].short
            of = [run for run in runs if run["variant"] == variant]
            n, sizes = len(of), sorted(float(run["most_load_N"]) for run in of)
            above = [1.0 - i / n for i in range(n + 1)]
            loads.step([10.0, *sizes], above, where="post", color=color, label=label, lw=1.6)
            inserted = [run for run in of if run["outcome"] == "inserted"]
            for hits, y, shape in (
                (len(inserted), k - 0.12, "o"),
                (sum(run["tried"] == "1" for run in inserted), k + 0.16, "|"),
            ):
                low, high = wilson(hits, n)
                shares.plot([100 * low, 100 * high], [y, y], color=color, lw=1.2)
                shares.plot(100 * hits / n, y, shape, color=color, ms=7)
        loads.axvline(MOST_LOAD, color="black", lw=0.8, ls="--")
        loads.set(xscale="log", xlim=(30, 2e3), ylim=(0, 1), xlabel="load [N]",
                  ylabel="tries with a larger load at a contact [-]")  # fmt: skip
        shares.set(xlim=(0, 102), xlabel="inserted [%]:\nbar at the first try, dot in the end")
        shares.set_yticks(range(len(COLORS)), [VARIANTS[variant].short for variant in COLORS])
        # The names stand for the lines of the other part as well.
        for name_at, color in zip(shares.get_yticklabels(), COLORS.values()):
            name_at.set_color(color)
            name_at.set_fontweight("bold")
        shares.invert_yaxis()
        figure.tight_layout()
        figure.savefig(folder / f"{name}.png")


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE)
