"""`peg-on-hole calibrate --payload`: mass, mass centre and zero from still poses."""

import numpy as np
import pytest
import yaml

from cli_helpers import config, fails
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.mechanics.reference import peg_axes
from small_bags import JOINTS, MS, WRENCH, joints, wrench, write_bag
from tiers import nightly

G = np.array([0.0, 0.0, -9.80665])
SENSOR, CENTER = np.array([0.0, 0.0, 0.07]), np.array([0.0, 0.0, 0.035])
MASS, COM = 0.8, np.array([0.01, -0.02, 0.03])
BIAS = np.array([1.5, -2.0, 3.0, 0.04, -0.03, 0.02])
POSES = ([0.05, 0.0, 0.0], [0.5, 0.0, 0.3], [0.5, 1.6, 0.3], [0.6, -1.5, 1.0])


def poses(path, angles, sign=1.0, seed=1):
    """Write a peg of 0.5 kg with a payload, moved from pose to pose and held for 0.6 s."""
    random, t_ns = np.random.default_rng(seed), 10**9
    with BagWriter(path) as bag:
        for k, q in enumerate(angles):
            before = np.array(angles[max(k - 1, 0)])
            for i in range(1000):
                here = before + min(i / 400, 1.0) * (np.array(q) - before)
                R = peg_axes(here).T
                peg, payload = -0.5 * (R @ G), -MASS * (R @ G)
                force = peg + payload
                torque = np.cross(CENTER - SENSOR, peg) + np.cross(COM, payload)
                read = sign * np.r_[force, torque] + BIAS
                read += random.normal(0, [0.2] * 3 + [0.005] * 3)
                bag.write("/wrench", WRENCH, wrench(t_ns, read[:3], read[3:]), t_ns)
                if i % 2 == 0:
                    noise = random.normal(0, 1e-5, 3)
                    bag.write("/joint_states", JOINTS, joints(t_ns, here + noise), t_ns)
                t_ns += MS
    return path


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
    said = "missing: gravity turned about one axis only: the mass centre along x of the sensor is"
    assert said in capsys.readouterr().out

    one = poses(tmp_path / "one.mcap", [[0.3, 0, 0]])
    message = (
        "1 still poses, all with one direction of gravity in the sensor's axes: nothing tells "
        "weight from zero; tilt the peg by 20 degrees and more between them"
    )
    fails(capsys, 2, message, "calibrate", one, "--payload", "--out", out)


@pytest.mark.parametrize(
    ("name", "stated", "taken"),
    [("axes", "base", "sensor"), ("gravity", "compensated", "measured")],
)
def test_wrenches_that_are_no_sensors_own_are_refused(tmp_path, capsys, name, stated, taken):
    path = config(tmp_path, f"wrench: {{{name}: {stated}}}")
    bag = write_bag(tmp_path / "a.mcap")
    message = (
        f"wrench.{name} = '{stated}': calibrate takes wrenches with wrench.{name}: {taken} alone; "
        "record them so"
    )
    out = tmp_path / "found.yaml"
    fails(capsys, 2, message, "calibrate", bag, "--config", path, "--out", out)
    assert not out.exists()
