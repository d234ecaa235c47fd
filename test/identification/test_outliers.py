"""A calibration is that of the recording without what is far off for a moment, and counts it."""

import re

import numpy as np
import pytest
import yaml

from hand_bags import POSES, UP, X, Y, poses, presses
from outlier_bags import J, W, altered
from peg_on_hole_ros.cli.main import main
from simulated import ROOT
from tiers import nightly

# Of force and torque [N], [N m]; of the angles [rad].
FORCE, TORQUE = (0.0, 0.0, -50.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0, 3.0, 0.0)
ABSURD, TILT, TURN = (3e5, -3e5, 8e5, 100.0, 0.0, 0.0), (0.02, 0.0, 0.0), (0.0, 0.0, 0.5)


def calibrated(folder, name, source, off, *arguments):
    """Return exit code, what was written, and what it is written with."""
    bag, out = altered(folder / f"{name}.mcap", source, off), folder / f"{name}.yaml"
    code = main(["calibrate", str(bag), *arguments, "--out", str(out)])
    written = out.read_text(encoding="utf-8") if out.exists() else ""
    return code, yaml.safe_load(written), written


def left_out(text):
    """Return the counts that a text has."""
    line = re.search(r"left out, by reason: (.*)", " ".join(text.split("\n")))
    return dict(re.findall(r"([a-z_]+) (\d+)", line[1])) if line else {}


def same_as_without(tmp_path, capsys, source, off, counts, *arguments):
    without = calibrated(tmp_path, "without", source, dict.fromkeys(off), *arguments)
    assert "left out" not in capsys.readouterr().out + without[2]
    found = calibrated(tmp_path, "off", source, off, *arguments)
    assert found[:2] == without[:2] and found[0] == 0
    counted = {name: str(count) for name, count in counts.items()}
    assert left_out(capsys.readouterr().out) == counted
    assert {name for name in counts if name in found[2]} == set(counts)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recorded")
    pushes = presses(folder / "presses.mcap", (0.0, 0.0, 0.0), "peg", (UP, X, Y))
    return {"payload": poses(folder / "poses.mcap", POSES), "presses": pushes}


@pytest.mark.parametrize(
    ("kind", "off", "counts"),
    [
        ("presses", {(W, 900): ABSURD, (W, 901): FORCE, (W, 903): FORCE}, {"wrench_spike": 3}),
        ("payload", {(W, 700): FORCE, (J, 350): TILT}, {"wrench_spike": 1, "joints_gated": 1}),
        *nightly(
            ("presses", {(W, 0): FORCE, (W, 1800): FORCE, (W, -1): ABSURD}, {"wrench_spike": 3}),
            ("payload", {(W, 700): TORQUE}, {"wrench_spike": 1}),
            ("payload", {(W, 0): FORCE, (W, -1): ABSURD, (W, 900): TORQUE}, {"wrench_spike": 3}),
            ("payload", {(J, 0): TURN, (J, 351): TILT, (J, -1): TURN}, {"joints_gated": 3}),
            (
                "payload",
                {(W, 700): (2e6,) * 6, (W, 800): (np.nan,) * 6, (J, 90): (9.0, 0.0, 0.0)},
                {
                    "wrench_dropped_malformed_out_of_range": 1,
                    "wrench_dropped_malformed_not_finite": 1,
                    "joints_dropped_out_of_range": 1,
                },
            ),
        ),
    ],
)
def test_payload_and_axes_are_those_without_messages_that_are_far_off(
    tmp_path, capsys, recorded, kind, off, counts
):
    same_as_without(tmp_path, capsys, recorded[kind], off, counts, f"--{kind}")


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("off", "counts"),
    [
        ({(W, 5000): FORCE}, {"wrench_spike": 1}),
        ({(W, 400): FORCE}, {"wrench_spike": 1}),
        ({(J, 2500): TILT}, {"joints_gated": 1}),
        (
            {(W, 0): FORCE, (W, 3000): ABSURD, (W, 3001): TORQUE, (J, 1500): TURN, (J, -1): TILT},
            {"wrench_spike": 3, "joints_gated": 2},
        ),
    ],
)
def test_a_cell_is_that_without_messages_that_are_far_off(tmp_path, capsys, off, counts):
    same_as_without(tmp_path, capsys, ROOT / "bags" / "working_cycle.mcap", off, counts)
