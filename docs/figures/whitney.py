"""
Draw Whitney's jamming and wedging diagrams for docs/jamming.md; needs matplotlib.

The picture is as wide as a telephone, with its panels above each other.

    PYTHONPATH=test python docs/figures/whitney.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from paper.two_point import insertion_length
from paper.whitney import jamming_diagram
from peg_on_hole_ros.mechanics.scene import Scene

HERE = Path(__file__).parent
SCENE = Scene()


def jamming(axis):
    """Draw the parallelogram at three lengths in the hole."""
    for share, color in ((0.2, "tab:red"), (0.5, "tab:orange"), (1.0, "tab:blue")):
        length = share * SCENE.peg_diameter
        diagram = jamming_diagram(SCENE.peg_diameter / 2, length, SCENE.friction)
        label = f"l = {share:g} d, lambda = {diagram.ratio:g}"
        x, y = np.vstack([diagram.vertices, diagram.vertices[:1]]).T
        axis.plot(x, y, color=color, label=label)
    axis.axhline(0, color="0.8", zorder=0)
    axis.axvline(0, color="0.8", zorder=0)
    axis.set(xlabel="F_x / F_z", ylabel="M / (r F_z)", title="inside: the load slides the peg in")
    axis.legend(fontsize=9)


def wedging(axis):
    """Draw l/d at which K and B touch, over the tilt, against friction."""
    tilts = np.geomspace(0.0015, SCENE.gamma0, 200)
    for clearance, color in ((1e-4, "tab:blue"), (4e-4, "tab:green")):
        scene = Scene(peg_diameter=SCENE.hole_diameter - clearance)
        at = tilts * scene.gamma0 / SCENE.gamma0
        ratio = insertion_length(scene, at) / scene.peg_diameter
        axis.loglog(at, ratio, color=color, label=f"clearance {clearance * 1e3:g} mm")
        axis.plot(at[-1], ratio[-1], "o", color=color)
    axis.axhspan(1e-2, SCENE.friction, color="tab:red", alpha=0.15)
    axis.text(1.7e-3, 0.035, "can wedge: l/d < friction = 0.2", fontsize=10)
    axis.set(xlabel="gamma [rad]", ylabel="l / d", ylim=(3e-2, 3), title="dots: at gamma0")
    axis.legend(fontsize=9)


def main(folder=HERE):
    """Write the figure."""
    figure, axes = plt.subplots(2, 1, figsize=(4.6, 7.6), layout="constrained")
    jamming(axes[0])
    wedging(axes[1])
    figure.savefig(Path(folder) / "whitney.png", dpi=130)


if __name__ == "__main__":
    main(*sys.argv[1:2])
