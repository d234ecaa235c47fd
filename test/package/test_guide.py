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


def test_the_set_up_at_a_desk_gives_what_the_node_is_started_with(tmp_path):
    pytest.importorskip("pinocchio")
    run = reader(tmp_path)
    line = next(
        each
        for each in re.findall(r"^    (peg-on-hole setup .*)$", GUIDE, re.M)
        if "--yes" in each
    )
    told = run(line)
    page = " ".join(GUIDE.split())
    # What the guide shows of it, digits and all.
    for shown in (
        "0.067 +- 0.25 degrees off it, contradicted by 0.013 N",
        "three presses of 13, 13, 13 N in presses.mcap, off by 1 degrees",
        "0.039 N of it",
        "run.mcap ends 12.8 mm down the hole, 0.41 degrees off it: it fits",
    ):
        assert shown in told and shown in page
    (started,) = re.findall(r"^    peg-on-hole node --config (\S+)", GUIDE, re.M)
    assert from_parameters(read_parameters(tmp_path / started)).wrench.acts_on == "robot"


def test_each_step_takes_what_the_one_before_it_wrote(tmp_path):
    """Presses and poses by themselves; the cell is here one with the peg's own joints."""
    run = reader(tmp_path)
    config(tmp_path, "wrench: {acts_on: peg}", "cell.yaml")
    for name in ("presses", "poses"):
        (tmp_path / name).mkdir()
    presses(tmp_path / "presses" / "presses_0.mcap", (0.0, 0.0, 0.0), "robot")
    poses(tmp_path / "poses" / "poses_0.mcap", POSES, -1.0)
    lines = re.findall(r"^    (peg-on-hole calibrate .*)$", GUIDE, re.M)
    for line in lines:
        run(line)
    found = from_parameters(read_parameters(tmp_path / lines[-1].split()[-1])).wrench
    assert found.acts_on == "robot"
    assert found.payload_mass == pytest.approx(MASS, abs=0.05)
