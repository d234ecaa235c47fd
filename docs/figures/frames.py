"""
Draw the frames of hole, peg and sensor from the package's own geometry; needs matplotlib.

    python docs/figures/frames.py [FOLDER]

Writes frames.svg to FOLDER (this one by default). The clearance is drawn wide, the tilt large.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib import rcParams
from matplotlib.figure import Figure

from peg_on_hole_ros.cli.pictures import save
from peg_on_hole_ros.mechanics.geometry import contact_geometry, contact_points, normals
from peg_on_hole_ros.mechanics.scene import Scene

HERE = Path(__file__).parent
SCENE = Scene(hole_diameter=1.0, peg_diameter=0.9, peg_height=1.5)
GAMMA = 0.62
COLORS = {"hole": "#333333", "peg": "#1f5fa8", "sensor": "#b8560f", "force": "#b01e1e"}


def pose():
    """Return origin O2 and axes eps', zeta of the peg in the plane (h, z), the peg unturned."""
    g = contact_geometry(SCENE, GAMMA)
    zeta = np.array([-g.s, g.c])
    return np.array([0.0, g.a1]) - g.a2 * zeta, np.array([g.c, g.s]), zeta


def arrow(axes, start, vector, color, text, offset=(0.0, 0.0)):
    """Draw an arrow with its name at the tip."""
    tip = np.asarray(start) + vector
    style = {"arrowstyle": "-|>", "color": color, "lw": 1.6, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", tip, start, arrowprops=style)
    axes.annotate(text, tip + np.array(offset), color=color, ha="center", va="center")


def side_view(axes):
    """Draw the plane of symmetry, seen along -e for psi = 0."""
    origin, across, zeta = pose()
    g = contact_geometry(SCENE, GAMMA)
    D, d, H = SCENE.hole_diameter, SCENE.peg_diameter, SCENE.peg_height
    for side in (-1, 1):
        x = side * D / 2
        block = [[x, 0], [x, -0.75], [side * 1.15, -0.75], [side * 1.15, 0]]
        axes.fill(*np.transpose(block), facecolor="#dddddd", edgecolor=COLORS["hole"], lw=1)
    corner = origin + d / 2 * across
    peg = [corner, corner + H * zeta, corner + H * zeta - d * across, corner - d * across]
    axes.fill(*np.transpose(peg), facecolor="#cfe0f3", edgecolor=COLORS["peg"], lw=1.4, alpha=0.8)
    axes.plot([0, 0], [-0.7, 1.75], color=COLORS["hole"], lw=0.7, ls="-.")
    ends = np.array([origin - 0.15 * zeta, origin + 1.95 * zeta])
    axes.plot(*ends.T, color=COLORS["peg"], lw=0.7, ls="-.")
    arrow(axes, (0, 0), np.array([0.75, 0]), COLORS["hole"], "x (h)", (0.05, -0.08))
    arrow(axes, (0, 0), np.array([0, 0.95]), COLORS["hole"], "z", (0.08, 0))
    arrow(axes, origin, 0.62 * across, COLORS["peg"], "x of peg", (0.24, 0.03))
    arrow(axes, origin, 0.75 * zeta, COLORS["peg"], "z of peg", (-0.26, -0.02))
    sensor = origin + (H + 0.12) * zeta
    box = [sensor + a * across + b * zeta for a, b in ((-0.3, -0.12), (0.3, -0.12))]
    box += [point + 0.24 * zeta for point in box[::-1]]
    axes.fill(*np.transpose(box), facecolor="#f6dcc3", edgecolor=COLORS["sensor"], lw=1.4)
    arrow(axes, sensor, 0.5 * across, COLORS["sensor"], "x of sensor", (0.36, 0.02))
    arrow(axes, sensor, 0.5 * zeta, COLORS["sensor"], "z of sensor", (-0.1, 0.08))
    angles = np.pi / 2 + np.linspace(0, GAMMA, 30)
    centre = np.array([0.0, g.a1])
    axes.plot(*(centre[:, None] + 1.05 * np.array([np.cos(angles), np.sin(angles)])), color="k")
    axes.annotate("gamma", centre + 1.15 * np.array([np.cos(1.88), np.sin(1.88)]), ha="center")
    points = contact_points(g, D)[:, [0, 2]]
    forces = normals(g)[:, [0, 2]]
    names = {0: ("K", (-0.09, 0.09)), 1: ("B1, B2", (0.05, -0.1))}
    for i, (name, offset) in names.items():
        axes.plot(*points[i], "o", color=COLORS["force"], ms=5, zorder=5)
        axes.annotate(name, points[i] + offset, color=COLORS["force"], ha="center", va="center")
        arrow(axes, points[i], 0.45 * forces[i], COLORS["force"], f"N_{name[:1]}", (0.07, 0.07))
    for at, place, key in (((0, 0), (0.28, -0.34), "hole"), (origin, (0.28, -0.52), "peg")):
        line = {"arrowstyle": "-", "color": COLORS[key], "lw": 0.6}
        axes.annotate(
            f"origin of {key}", at, place, color=COLORS[key], ha="center", arrowprops=line
        )
    axes.set_title("seen along y of the hole, psi = 0", fontsize=10)
    axes.set(xlim=(-1.75, 1.4), ylim=(-0.78, 2.15), aspect="equal")


def top_view(axes):
    """Draw the rim from above with the contacts, the peg turned by psi."""
    g, psi, D = contact_geometry(SCENE, GAMMA), 0.5, SCENE.hole_diameter
    turn = np.linspace(0, 2 * np.pi, 200)
    axes.plot(D / 2 * np.cos(turn), D / 2 * np.sin(turn), color=COLORS["hole"], lw=1.4)
    arrow(axes, (0, 0), np.array([0.85, 0]), COLORS["hole"], "x", (0.06, 0))
    arrow(axes, (0, 0), np.array([0, 0.85]), COLORS["hole"], "y", (0, 0.07))
    R = np.array([[np.cos(psi), -np.sin(psi)], [np.sin(psi), np.cos(psi)]])
    arrow(axes, (0, 0), R @ [0.85, 0], COLORS["peg"], "h", (0.06, 0.02))
    lean = R @ [-1.0, 0]
    arrow(axes, (0, 0), 0.85 * lean, COLORS["peg"], "the peg leans\nthis way", (0.0, -0.17))
    angles = np.linspace(0, psi, 20)
    axes.plot(0.62 * np.cos(angles), 0.62 * np.sin(angles), color="k")
    axes.annotate("psi", (0.7, 0.17), va="center")
    for name, point in zip(("K", "B1", "B2"), contact_points(g, D)[:, :2]):
        point = R @ point
        axes.plot(*point, "o", color=COLORS["force"], ms=5)
        out = 1.22 if name != "K" else 1.2
        axes.annotate(
            name, out * point + [0, 0.02], color=COLORS["force"], ha="center", va="center"
        )
    axes.set_title("the rim from above", fontsize=10)
    axes.set(xlim=(-1.1, 1.1), ylim=(-1.1, 1.1), aspect="equal")


def draw(folder: Path) -> Path:
    """Write frames.svg; the same bytes for the same version of matplotlib."""
    rcParams["font.size"] = 9
    figure = Figure((9.5, 4.8), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(3, 2))
    side_view(left)
    top_view(right)
    for axes in (left, right):
        axes.axis("off")
    return save(figure, folder / "frames", (".svg",))[0]


if __name__ == "__main__":
    print(draw(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE))
