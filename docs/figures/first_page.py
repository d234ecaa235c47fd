"""
Draw the picture of the README from replays of two shipped bags; needs matplotlib.

    python docs/figures/first_page.py [FOLDER]

Writes first_page.png and first_page_narrow.png to FOLDER (this one by default). The forces are
those that the replay estimates at the alarm; tilt and clearance of the drawn peg are far too
large.
"""

import json
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from peg_on_hole_ros.bags.estimates import estimates
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.truth import BOUND_STDDEVS, MODE_TOPIC
from peg_on_hole_ros.cli.main import main as command
from peg_on_hole_ros.mechanics.geometry import contact_geometry, contact_points, normals
from peg_on_hole_ros.mechanics.scene import Scene

HERE = Path(__file__).parent
BAGS = HERE.parents[1] / "bags"
# The drawn peg; its proportions show what a real clearance would hide.
SCENE = Scene(hole_diameter=1.0, peg_diameter=0.9, peg_height=1.45)
GAMMA = 0.56
CONTACT_COLORS = {"K": "#1b6ca8", "B1": "#c2571a", "B2": "#2e7d32"}
MODES = {
    "open": ("air", "#d5d5d5"),
    "three_point": ("three-point contact", "#a8d5ae"),
    "two_point": ("two-point contact", "#f3c9a8"),
}
LEVELS = {"OK": "#dfeee0", "WARN": "#ffc94d", "ERROR": "#c62828"}
INK, HOLE, PEG = "#222222", "#d9d9d9", "#cfe0f3"
DPI = 160


class Replay(NamedTuple):
    """
    What a replay says of a bag.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Since the first wrench [s].
    normal, bound : ndarray, shape (3, n)
        Reactions and their 95 % bounds [N], NaN where the wrench does not determine them.
    modes : list of (float, str)
        When a contact mode begins [s].
    alarms : list of (float, str)
        When the level of `jamming` changes [s].
    truth : list of (float, str)
        The simulated contact modes.

    """

    t: np.ndarray
    normal: np.ndarray
    bound: np.ndarray
    modes: list[tuple[float, str]]
    alarms: list[tuple[float, str]]
    truth: list[tuple[float, str]]


def replay(name: str) -> Replay:
    """Replay a shipped bag by the command that a user has."""
    bag = BAGS / f"{name}.mcap"
    with tempfile.TemporaryDirectory() as folder:
        out, summary = Path(folder) / "out.mcap", Path(folder) / "summary.json"
        if command(["replay", str(bag), "--out", str(out), "--summary", str(summary)]):
            raise SystemExit(f"the replay of {bag} failed")
        rows = list(estimates(Bag(out)))
        alarms = json.loads(summary.read_text(encoding="utf-8"))["alarms"]
    begin = rows[0].t_ns
    determined = np.array([row.monitor["reactions_determined"] > 0.0 for row in rows])
    values, stddev = (
        np.where(determined, np.array([getattr(row, part)[6:9] for row in rows]).T, np.nan)
        for part in ("values", "stddev")
    )
    modes = [(row.t_ns, row.mode) for row in rows]
    modes = [now for before, now in zip([(0, ""), *modes], modes) if now[1] != before[1]]
    truth = [(m.log_ns, m.message.data) for m in Bag(bag).messages([MODE_TOPIC])]
    return Replay(
        np.array([(row.t_ns - begin) * 1e-9 for row in rows]),
        values,
        BOUND_STDDEVS * stddev,
        [((t - begin) * 1e-9, mode) for t, mode in modes],
        [(one["time"], one["level"]) for one in alarms if one["name"] == "jamming"],
        [((t - begin) * 1e-9, mode) for t, mode in truth],
    )


def later(found: Replay, begin: float) -> Replay:
    """Return a replay with its times counted from a later begin [s]."""
    changes = ([(t - begin, what) for t, what in part] for part in found[3:])
    return Replay(found.t - begin, found.normal, found.bound, *changes)


def draw_peg(axes, forces, letters):
    """Draw the peg from the side on its contacts, with the forces of one moment [N]."""
    g = contact_geometry(SCENE, GAMMA)
    zeta, across = np.array([-g.s, g.c]), np.array([g.c, g.s])
    origin = np.array([0.0, g.a1]) - g.a2 * zeta
    D, d, H = SCENE.hole_diameter, SCENE.peg_diameter, SCENE.peg_height
    for side in (-1, 1):
        block = [[side * D / 2, 0], [side * D / 2, -0.62], [side * 1.22, -0.62], [side * 1.22, 0]]
        axes.fill(*np.transpose(block), facecolor=HOLE, edgecolor=INK, lw=1.0)
    corner = origin + d / 2 * across
    peg = [corner, corner + H * zeta, corner + H * zeta - d * across, corner - d * across]
    axes.fill(*np.transpose(peg), facecolor=PEG, edgecolor="#1f5fa8", lw=1.4)
    grip = origin + H * zeta
    box = [
        grip + a * across + b * zeta for a, b in ((-0.4, 0), (0.4, 0), (0.4, 0.26), (-0.4, 0.26))
    ]
    axes.fill(*np.transpose(box), facecolor="#f6dcc3", edgecolor="#b8560f", lw=1.2)
    say = {"ha": "center", "va": "center"}
    turned = {"rotation": np.degrees(GAMMA), "rotation_mode": "anchor"}
    axes.annotate("sensor", grip + 0.13 * zeta, color="#8f420a", size=8.5, **say, **turned)
    axes.annotate("peg", grip - 0.5 * zeta, color="#1f5fa8", **say, **turned)
    points, ways = contact_points(g, D)[:, [0, 2]], normals(g)[:, [0, 2]]
    scale = 0.72 / forces["K"]
    half = (forces["B1"] + forces["B2"]) / 2
    for at, way, size, name in (
        (points[0], ways[0], forces["K"], "K"), (points[1], ways[1], half, "B1"),
    ):  # fmt: skip
        way = way / np.hypot(*way)
        arrow = {"arrowstyle": "-|>", "color": CONTACT_COLORS[name], "lw": 2.6, "shrinkA": 0}
        axes.annotate("", at + scale * size * way, at, arrowprops=arrow | {"mutation_scale": 16})
        axes.plot(*at, "o", color=CONTACT_COLORS[name], ms=8, zorder=5)
    for x, name, text in (
        (-0.86, "K", f"K\n{forces['K']:.0f} N"),
        (0.86, "B1", f"B1, B2\n{half:.0f} N each"),
    ):
        axes.annotate(
            text, (x, -0.31), size=letters, color=CONTACT_COLORS[name], weight="bold", **say
        )
    turn = np.pi / 2 + np.linspace(0, GAMMA, 30)
    centre = np.array([0.0, g.a1])
    axes.plot([0, 0], [-0.1, 1.9], color=INK, lw=0.7, ls="-.")
    axes.plot(*(centre[:, None] + 1.6 * np.array([np.cos(turn), np.sin(turn)])), color=INK, lw=1.2)
    axes.annotate("tilt", centre + 1.67 * np.array([np.cos(1.75), np.sin(1.75)]), ha="center")
    axes.set(xlim=(-1.3, 1.25), ylim=(-0.66, 1.95), aspect="equal")
    axes.axis("off")


def strip(axes, changes, end, looks, text):
    """Draw what holds over time as one bar, with its names where they fit."""
    inches = axes.get_position().width * axes.figure.get_figwidth()
    for (begin, name), (after, _) in zip(changes, [*changes[1:], (end, "")]):
        if name not in looks:
            continue
        label, color = looks[name]
        axes.barh(0, after - begin, left=begin, color=color, height=1.0)
        low, high = axes.get_xlim()
        shown = (min(after, high) - max(begin, low)) / (high - low)
        if shown * inches > 0.062 * len(label):
            at = (max(begin, low) + min(after, high)) / 2
            dark = "white" if color == LEVELS["ERROR"] else INK
            axes.text(at, 0, label, ha="center", va="center", color=dark, size=8.5)
    axes.set(ylim=(-0.5, 0.5), yticks=[0], xticks=[])
    axes.set_yticklabels([text], size=8.5)
    axes.tick_params(length=0)
    for side in axes.spines.values():
        side.set_visible(False)


def draw_time(panels, found, end, title):
    """Draw contact mode, reactions with bounds and truth, and the alarm up to a time [s]."""
    modes, reactions, alarms = panels
    for axes in panels:
        axes.set_xlim(0.0, end)
    modes.set_title(title, loc="left", size=10.5, weight="bold")
    strip(modes, found.modes, found.t[-1], MODES, "contact")
    for i, (name, color) in enumerate(CONTACT_COLORS.items()):
        value, bound = found.normal[i], found.bound[i]
        reactions.fill_between(found.t, value - bound, value + bound, color=color, alpha=0.2, lw=0)
        # B1 and B2 carry nearly the same: dashes show both.
        line = (0, (4, 4)) if name == "B2" else "-"
        reactions.plot(found.t, value, color=color, lw=2.0, ls=line, label=name)
    reactions.set(ylim=(0, 320), xticks=[], yticks=[0, 100, 200, 300])
    reactions.set_ylabel("force [N]", size=8.5)
    reactions.tick_params(labelsize=8)
    reactions.spines[["top", "right"]].set_visible(False)
    levels = {name: ("" if name == "WARN" else name, color) for name, color in LEVELS.items()}
    strip(alarms, [(found.t[0], "OK"), *found.alarms], found.t[-1], levels, "jamming")
    ticks = np.arange(0.0, end, 0.2 if end < 1.5 else 1.0)
    alarms.set_xticks(ticks, [f"{t:.1f} s" if end < 1.5 else f"{t:.0f} s" for t in ticks])
    alarms.tick_params(axis="x", length=2.5, labelsize=8)


def mark(axes, at, text, color, ha):
    """Draw a moment through the reactions."""
    axes.axvline(at, color=color, lw=1.4, ls=(0, (3, 2)))
    low, high = axes.get_xlim()
    shift = 0.01 * (high - low) * (1 if ha == "left" else -1)
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0}
    axes.text(
        at + shift, 0.97 * axes.get_ylim()[1], text, color=color, size=9, ha=ha, va="top",
        weight="bold", bbox=box,
    )  # fmt: skip


def draw(folder: Path, narrow: bool, jam: Replay, good: Replay) -> Path:
    """Write one of the two pictures."""
    plt.rcParams.update({"font.size": 9.5, "savefig.facecolor": "white"})
    figure = plt.figure(figsize=(3.9, 8.3) if narrow else (9.6, 4.9), dpi=DPI)
    if narrow:
        figure.add_axes((0.0, 0.695, 1.0, 0.28), label="peg")
        left, width, tops, heights = 0.17, 0.8, (0.675, 0.34), (0.03, 0.185, 0.03)
    else:
        figure.add_axes((0.0, 0.05, 0.355, 0.86), label="peg")
        left, width, tops, heights = 0.43, 0.56, (0.985, 0.49), (0.05, 0.27, 0.05)
    error = next(t for t, level in jam.alarms if level == "ERROR")
    wedged = jam.truth[-1][0]
    now = int(np.searchsorted(jam.t, error))
    peg = figure.axes[0]
    draw_peg(
        peg, dict(zip(CONTACT_COLORS, jam.normal[:, now], strict=True)), 7.5 if narrow else 8.5
    )
    peg.set_title("Contacts and forces at the alarm", size=10.5, weight="bold")
    touched = next(t for t, mode in reversed(good.modes) if mode == "three_point")
    entered = next(t for t, mode in good.modes if mode == "two_point" and t > touched)
    good = later(good, touched - 0.35)
    ends = jam.t[-1], entered - touched + 1.35
    titles = "An insertion that jams", "An insertion that goes in"
    for top, found, end, title in zip(tops, (jam, good), ends, titles, strict=True):
        panels, low = [], top - 0.035
        for height in heights:
            low -= height
            panels.append(figure.add_axes((left, low, width, height)))
            low -= 0.012
        draw_time(panels, found, end, title)
        if found is jam:
            mark(panels[1], error, "alarm", LEVELS["ERROR"], "right")
            mark(panels[1], wedged, "wedged", INK, "right")
            y = 0.62 * panels[1].get_ylim()[1]
            style = {"arrowstyle": "<->", "color": INK, "lw": 1.0, "shrinkA": 0, "shrinkB": 0}
            panels[1].annotate("", (error, y), (wedged, y), arrowprops=style)
            panels[1].text(
                (error + wedged) / 2, y, f"{wedged - error:.2f} s\nto react", ha="center",
                va="bottom", size=9,
            )  # fmt: skip
            columns = 1 if narrow else 3
            panels[1].legend(loc="upper left", fontsize=9, frameon=False, ncols=columns)
    path = folder / f"first_page{'_narrow' if narrow else ''}.png"
    figure.savefig(path)
    plt.close(figure)
    print(path.name, f"alarm {error:.3f} s, wedged {wedged:.3f} s, entered {entered:.3f} s")
    return path


def main(folder=HERE):
    """Draw both pictures."""
    jam, good = replay("closing_without_slip"), replay("working_cycle")
    for narrow in (False, True):
        draw(Path(folder), narrow, jam, good)


if __name__ == "__main__":
    main(*sys.argv[1:2])
