"""
What a sensor buys: one motion of the six-axis cell, seen by sensors of other rates and noise.

    python -m benchmarks.robot_cells.sensors ROWS_FOLDER

prints the table of docs/guide.md; ROWS_FOLDER has `ur_like.npz` of `robot_cells bags --rows`.
"""

import sys
import tempfile
from contextlib import redirect_stdout
from dataclasses import replace
from io import StringIO
from pathlib import Path

import numpy as np

from benchmarks.robot_cells import __main__ as bags
from benchmarks.robot_cells import sensing
from benchmarks.robot_cells.rows import Rows
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.score import Score
from peg_on_hole_ros.bags.truth import read_truth
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.replay.run import replay_bag

SENSORS = (
    (1, 0.2, 0.005), (1, 1.5, 0.05), (2, 0.2, 0.005), (2, 1.5, 0.05), (2, 5.0, 0.15),
    (10, 0.2, 0.005), (10, 1.5, 0.05),
)  # fmt: skip


def row(rows, every, force, torque, folder):
    """Return what a replay tells of one sensor, as a line of a table."""
    driver = replace(sensing.UR_LIKE, every=every, force_noise=force, torque_noise=torque)
    path = folder / "cell.mcap"
    configuration, _ = load("config/cell_ur_like.yaml")
    wrench = replace(configuration.wrench, force_stddev=force, torque_stddev=torque)
    configuration = replace(configuration, wrench=wrench)
    bags.write(path, rows, "ur_like", configuration, driver)
    bag = Bag(path)
    truth, score, contact = read_truth(bag), None, []
    score = Score(truth)

    class Modes:
        def take(self, columns):
            modes = zip(columns.t_ns.tolist(), columns.modes)
            contact.extend(t_ns for t_ns, mode in modes if mode in ("three_point", "two_point"))

    replay_bag(bag, configuration, 0.0, [score, Modes()])
    touched = next(t for t, m in zip(truth.mode_ns, truth.modes) if m != "open")
    late = (contact[0] - touched) * 1e-6
    (delay, *_), errors = score.flag_delays(), score.rmse()
    loads = ", ".join("-" if errors[c] is None else f"{errors[c]:.1f}" for c in ("K", "B1"))
    share = score.count[3] / max(truth_rows(truth), 1)
    flag = "-" if delay is None else f"{delay * 1e3:.0f}"
    sensor = f"| {1000 // every} | {force:g} | {torque:g}"
    return f"{sensor} | {late:.0f} | {loads} | {share:.0%} | {flag} |"


def truth_rows(truth):
    """Return how many stamps are truly of three contacts."""
    return sum(truth.mode_at(int(t)) == "three_point" for t in truth.t_ns)


def main():
    """Print the table."""
    rows = Rows(**np.load(Path(sys.argv[1]) / "ur_like.npz"))
    with tempfile.TemporaryDirectory() as folder:
        for sensor in SENSORS:
            with redirect_stdout(StringIO()):
                line = row(rows, *sensor, Path(folder))
            print(line, flush=True)


if __name__ == "__main__":
    main()
