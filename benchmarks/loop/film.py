"""
Draw a film of one draw: a robot program without the monitor beside the same with it.

    python -m benchmarks.loop.film 12 docs/figures/loop_film.gif

Needs MuJoCo and matplotlib. Loads are the engine's, modes and alarms those of the pipeline.
"""

import sys
from pathlib import Path
from typing import NamedTuple

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter

from benchmarks.loop import drawn
from benchmarks.loop.drawn import MOST_LOAD
from benchmarks.loop.lockstep import play
from benchmarks.loop.program import program_module
from benchmarks.loop.variants import VARIANTS, options_of
from benchmarks.robot_cells.rows import D

# Of the film [1/s], how much slower than the try it is, and the longest part of the try [s].
RATE, SLOWER, LONGEST = 10, 2.0, 7.0
HEIGHT, PLATE, HALF = 62.0, 22.0, 44.0  # [mm]
BLUE, RED, AMBER, GREY = "#2b6cb0", "#c53030", "#b7791f", "#718096"
TITLES = {name: VARIANTS[name].short for name in ("plain", "all")}
LEVELS = ("", AMBER, RED)


class Moment(NamedTuple):
    """What is drawn of a moment; lengths in mm, in the plane in which the peg leans."""

    t: float
    tilt: float
    along: float
    z: float
    loads: tuple[float, float, float]
    stage: str
    mode: str
    level: int
    text: str


def record(number: int, name: str) -> tuple[list[Moment], str]:
    """Return the moments of a variant, and its outcome."""
    module, true = program_module(), drawn.drawn(number, True)
    moments: list[Moment] = []

    def watch(t, row, command, published, cell):
        if moments and t - moments[-1].t < 1.0 / (RATE * SLOWER) - 1e-6:
            return
        h = np.array([np.cos(row[4][1]), np.sin(row[4][1])])
        texts = [text for _, level, text in published.alarms if level == published.level]
        moments.append(Moment(
            t, row[4][0], 1e3 * float(row[7][:2] @ h), 1e3 * row[7][2], tuple(row[6]),
            command.stage, published.mode, published.level, texts[0] if texts else "",
        ))  # fmt: skip

    run = play(true, module, options_of(module, true, name), watch)
    return moments, run["outcome"]


def draw_peg(axes, moment: Moment, radius: float) -> None:
    """Draw plate, peg and loads from the side."""
    for side in (-1, 1):
        inner, outer = side * 0.5e3 * D, side * HALF
        axes.fill([inner, outer, outer, inner], [0, 0, -PLATE, -PLATE], color="#cbd5e0")
    s, c = np.sin(moment.tilt), np.cos(moment.tilt)
    across, up = np.array([c, s]), np.array([-s, c])
    end = np.array([moment.along, moment.z])
    corners = [end + x * across + y * up for x, y in
               ((-radius, 0), (radius, 0), (radius, HEIGHT), (-radius, HEIGHT))]  # fmt: skip
    axes.fill(*np.transpose(corners), color="#90cdf4", ec=BLUE, lw=1.2)
    K, B = np.array([-0.5e3 * D, 0.0]), end + radius * across
    for place, way, load in ((K, 1, moment.loads[0]), (B, -1, sum(moment.loads[1:]))):
        if load > 1.0:
            length, color = 2.2 * np.sqrt(load), RED if load > MOST_LOAD else BLUE
            axes.annotate(
                "", place, place - (way * length, 0),
                arrowprops={"arrowstyle": "-|>", "lw": 2, "color": color},
            )  # fmt: skip
    axes.set(xlim=(-HALF - 12, HALF + 12), ylim=(-PLATE - 10, HEIGHT + 16), aspect="equal")
    axes.axis("off")


def film(number: int, path: Path) -> None:
    """Write the film of a draw."""
    runs = {name: record(number, name) for name in TITLES}
    radius = 0.5e3 * (D - drawn.drawn(number, True).clearance)
    begins = min(next(m.t for m in moments if m.stage == "touch") for moments, _ in runs.values())
    ends = min(max(moments[-1].t for moments, _ in runs.values()), begins + LONGEST)
    figure = plt.figure(figsize=(6.4, 4.4), dpi=100)
    grid = figure.add_gridspec(2, 2, height_ratios=(2.2, 1), hspace=0.08, left=0.1, right=0.98,
                               top=0.93, bottom=0.12)  # fmt: skip
    sides = [figure.add_subplot(grid[0, k]) for k in range(2)]
    below = figure.add_subplot(grid[1, :])

    def frame(k):
        t = min(begins + k / (RATE * SLOWER), ends)
        below.clear()
        for axes, (name, (moments, outcome)) in zip(sides, runs.items()):
            axes.clear()
            past = [m for m in moments if m.t <= t] or moments[:1]
            now = past[-1]
            draw_peg(axes, now, radius)
            over = t >= moments[-1].t
            axes.set_title(TITLES[name], fontsize=9)
            axes.text(0, HEIGHT + 9, outcome if over else f"{now.stage}, {now.mode}", ha="center",
                      fontsize=8, color=GREY)  # fmt: skip
            if name == "all" and now.level and not over:
                text = now.text.split(";")[0].split(":")[-1 if "it was" in now.text else 0]
                axes.text(0, -PLATE - 8, text[:52], ha="center", fontsize=7, color="white",
                          bbox={"fc": LEVELS[now.level], "ec": "none", "pad": 2})  # fmt: skip
            below.plot([m.t for m in past], [max(max(m.loads), 1.0) for m in past], lw=1.3,
                       color=RED if name == "plain" else BLUE, label=TITLES[name][:3])  # fmt: skip
        below.axhline(MOST_LOAD, color=GREY, lw=0.8, ls="--")
        below.set(xlim=(begins, ends), ylim=(1, 2000), yscale="log", xlabel="time [s]",
                  ylabel="largest load [N]")  # fmt: skip
        below.legend(loc="upper left", fontsize=7, ncols=2, frameon=False)
        below.tick_params(labelsize=7)

    frames = round((ends - begins) * RATE * SLOWER) + RATE
    FuncAnimation(figure, frame, frames=frames).save(path, PillowWriter(fps=RATE))


if __name__ == "__main__":
    film(int(sys.argv[1]), Path(sys.argv[2]))
