"""`peg-on-hole calibrate --presses`: sensor_rpy and acts_on from three presses of a hand."""

import re
from itertools import product

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from cli_helpers import config, fails
from hand_bags import UP, X, Y, presses
from peg_on_hole_ros.cli.main import main
from tiers import nightly


def found(bag, tmp_path, *stated):
    out = tmp_path / "found.yaml"
    assert main(["calibrate", str(bag), "--presses", *map(str, stated), "--out", str(out)]) == 0
    return yaml.safe_load(out.read_text())["peg_on_hole"]["ros__parameters"]["wrench"]


def apart(found, rpy):
    """Degrees between two orientations."""
    turn = Rotation.from_euler("xyz", found).inv() * Rotation.from_euler("xyz", rpy)
    return np.degrees(turn.magnitude())


@pytest.mark.parametrize(
    ("rpy", "acts_on"),
    [
        ((0.0, 0.0, 0.0), "peg"),
        ((np.pi, 0.0, -np.pi / 2), "robot"),
        *nightly(
            ((0.0, 0.0, 0.0), "robot"),
            *product([(np.pi, 0.0, 0.0), (0.0, np.pi / 2, 0.0)], ["peg", "robot"]),
            ((np.pi, 0.0, -np.pi / 2), "peg"),
        ),
    ],
)
def test_a_hand_that_misses_finds_the_quarter_turn(tmp_path, capsys, rpy, acts_on):
    # Up to 14 degrees off, each press another way.
    pushes = [UP + 0.2 * X, X + 0.2 * Y - 0.1 * UP, Y - 0.25 * X]
    pushes = [push / np.linalg.norm(push) for push in pushes]
    wrench_found = found(presses(tmp_path / "a.mcap", rpy, acts_on, pushes), tmp_path)
    assert wrench_found["acts_on"] == acts_on
    assert apart(wrench_found["sensor_rpy"], rpy) < 0.01
    forces = re.search("three presses of (.*) N: up, x, y", capsys.readouterr().out)[1].split(", ")
    # The mean of what is above 0.7 of a half wave of 25 N.
    assert [float(force) for force in forces] == pytest.approx([22.4] * 3, abs=1.0)


def test_a_sensor_at_an_angle_of_its_own_stays_there(tmp_path):
    rpy = (np.pi, 0.0, np.radians(35.0))
    wrench_found = found(presses(tmp_path / "a.mcap", rpy, "robot"), tmp_path)
    assert wrench_found["acts_on"] == "robot"
    assert apart(wrench_found["sensor_rpy"], rpy) < 1.0


@pytest.mark.parametrize("pushes", [(UP, X), (UP, X, Y, X)])
def test_another_number_of_presses_says_what_to_do(tmp_path, capsys, pushes):
    bag = presses(tmp_path / "a.mcap", (0.0, 0.0, 0.0), "peg", pushes)
    message = (
        "push the still peg up at its lower end, then along its x, then along its y, with 5 N and "
        "more for 0.3 s and more, and a pause between: the recording has "
        f"{len(pushes)} such presses, not 3"
    )
    fails(capsys, 2, message, "calibrate", bag, "--presses", "--out", tmp_path / "o.yaml")


def test_presses_along_one_line_are_refused(tmp_path, capsys):
    bag = presses(tmp_path / "a.mcap", (0.0, 0.0, 0.0), "peg", (UP, X, (X + 0.2 * Y) / 1.02))
    assert main(["calibrate", str(bag), "--presses", "--out", str(tmp_path / "o.yaml")]) == 2
    assert "degrees off three right angles" in capsys.readouterr().err


@pytest.mark.parametrize("acts_on", ["robot", "peg"])
@pytest.mark.parametrize("axes", ["base", "sensor"])
def test_numbers_in_axes_that_stand_still_are_found_whatever_is_stated(tmp_path, acts_on, axes):
    """A driver that sends base axes; at the tilt of the peg these are no quarter turn."""
    bag = presses(tmp_path / "a.mcap", None, acts_on, held=(0.9, 0.5, 0.4))
    stated = config(tmp_path, f"wrench: {{axes: {axes}, sensor_rpy: [0.0, 0.0, 0.3]}}")
    wrench_found = found(bag, tmp_path, "--config", stated)
    assert wrench_found["acts_on"] == acts_on and wrench_found["axes"] == "base"
    # Of the sensor nothing is seen.
    assert wrench_found["sensor_rpy"] == [0.0, 0.0, 0.3]


def test_numbers_of_the_sensor_are_found_where_the_base_is_stated(tmp_path):
    bag = presses(tmp_path / "a.mcap", (np.pi, 0.0, 0.0), "robot", held=(0.9, 0.5, 0.4))
    wrench_found = found(bag, tmp_path, "--config", config(tmp_path, "wrench: {axes: base}"))
    assert wrench_found["axes"] == "sensor"
    assert apart(wrench_found["sensor_rpy"], (np.pi, 0.0, 0.0)) < 0.01


@pytest.mark.parametrize("axes", ["base", "sensor"])
def test_a_pose_in_which_both_look_the_same_keeps_what_is_stated(tmp_path, capsys, axes):
    bag = presses(tmp_path / "a.mcap", None, "peg", held=(0.1, 0.0, 0.1))
    stated = config(tmp_path, f"wrench: {{axes: {axes}}}")
    assert found(bag, tmp_path, "--config", stated)["axes"] == axes
    other = "sensor" if axes == "base" else "base"
    assert f"the axes of {other} look the same" in capsys.readouterr().out


def test_base_axes_without_joint_states_are_refused(tmp_path, capsys):
    bag = presses(tmp_path / "a.mcap", (0.0, 0.0, 0.0), "peg")
    stated = config(tmp_path, "wrench: {axes: base}")
    message = (
        "record the joint states too: with wrench.axes: base presses need the peg's orientation, "
        f"and {bag} has no joint state that can be used"
    )
    out = tmp_path / "o.yaml"
    fails(capsys, 3, message, "calibrate", bag, "--presses", "--config", stated, "--out", out)
