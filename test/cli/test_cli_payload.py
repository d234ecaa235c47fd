"""`peg-on-hole calibrate --payload`: mass, mass centre and zero from still poses."""

import numpy as np
import pytest
import yaml

from cli_helpers import config, fails
from hand_bags import BIAS, COM, MASS, POSES, poses
from peg_on_hole_ros.cli.main import main
from small_bags import write_bag
from tiers import nightly


@pytest.mark.parametrize(("acts_on", "sign"), [("robot", -1.0), *nightly(("peg", 1.0))])
def test_payload_and_zero_are_found_within_their_intervals(tmp_path, capsys, acts_on, sign):
    bag, out = poses(tmp_path / "a.mcap", POSES, sign), tmp_path / "found.yaml"
    stated = config(tmp_path, f"wrench: {{acts_on: {acts_on}}}")
    assert (
        main(["calibrate", str(bag), "--payload", "--config", str(stated), "--out", str(out)]) == 0
    )
    told = capsys.readouterr().out
    assert "4 still poses" in told and "missing" not in told
    found = yaml.safe_load(out.read_text())["peg_on_hole"]["ros__parameters"]["wrench"]
    spreads = [float(line.split("+-")[1].split()[0]) for line in told.splitlines() if "+-" in line]
    values = [found["payload_mass"], *found["payload_com"], *found["bias_force"],
              *found["bias_torque"]]  # fmt: skip
    errors = np.abs(np.array(values) - [MASS, *COM, *BIAS])
    # Ten 95 % intervals, of which one may miss by a little.
    assert len(spreads) == 10 and (errors < 2.0 * np.array(spreads)).all()
    assert (np.array(spreads) < [0.05, *[0.01] * 3, *[0.3] * 3, *[0.01] * 3]).all()
    # The peg hangs free then, and nothing contradicts it.
    assert main(["replay", str(bag), "--config", str(out)]) == 0
    assert "wrench: with" not in capsys.readouterr().out


def test_the_pose_that_is_missing_is_named(tmp_path, capsys):
    out = str(tmp_path / "found.yaml")
    two = poses(tmp_path / "two.mcap", [[0.05, 0, 0], [0.5, 0, 0]])
    assert main(["calibrate", str(two), "--payload", "--out", out]) == 0
    said = "gravity turned about one axis only, and the mass centre along x of the sensor is"
    assert said in capsys.readouterr().out

    one = poses(tmp_path / "one.mcap", [[0.3, 0, 0]])
    message = (
        "tilt the peg by 20 degrees and more between still poses: 1 with one direction of gravity "
        "in the sensor's axes do not distinguish weight from bias"
    )
    fails(capsys, 2, message, "calibrate", one, "--payload", "--out", out)


def test_wrenches_that_are_freed_of_weight_are_refused(tmp_path, capsys):
    path = config(tmp_path, "wrench: {gravity: compensated}")
    bag = write_bag(tmp_path / "a.mcap")
    message = (
        "wrench.gravity = 'compensated': calibrate needs wrench.gravity: measured; record the "
        "wrench without compensation of the weight"
    )
    out = tmp_path / "found.yaml"
    fails(capsys, 2, message, "calibrate", bag, "--config", path, "--out", out)
    assert not out.exists()
