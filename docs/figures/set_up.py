"""
Draw the five settings of a cell that are most often wrong; needs matplotlib.

    python docs/figures/set_up.py [FOLDER]

Writes gravity.svg, tip_frame.svg, wrench_axes.svg, hole_direction.svg and tare.svg to FOLDER (this
one by default). Each shows the right case beside another one. A phone shows the letters large
enough.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib import rcParams
from matplotlib.figure import Figure

from peg_on_hole_ros.cli.pictures import save

HERE = Path(__file__).parent
INK, METAL, PEG, TOOL = "#333333", "#dddddd", "#cfe0f3", "#eeeeee"
COLORS = {"base": "#333333", "peg": "#1f5fa8", "sensor": "#b8560f", "force": "#b01e1e"}
RIGHT, WRONG = "#2e7d32", "#b01e1e"
# Of a picture, and of the line of its titles [in].
WIDTH, TITLE = 4.7, 0.28


def turned(points, angle, at=(0.0, 0.0)):
    """Return points turned counter-clockwise by an angle [degrees] and moved."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return np.asarray(points, dtype=float) @ np.array([[c, s], [-s, c]]) + at


def box(axes, low, high, angle, at, face, edge):
    """Draw a rectangle in turned axes."""
    (a, b), (c, d) = low, high
    corners = turned([(a, b), (c, b), (c, d), (a, d)], angle, at)
    axes.fill(*corners.T, facecolor=face, edgecolor=edge, lw=1.1)


def arrow(axes, start, end, color, width=1.6):
    """Draw an arrow."""
    style = {"arrowstyle": "-|>", "color": color, "lw": width, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, start, arrowprops=style | {"mutation_scale": 13})


def say(axes, at, text, color=INK, **how):
    """Write a text, centred unless stated otherwise."""
    axes.annotate(text, at, color=color, **({"ha": "center", "va": "center"} | how))


def frame(axes, at, angle, color, length=0.5, names=("x", "z"), beyond=0.1):
    """Draw the x and z axis of a frame with their names."""
    for way, name in zip(((1, 0), (0, 1)), names):
        end = turned([np.array(way) * length], angle, at)[0]
        arrow(axes, at, end, color)
        say(axes, turned([np.array(way) * (length + beyond)], angle, at)[0], name, color)
    axes.plot(*at, "o", color=color, ms=4, zorder=6)


def tool(axes, at, angle):
    """Draw flange, sensor, gripper and peg; `at` is the centre of the peg's lower end."""
    box(axes, (-0.14, 0.0), (0.14, 0.62), angle, at, PEG, COLORS["peg"])
    box(axes, (-0.2, 0.62), (0.2, 0.85), angle, at, TOOL, INK)
    box(axes, (-0.24, 0.85), (0.24, 1.02), angle, at, "#f6dcc3", COLORS["sensor"])
    box(axes, (-0.3, 1.02), (0.3, 1.2), angle, at, TOOL, INK)


def plate(axes, angle, at, half=0.85, depth=0.32):
    """Draw a plate with its hole, cut; `at` is the centre of the rim."""
    for side in (-1, 1):
        ends = sorted((side * 0.16, side * half))
        box(axes, (ends[0], -depth), (ends[1], 0.0), angle, at, METAL, INK)


def arm(axes, at, angle, joints):
    """Draw an arm of two links on its base, along joints in the axes of the base."""
    box(axes, (-0.25, 0.0), (0.25, 0.22), angle, at, METAL, INK)
    points = turned(joints, angle, at)
    axes.plot(*points.T, color="#9a9a9a", lw=7, solid_capstyle="round", zorder=1)
    axes.plot(*points.T, "o", color=INK, ms=4, zorder=2)


def gravity_right(axes):
    """Draw an arm that stands on the floor."""
    axes.plot([-0.9, 0.9], [0, 0], color=INK, lw=2)
    arm(axes, (-0.2, 0.0), 0, [(0, 0.22), (0.15, 0.85), (0.75, 0.6)])
    arrow(axes, (-0.2, 0.0), (-0.2, 1.1), COLORS["base"])
    say(axes, (-0.55, 1.22), "z of root link", ha="left")
    arrow(axes, (0.85, 1.3), (0.85, 0.75), COLORS["force"], 2.2)
    say(axes, (0.7, 1.42), "gravity", COLORS["force"])
    say(axes, (0.0, -0.2), "nothing to state", RIGHT, weight="bold")


def gravity_wrong(axes):
    """Draw an arm on a wall."""
    axes.plot([-0.85, -0.85], [-0.1, 1.5], color=INK, lw=2)
    arm(axes, (-0.85, 0.9), -90, [(0, 0.22), (-0.35, 0.7), (-0.15, 1.3)])
    arrow(axes, (-0.85, 0.9), (0.1, 0.9), COLORS["base"])
    say(axes, (-0.5, 0.7), "z of root link", ha="left")
    arrow(axes, (0.85, 1.3), (0.85, 0.75), COLORS["force"], 2.2)
    say(axes, (0.7, 1.42), "gravity", COLORS["force"])
    say(axes, (0.05, -0.2), "joints.gravity_link", WRONG, weight="bold")


def tip_axes(axes, up):
    """Draw z of the tip out of the gripper, and z of the peg up the peg (1) or down (-1)."""
    tool(axes, (0.0, 0.0), 0)
    ends = {"base": ((0.0, 0.74), (0.0, 0.36)), "peg": ((0.0, 0.0), (0.0, 0.36 * up))}
    for key, (start, end) in ends.items():
        arrow(axes, start, end, COLORS[key], 2.0)
        axes.plot(*start, "o", color=COLORS[key], ms=4, zorder=6)
    line = {"arrowstyle": "-", "color": COLORS["base"], "lw": 0.7}
    axes.annotate(
        "z of\ntip_frame", (-0.03, 0.55), (-0.95, 0.55), ha="left", va="center", size=9.5,
        arrowprops=line,
    )  # fmt: skip
    say(axes, (-0.95, 0.17 * up), "z of the peg", COLORS["peg"], ha="left", size=9.5)


def tip_right(axes):
    """Draw a peg frame whose z points up the peg."""
    tip_axes(axes, 1)
    style = {"arrowstyle": "<->", "color": INK, "lw": 1.0, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (0.5, 0.74), (0.5, 0.0), arrowprops=style)
    axes.plot([0.05, 0.55], [0.0, 0.0], color=INK, lw=0.6)
    say(axes, (0.54, 0.37), "peg_xyz", ha="left", size=9.5)
    say(axes, (0.0, -0.56), "peg_rpy: [3.14159, 0, 0]", RIGHT, weight="bold", size=9.5)


def tip_wrong(axes):
    """Draw a peg frame that is the tip frame's."""
    tip_axes(axes, -1)
    say(axes, (0.0, -0.56), "peg_rpy: [0, 0, 0]", WRONG, weight="bold", size=9.5)


def axes_view(axes, angle, name):
    """Draw a tilted tool that is pushed from the side, and the axes of the numbers."""
    tool(axes, (0.0, 0.0), -25)
    at = turned([(0.0, 0.93)], -25)[0]
    frame(axes, at, angle, COLORS["sensor"], 0.55)
    arrow(axes, (-0.75, 0.1), (-0.12, 0.1), COLORS["force"], 2.6)
    say(axes, (-0.52, 0.26), "push", COLORS["force"])
    say(axes, (0.1, -0.28), name, weight="bold", size=9.5)


def axes_sensor(axes):
    """Draw axes that turn with the tool."""
    axes_view(axes, -25, "wrench.axes: sensor")
    say(axes, (0.1, -0.5), "the axes turn with the tool")


def axes_base(axes):
    """Draw axes that stand still."""
    axes_view(axes, 0, "wrench.axes: base")
    say(axes, (0.1, -0.5), "the axes stand still")


def hole_right(axes):
    """Draw a hole whose stated z is normal to its plate."""
    plate(axes, 22, (0.15, 0.35))
    frame(axes, (0.15, 0.35), 22, COLORS["peg"], 0.62, ("", "z of hole"), 0.14)
    frame(axes, (-0.9, -0.2), 0, COLORS["base"], 0.42, ("", "z"))
    say(axes, (-1.1, -0.33), "root link", ha="left")
    say(axes, (0.1, -0.62), "z points out of the hole", RIGHT, weight="bold", size=9.5)


def hole_wrong(axes):
    """Draw a hole that leans but is stated upright."""
    plate(axes, 22, (0.15, 0.35))
    frame(axes, (0.15, 0.35), 0, COLORS["peg"], 0.62, ("", "z as stated"))
    end = turned([(0.0, 0.62)], 22, (0.15, 0.35))[0]
    axes.plot([0.15, end[0]], [0.35, end[1]], color=INK, lw=1.0, ls="--")
    angles = np.radians(np.linspace(90, 112, 20))
    axes.plot(0.15 + 0.5 * np.cos(angles), 0.35 + 0.5 * np.sin(angles), color=WRONG, lw=1.4)
    say(axes, (-0.28, 0.85), "22\u00b0", WRONG)
    frame(axes, (-0.9, -0.2), 0, COLORS["base"], 0.42, ("", "z"))
    say(axes, (-1.1, -0.33), "root link", ha="left")
    say(axes, (0.1, -0.62), "hole_rpy: [0, 0, 0]", WRONG, weight="bold", size=9.5)


def tare_right(axes):
    """Draw a peg that hangs free above the hole."""
    plate(axes, 0, (0.0, -0.35))
    tool(axes, (0.0, 0.05), 0)
    style = {"arrowstyle": "<->", "color": INK, "lw": 1.0, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (0.45, 0.05), (0.45, -0.35), arrowprops=style)
    say(axes, (0.52, -0.15), "gap", ha="left")
    say(axes, (0.0, -0.95), "hangs free and still", RIGHT, weight="bold")


def tare_wrong(axes):
    """Draw a peg that rests on the rim."""
    plate(axes, 0, (0.0, -0.35))
    tool(axes, (0.1, -0.42), 22)
    for x, way in ((-0.16, (0.2, 0.12)), (0.15, (-0.14, 0.3))):
        axes.plot(x, -0.35, "o", color=COLORS["force"], ms=6, zorder=6)
        arrow(axes, (x, -0.35), (x + way[0], -0.35 + way[1]), COLORS["force"], 2.0)
    say(axes, (0.57, -0.05), "load of the\ncontacts", COLORS["force"])
    say(axes, (0.0, -0.95), "touches the hole", WRONG, weight="bold")


class Picture:
    """Two panels with their titles and limits of the axes."""

    def __init__(
        self, left: tuple[str, Callable], right: tuple[str, Callable], x: tuple, y: tuple
    ) -> None:
        self.panels, self.x, self.y = (left, right), x, y


PICTURES = {
    "gravity": Picture(
        ("arm on the floor", gravity_right), ("arm on a wall", gravity_wrong),
        (-1.0, 1.1), (-0.3, 1.55),
    ),
    "tip_frame": Picture(
        ("right", tip_right), ("wrong: joint states dropped", tip_wrong),
        (-1.0, 1.05), (-0.65, 1.25),
    ),
    "wrench_axes": Picture(
        ("axes of the sensor", axes_sensor), ("axes of the base", axes_base),
        (-0.95, 1.25), (-0.62, 1.7),
    ),
    "hole_direction": Picture(
        ("right", hole_right), ("wrong: tilt is 22\u00b0 off", hole_wrong),
        (-1.2, 1.15), (-0.75, 1.3),
    ),
    "tare": Picture(
        ("tare here", tare_right), ("refused", tare_wrong), (-1.0, 1.1), (-1.05, 1.35)
    ),
}  # fmt: skip


def draw(folder: Path, name: str) -> Path:
    """Write one of the pictures; the same bytes for the same version of matplotlib."""
    rcParams["font.size"] = 10.5
    picture = PICTURES[name]
    height = WIDTH / 2 * np.ptp(picture.y) / np.ptp(picture.x)
    figure = Figure((WIDTH, height + TITLE))
    both = figure.subplots(1, 2)
    figure.subplots_adjust(0.005, 0.01, 0.995, height / (height + TITLE), wspace=0.02)
    for axes, (title, panel) in zip(both, picture.panels, strict=True):
        panel(axes)
        color = WRONG if title.startswith(("wrong", "refused")) else INK
        axes.set_title(title, fontsize=10.5, color=color, pad=3)
        axes.set(xlim=picture.x, ylim=picture.y, aspect="equal")
        axes.axis("off")
    return save(figure, folder / name, (".svg",))[0]


if __name__ == "__main__":
    to = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
    for each in PICTURES:
        print(draw(to, each))
