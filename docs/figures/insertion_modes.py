"""
Draw a replay of a shipped bag over time: tilt, reactions, contact mode, alarms; needs matplotlib.

    python docs/figures/insertion_modes.py [FOLDER]

Writes insertion_modes.png to FOLDER (this one by default), of `bags/working_cycle.mcap`. The
picture is as wide as a telephone.
"""

import sys
from pathlib import Path
from typing import NamedTuple

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.monitor.states import AlarmLevel, Mode
from peg_on_hole_ros.replay.run import replay_bag

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
NAME = "working_cycle"
# Colours that the colour-blind can distinguish (Okabe and Ito).
CONTACTS = {"$N_K$": "#0072B2", "$N_{B1}$": "#D55E00", "$N_{B2}$": "#009E73"}
MODES = {
    Mode.OPEN: "#56B4E9", Mode.THREE_POINT: "#0072B2", Mode.TWO_POINT: "#009E73",
    Mode.UNKNOWN: "#999999",
}  # fmt: skip
LEVELS = {AlarmLevel.WARN: "#E69F00", AlarmLevel.ERROR: "#D55E00"}
ALARMS = "jamming", "contact_loss", "overload"


class Outputs(NamedTuple):
    """Outputs of a replay over time, see `outputs.Row`; `alarms` has the levels, shape (n, 3)."""

    t: np.ndarray
    gamma: np.ndarray
    normal: np.ndarray
    mode: np.ndarray
    transition: np.ndarray
    alarms: np.ndarray


class Collect:
    """Collects outputs of a replay."""

    def __init__(self):
        self.parts = []

    def take(self, columns):
        """Take outputs of stamps that rise."""
        normal = np.where(
            columns["reactions_determined"][:, None] == 1.0, columns["normal"], np.nan
        )
        self.parts.append(
            Outputs(
                columns.t_ns * 1e-9,
                columns["state"][:, 0].copy(),
                normal,
                columns["contact_mode"].copy(),
                columns["transition"].copy(),
                columns["alarms"]["level"].reshape(len(columns), len(ALARMS)).copy(),
            )
        )


def replayed():
    """Return the outputs of the bag, and gamma0 of its parts [rad]."""
    configuration, _ = load(str(ROOT / "config" / f"{NAME}.yaml"))
    sink = Collect()
    replay_bag(Bag(ROOT / "bags" / f"{NAME}.mcap"), configuration, 0.0, [sink])
    found = Outputs(*(np.concatenate(each) for each in zip(*sink.parts)))
    return found._replace(t=found.t - found.t[0]), configuration.scene.gamma0


def bars(axes, t, on, row, color):
    """Draw when something is so, in a row."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], on.astype(int), [0]])))
    last = len(t) - 1
    spans = [(t[i], t[min(j, last)] - t[i]) for i, j in edges.reshape(-1, 2)]
    axes.broken_barh(spans, (row - 0.35, 0.7), facecolors=color)


def rows(axes, names):
    """Name the rows of a panel, from above."""
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.5)


def draw(folder: Path) -> Path:
    """Write insertion_modes.png."""
    found, gamma0 = replayed()
    figure, (tilt, load_, modes, alarms) = plt.subplots(
        4, 1, figsize=(4.6, 7.8), sharex=True, layout="constrained", height_ratios=(3, 3, 2, 1.6)
    )
    t = found.t
    tilt.plot(t, found.gamma, color="black", lw=1.2)
    tilt.axhline(gamma0, color="0.5", ls="--", lw=1)
    tilt.annotate("gamma0", (t[-1] * 0.01, gamma0), va="bottom", color="0.35")
    tilt.set(title="tilt [rad]", ylim=(0, None))
    for i, (name, color) in enumerate(CONTACTS.items()):
        load_.plot(t, found.normal[:, i], color=color, lw=0.9, label=name)
    load_.set(title="reactions where they are determined [N]", ylim=(0, None))
    load_.legend(fontsize=9, loc="upper left", ncols=3)
    for row, (mode, color) in enumerate(MODES.items()):
        bars(modes, t, found.mode == mode.value, row, color)
    rows(modes, [mode.name.lower() for mode in MODES])
    modes.set_title("contact mode")
    for row in range(len(ALARMS)):
        for level, color in LEVELS.items():
            bars(alarms, t, found.alarms[:, row] == level.value, row, color)
    rows(alarms, ALARMS)
    alarms.set(title="alarms: WARN yellow, ERROR red", xlabel="time [s]")
    for flag in t[1:][np.diff(found.transition.astype(int)) == 1]:
        for panel in (tilt, load_, modes, alarms):
            panel.axvline(flag, color="#CC79A7", lw=1.2)
        tilt.annotate("transition ", (flag, tilt.get_ylim()[1] * 0.9), ha="right", color="#8a3a68")
    for panel in (tilt, load_, modes, alarms):
        panel.grid(alpha=0.3)
    path = folder / "insertion_modes.png"
    figure.savefig(path, dpi=130)
    plt.close(figure)
    return path


if __name__ == "__main__":
    print(draw(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE))
