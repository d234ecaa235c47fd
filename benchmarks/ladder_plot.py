"""The picture of the ladder: which rung does when, how auto keeps its tolerance, its cost."""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from peg_on_hole_ros.ladder.rungs import DYNAMIC, RUNGS

# Okabe and Ito's colours, told apart by colour-blind eyes.
COLOURS = ("#56B4E9", "#0072B2", "#009E73", "#F0E442", "#E69F00", "#D55E00")
_SMALLEST = 1e-5


def draw_page(rows: list[dict], path: Path) -> None:
    """Draw three panels from the figures of scenes."""
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(14, 4.4), layout="constrained")
    _needed(left, rows)
    _kept(middle, rows)
    _costs(right, rows)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _needed(axes, rows):
    errors = np.array([row["errors"] for row in rows])
    tolerances = np.geomspace(1e-3, 0.5, 60)
    # The first rung, from the cheapest, that would do.
    shares = []
    for tolerance in tolerances:
        good = errors <= tolerance
        first = np.where(good.any(axis=1), good.argmax(axis=1), len(RUNGS) - 1)
        shares.append([np.mean(first == rung) for rung in range(len(RUNGS))])
    axes.stackplot(100 * tolerances, 100 * np.array(shares).T, colors=COLOURS, labels=RUNGS)
    axes.set(xscale="log", xlim=(0.1, 50), ylim=(0, 100), xlabel="tolerance on reactions [%]",
             ylabel="scenes [%]", title="First rung that would do")  # fmt: skip
    handles, labels = axes.get_legend_handles_labels()
    axes.legend(handles[::-1], labels[::-1], loc="lower right", fontsize=8)


def _kept(axes, rows):
    share = 100 * np.arange(1, len(rows) + 1) / len(rows)
    over = np.array([[e / row["tolerance"] for e in row["errors"]] for row in rows])
    for rung, name in enumerate(RUNGS[:DYNAMIC]):
        axes.plot(np.sort(np.clip(over[:, rung], _SMALLEST, 1e4)), share, color=COLOURS[rung],
                  label=name, lw=1.2)  # fmt: skip
    auto = np.sort(np.clip([row["auto"] / row["tolerance"] for row in rows], _SMALLEST, 1e4))
    axes.plot(auto, share, color="black", lw=2.2, label="auto")
    axes.axvline(1, color="0.4", ls="--", lw=1)
    axes.set(xscale="log", xlim=(1e-3, 1e2), ylim=(0, 101), ylabel="scenes [%]",
             title="How the tolerance is kept",
             xlabel="largest error in a scene over its tolerance")  # fmt: skip
    axes.legend(loc="lower right", fontsize=8)


def _costs(axes, rows):
    steps = np.array([row["step_us"] for row in rows if row["step_us"] is not None])
    models = np.array([row["model_us"] for row in rows])
    names = [*RUNGS[: DYNAMIC + 1], "auto"]
    model = np.median(models, axis=0)[[*range(DYNAMIC + 1), -1]]
    step = np.median(steps, axis=0)
    places = np.arange(len(names))
    for shift, values, colour, label in (
        (-0.2, step, "#0072B2", "filter's step"), (0.2, model, "#E69F00", "model alone"),
    ):  # fmt: skip
        bars = axes.barh(places + shift, values, 0.38, color=colour, label=label)
        axes.bar_label(bars, [f"{v:.2g}" for v in values], padding=3, fontsize=8)
    axes.set(yticks=places, yticklabels=names, xscale="log", xlabel="microseconds, median",
             xlim=(0.08, 3 * step.max()), title="What a sample costs")  # fmt: skip
    # Room for the legend below the last bar.
    axes.set_ylim(len(names) + 0.5, -0.6)
    axes.legend(loc="lower right", fontsize=8, ncols=2)
