"""
Draw the contacts of a peg with their forces, on the rim and in the hole; needs matplotlib.

    python docs/figures/contacts.py [FOLDER]

Writes contacts.svg to FOLDER (this one by default). The clearance is drawn wide, the tilt large.
The picture is as wide as a telephone, with its panels above each other.
"""

import sys
from math import atan2, cos, degrees, sin
from pathlib import Path

import numpy as np
from matplotlib import rcParams
from matplotlib.figure import Figure
from matplotlib.patches import Wedge

from peg_on_hole_ros.cli.pictures import save
from peg_on_hole_ros.mechanics import reference
from peg_on_hole_ros.mechanics.geometry import (
    contact_geometry,
    contact_points,
    normals,
    velocity_jacobians,
)
from peg_on_hole_ros.mechanics.scene import Scene

HERE = Path(__file__).parent
SCENE = Scene(hole_diameter=1.0, peg_diameter=0.9, peg_height=1.3, friction=0.3)
# Tilts on three contacts and on two, above and below acos(d/D) = 0.451.
ON_RIM, IN_HOLE = 0.62, 0.2
CLOSING = np.array([-1.0, 0.0, 0.0])
COLORS = {"hole": "#333333", "peg": "#1f5fa8", "normal": "#b01e1e", "friction": "#00796b"}


def arrow(axes, start, vector, color, text, offset):
    """Draw a force with its name beside the tip."""
    tip = np.asarray(start) + vector
    style = {"arrowstyle": "-|>", "color": color, "lw": 1.8, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", tip, start, arrowprops=style)
    axes.annotate(text, tip + np.array(offset), color=color, ha="center", va="center")


def hole(axes):
    """Draw the hole, cut along its axis."""
    D = SCENE.hole_diameter
    for side in (-1, 1):
        x = side * D / 2
        block = [[x, 0], [x, -0.95], [side * 1.0, -0.95], [side * 1.0, 0]]
        axes.fill(*np.transpose(block), facecolor="#dddddd", edgecolor=COLORS["hole"], lw=1)


def peg(axes, edge, gamma):
    """Draw a peg that leans to the left, by the right end of its lower edge."""
    d, H = SCENE.peg_diameter, SCENE.peg_height
    across, zeta = np.array([cos(gamma), sin(gamma)]), np.array([-sin(gamma), cos(gamma)])
    corners = [edge, edge + H * zeta, edge + H * zeta - d * across, edge - d * across]
    axes.fill(*np.transpose(corners), facecolor="#cfe0f3", edgecolor=COLORS["peg"], lw=1.4)
    middle = edge - d / 2 * across
    axes.plot(
        *np.transpose([middle, middle + 1.2 * H * zeta]), color=COLORS["peg"], lw=0.7, ls="-."
    )
    return middle, zeta


def cone(axes, point, normal):
    """Draw the cone of forces that a contact can exert."""
    angle, half = degrees(atan2(normal[1], normal[0])), degrees(np.arctan(SCENE.friction))
    axes.add_patch(
        Wedge(point, 0.42, angle - half, angle + half, facecolor=COLORS["normal"], alpha=0.18)
    )


def on_rim(axes):
    """Draw three contacts in the plane of the tilt."""
    g, D = contact_geometry(SCENE, ON_RIM), SCENE.hole_diameter
    zeta, across = np.array([-g.s, g.c]), np.array([g.c, g.s])
    edge = np.array([0.0, g.a1]) - g.a2 * zeta + SCENE.peg_diameter / 2 * across
    hole(axes)
    middle, _ = peg(axes, edge, ON_RIM)
    points, n = contact_points(g, D)[:, [0, 2]], normals(g)[:, [0, 2]]
    J = velocity_jacobians(g, SCENE.peg_diameter, D)
    slip = reference.slip_directions(J, CLOSING, 0.0)[0][:, [0, 2]]
    names = (("K", "$N_K$", (0.1, 0.02)), ("B1, B2", "$N_{B1}, N_{B2}$", (-0.06, -0.12)))
    for i, (name, force, offset) in enumerate(names):
        cone(axes, points[i], n[i] / np.linalg.norm(n[i]))
        arrow(axes, points[i], 0.4 * n[i], COLORS["normal"], force, offset)
        at = (-0.28, 0.02) if i == 0 else (0.22, 0.06)
        arrow(axes, points[i], -0.4 * slip[i], COLORS["friction"], "friction", at)
        axes.plot(*points[i], "ko", ms=4, zorder=5)
        axes.annotate(name, points[i] + ((-0.12, -0.12) if i == 0 else (0.16, -0.12)), ha="center")
    turn = np.pi / 2 + np.linspace(0, ON_RIM, 20)
    O = np.array([0.0, g.a1])
    axes.plot([0, 0], [-0.9, 1.6], color=COLORS["hole"], lw=0.7, ls="-.")
    axes.plot(*(O[:, None] + 1.05 * np.array([np.cos(turn), np.sin(turn)])), "k", lw=1)
    axes.annotate("gamma", O + (-0.33, 1.16), ha="center")
    axes.set_title("on the rim: three contacts, gamma > gamma0", fontsize=10)


def in_hole(axes):
    """Draw two contacts in the plane of the tilt, while the peg slides in."""
    D, d, g = SCENE.hole_diameter, SCENE.peg_diameter, IN_HOLE
    length = (D - d * cos(g)) / sin(g)
    zeta, across = np.array([-sin(g), cos(g)]), np.array([cos(g), sin(g)])
    rim = np.array([-D / 2, 0.0])
    # K is the length along the side above the lower edge, whose other end is B.
    edge = rim - length * zeta + d * across
    hole(axes)
    peg(axes, edge, g)
    axes.plot([0, 0], [-0.9, 1.2], color=COLORS["hole"], lw=0.7, ls="-.")
    contacts = (
        (rim, across, zeta, "K", "$N_K$", (0.1, 0.02), (-0.12, -0.12)),
        (edge, np.array([-1.0, 0.0]), np.array([0.0, 1.0]), "B", "$N_B$", (-0.02, -0.1),
         (0.12, -0.1)),
    )  # fmt: skip
    for point, n, up, name, force, offset, beside in contacts:
        cone(axes, point, n)
        arrow(axes, point, 0.4 * n, COLORS["normal"], force, offset)
        at = (-0.22, 0.04) if name == "K" else (0.25, 0.02)
        arrow(axes, point, 0.4 * up, COLORS["friction"], "friction", at)
        axes.plot(*point, "ko", ms=4, zorder=5)
        axes.annotate(name, point + np.array(beside), ha="center")
    start = rim + np.array([-0.2, 0.0])
    line = {"arrowstyle": "<->", "lw": 1.0, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", start, start - [0, -edge[1]], arrowprops=line)
    axes.annotate("depth", start + [-0.17, edge[1] / 2], ha="center", va="center")
    axes.set_title("in the hole: two contacts, gamma < gamma0", fontsize=10)


def draw(folder: Path) -> Path:
    """Write contacts.svg; the same bytes for the same version of matplotlib."""
    rcParams["font.size"] = 10
    figure = Figure((4.4, 7.6), layout="constrained")
    panels = figure.subplots(2, 1, height_ratios=(2.6, 2.2))
    on_rim(panels[0])
    in_hole(panels[1])
    for axes, top in zip(panels, (1.62, 1.22), strict=True):
        axes.set(xlim=(-1.15, 1.15), ylim=(-0.98, top), aspect="equal")
        axes.axis("off")
    return save(figure, folder / "contacts", (".svg",))[0]


if __name__ == "__main__":
    print(draw(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE))
