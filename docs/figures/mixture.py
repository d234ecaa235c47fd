"""
Draw the mixture of the estimator: process-noise modes by friction hypotheses; needs matplotlib.

    python docs/figures/mixture.py [FOLDER]

Writes mixture.svg to FOLDER (this one by default), with the numbers of the shipped settings. The
picture is as wide as a telephone.
"""

import sys
from math import exp
from pathlib import Path

from matplotlib import rcParams
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from peg_on_hole_ros.cli.pictures import save
from peg_on_hole_ros.estimator.settings import default_settings

HERE = Path(__file__).parent
COLORS = {"filter": "#1f5fa8", "mix": "#b8560f", "flow": "#333333"}
MEANS = ("at rest or steady", "turns round", "jumps")
# Centres of the columns, and the size of a filter's box.
COLUMNS, WIDTH, HEIGHT = (2.0, 3.5, 5.0), 0.9, 0.5


def box(axes, x, y, width, height, text, **style):
    """Draw a box with a text, by its centre."""
    corner = (x - width / 2, y - height / 2)
    shape = FancyBboxPatch(corner, width, height, boxstyle="round,pad=0.02", **style)
    axes.add_patch(shape)
    axes.annotate(text, (x, y), ha="center", va="center")


def arrow(axes, start, end, color, style="-|>"):
    """Draw an arrow."""
    line = {"arrowstyle": style, "color": color, "lw": 1.3, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, start, arrowprops=line)


def filters(axes):
    """Draw a Kalman filter for each mode and each hypothesis; return the lowest row's place."""
    settings = default_settings()
    count, reach = settings.friction_hypotheses, settings.reach
    for x, stddev, means in zip(COLUMNS, settings.mode_stddev, MEANS, strict=True):
        axes.annotate(f"{stddev:g}", (x, 0.95), ha="center", weight="bold")
        axes.annotate(means, (x, 0.62), ha="center", fontsize=8)
    axes.annotate(
        "process-noise mode: standard deviation\nof accelerations [rad/s²]",
        (3.5, 1.3),
        ha="center",
    )
    axes.annotate("friction\nhypothesis", (0.55, 0.62), ha="center")
    y = 0.0
    for k in range(count):
        off = -reach + 2.0 * reach * k / (count - 1)
        y = -0.75 * k
        sign = "-" if off < -1e-9 else "+"
        name = f"f {sign} {abs(off):.2g} s" if abs(off) > 1e-9 else "f"
        axes.annotate(name, (0.55, y), ha="center", va="center")
        # As dark as the weight at the start.
        shade = 0.12 + 0.55 * exp(-0.5 * off * off)
        for x in COLUMNS:
            style = {"facecolor": COLORS["filter"], "alpha": shade, "edgecolor": "none"}
            box(axes, x, y, WIDTH, HEIGHT, "", **style)
        for left, right in zip(COLUMNS, COLUMNS[1:]):
            ends = (left + WIDTH / 2 + 0.04, y), (right - WIDTH / 2 - 0.04, y)
            arrow(axes, *ends, COLORS["mix"], "<|-|>")
    return y


def flow(axes, y):
    """Draw what happens to all filters with every message, below them."""
    steps = (
        "mix: within a row, each mode takes over\npart of the others' means and covariances",
        "predict, then correct with an\norientation or a wrench",
        "weigh each filter by its likelihood;\nmerge rows that agree",
        "mean and covariance of all filters:\n~/state, ~/contacts",
    )
    note = "f, s: stated friction and its standard deviation; darker: more weight at a start"
    axes.annotate(note, (2.85, y - 0.62), ha="center", fontsize=7.5)
    y -= 1.3
    for i, text in enumerate(steps):
        color = COLORS["mix"] if i == 0 else COLORS["flow"]
        box(axes, 3.0, y, 5.4, 0.8, text, facecolor="white", edgecolor=color, lw=1.3)
        if i + 1 < len(steps):
            arrow(axes, (3.0, y - 0.43), (3.0, y - 0.75), COLORS["flow"])
        y -= 1.2
    return y


def draw(folder: Path) -> Path:
    """Write mixture.svg; the same bytes for the same version of matplotlib."""
    rcParams["font.size"] = 10
    figure = Figure((4.4, 8.6), layout="constrained")
    axes = figure.subplots()
    lowest = flow(axes, filters(axes))
    axes.set(xlim=(-0.1, 5.8), ylim=(lowest + 0.7, 2.0), aspect="equal")
    axes.axis("off")
    return save(figure, folder / "mixture", (".svg",))[0]


if __name__ == "__main__":
    print(draw(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE))
