"""
Draw where a chamfered peg touches a chamfered hole, from the package's geometry; with matplotlib.

    python docs/figures/chamfers.py [FOLDER]

Writes chamfers.svg, and chamfers_narrow.svg for a phone, to FOLDER (this one by default). The
clearance is drawn wide, the tilt large.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib import rcParams
from matplotlib.figure import Figure

from peg_on_hole_ros.cli.pictures import save
from peg_on_hole_ros.mechanics.geometry import contact_geometry, contact_points
from peg_on_hole_ros.mechanics.scene import Scene

HERE = Path(__file__).parent
SCENE = Scene(hole_diameter=1.0, peg_diameter=0.9, peg_height=1.0)
GAMMA = 0.55
HOLE_CHAMFER, PEG_CHAMFER = 0.13, 0.11
COLORS = {"hole": "#333333", "peg": "#1f5fa8", "touch": "#b01e1e", "trap": "#8a8a8a"}


def measure(axes, start, end, text, at, color):
    """Draw a dimension between two points, with its name at a third."""
    arrow = {"arrowstyle": "<->", "color": color, "lw": 1.0, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", start, end, arrowprops=arrow)
    axes.annotate(text, at, color=color, ha="center", va="center")


def hole(axes):
    """Draw the hole, cut along its axis."""
    D = SCENE.hole_diameter
    for side in (-1, 1):
        x, out = side * D / 2, side * (D / 2 + HOLE_CHAMFER)
        block = [[x, 0], [x, -0.7], [side * 1.2, -0.7], [side * 1.2, HOLE_CHAMFER]]
        block += [[out, HOLE_CHAMFER]]
        axes.fill(*np.transpose(block), facecolor="#dddddd", edgecolor=COLORS["hole"], lw=1)
    axes.plot([-D / 2, D / 2], [0, 0], color=COLORS["hole"], lw=0.8, ls="--")


def peg_outline():
    """Return the corners of a peg from its shoulder's centre, across and along the axis."""
    r, H, p = SCENE.peg_diameter / 2, SCENE.peg_height, PEG_CHAMFER
    return np.array([[r, 0], [r, H], [-r, H], [-r, 0], [-r + p, -p], [r - p, -p]])


def contact(axes):
    """Draw the peg on three points, seen along -e for psi = 0."""
    g = contact_geometry(SCENE, GAMMA)
    zeta, across = np.array([-g.s, g.c]), np.array([g.c, g.s])
    origin = np.array([0.0, g.a1]) - g.a2 * zeta
    hole(axes)
    corners = origin + peg_outline() @ np.array([across, zeta])
    axes.fill(*corners.T, facecolor="#cfe0f3", edgecolor=COLORS["peg"], lw=1.4, alpha=0.8)
    shoulder = corners[[0, 3]]
    axes.plot(*shoulder.T, color=COLORS["peg"], lw=0.8, ls="--")
    for name, point, offset in zip(
        ("K", "B1, B2"), contact_points(g, SCENE.hole_diameter)[:2, [0, 2]],
        ((-0.09, -0.08), (0.0, -0.12)), strict=True,
    ):  # fmt: skip
        axes.plot(*point, "o", color=COLORS["touch"], ms=6, zorder=5)
        axes.annotate(name, point + offset, color=COLORS["touch"], ha="center", va="center")
    line = {"arrowstyle": "-", "lw": 0.6, "color": COLORS["hole"]}
    axes.annotate(
        "throat: the rim,\norigin of hole", (-0.2, 0.0), (-0.15, -0.66), ha="center",
        color=COLORS["hole"], arrowprops=line,
    )  # fmt: skip
    axes.annotate(
        "shoulder: the lower edge,\norigin of peg", shoulder[0] - 0.1 * across, (1.02, 0.8),
        ha="center", color=COLORS["peg"], arrowprops=line | {"color": COLORS["peg"]},
    )  # fmt: skip
    axes.set_title("three points are on throat and shoulder", fontsize=10)
    axes.set(xlim=(-1.25, 1.5), ylim=(-0.75, 1.5), aspect="equal")


def what_to_state(axes):
    """Draw peg and hole apart, with what is stated of them."""
    D, d, up = SCENE.hole_diameter, SCENE.peg_diameter, 0.75
    hole(axes)
    corners = peg_outline() * [1, 0.7] + [0, up + 0.03]
    corners[4:, 1] = up + 0.03 - PEG_CHAMFER
    axes.fill(*corners.T, facecolor="#cfe0f3", edgecolor=COLORS["peg"], lw=1.4, alpha=0.8)
    measure(axes, (-D / 2, -0.5), (D / 2, -0.5), "hole_diameter", (0, -0.43), COLORS["hole"])
    measure(axes, (-d / 2, 1.3), (d / 2, 1.3), "peg_diameter", (0, 1.37), COLORS["peg"])
    shoulder, tip = corners[0, 1], corners[5, 1]
    out = D / 2 + HOLE_CHAMFER
    for y, left, right, color in (
        (shoulder, d / 2, 0.95, "peg"), (tip, d / 2 - PEG_CHAMFER, 0.95, "peg"),
        (HOLE_CHAMFER, out, 1.3, "hole"), (0.0, D / 2, 1.3, "hole"),
    ):  # fmt: skip
        axes.plot([left, right], [y, y], color=COLORS[color], lw=0.6)
    measure(axes, (0.85, shoulder), (0.85, tip), "peg_chamfer", (1.2, up), COLORS["peg"])
    axes.annotate(
        "hole_chamfer", (1.05, HOLE_CHAMFER / 2), (1.05, 0.32), ha="center", color=COLORS["hole"],
        arrowprops={"arrowstyle": "-", "lw": 0.6, "color": COLORS["hole"]},
    )  # fmt: skip
    for x, y, name in ((0, tip, "peg_xyz"), (0, HOLE_CHAMFER, "hole_xyz")):
        axes.plot(x, y, "k+", ms=9)
        axes.annotate(name, (x + 0.05, y - 0.02), va="top", ha="left")
    measure(axes, (-out, 0.27), (out, 0.27), "", (0, 0), COLORS["trap"])
    axes.annotate("not this one", (-0.36, 0.35), ha="center", color=COLORS["trap"])
    axes.set_title("what to state", fontsize=10)
    axes.set(xlim=(-1.25, 1.55), ylim=(-0.75, 1.5), aspect="equal")


def draw(folder: Path, narrow: bool = False) -> Path:
    """Write one of the two; the same bytes for the same version of matplotlib."""
    rcParams["font.size"] = 9
    size, shape = ((4.2, 6.6), (2, 1)) if narrow else ((9.5, 4.2), (1, 2))
    figure = Figure(size, layout="constrained")
    first, second = figure.subplots(*shape)
    contact(first)
    what_to_state(second)
    for axes in (first, second):
        axes.axis("off")
    return save(figure, folder / f"chamfers{'_narrow' if narrow else ''}", (".svg",))[0]


if __name__ == "__main__":
    to = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
    print(draw(to), draw(to, narrow=True))
