"""The guide from a robot to the first estimate, as it is read."""

import re

import pytest

from cli_helpers import ROOT, config, reader
from hand_bags import MASS, POSES, poses, presses
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.parameters_file import read_parameters

GUIDE = (ROOT / "docs" / "guide.md").read_text(encoding="utf-8").replace("\\\n", " ")


@pytest.mark.nightly
def test_the_guide_gives_a_first_estimate_without_a_robot(tmp_path):
    pytest.importorskip("pinocchio")
    run = reader(tmp_path)
    (copied,) = re.findall(r"^    (cp .*)$", GUIDE, re.M)
    run(copied)
    (line,) = re.findall(r"^    (peg-on-hole replay bags/.*)$", GUIDE, re.M)
    assert "inserted" in run(line) and (tmp_path / "report.html").stat().st_size > 100_000
    # What was copied finds the URDF beside it.
    told = run("peg-on-hole replay bags/cell_ur_like.mcap --config cell_ur_like.yaml")
    assert "inserted" in told


def test_each_step_takes_what_the_one_before_it_wrote(tmp_path):
    """Presses, poses and node; what is copied is here a cell with the peg's own joints."""
    run = reader(tmp_path)
    config(tmp_path, "wrench: {acts_on: peg}", "cell_ur_like.yaml")
    for name in ("presses", "poses"):
        (tmp_path / name).mkdir()
    presses(tmp_path / "presses" / "presses_0.mcap", (0.0, 0.0, 0.0), "robot")
    poses(tmp_path / "poses" / "poses_0.mcap", POSES, -1.0)
    for line in re.findall(r"^    (peg-on-hole calibrate .*)$", GUIDE, re.M):
        run(line)
    (started,) = re.findall(r"^    peg-on-hole node --config (\S+)", GUIDE, re.M)
    found = from_parameters(read_parameters(tmp_path / started)).wrench
    assert found.acts_on == "robot"
    assert found.payload_mass == pytest.approx(MASS, abs=0.05)
