"""The guide from a recording to the first alarm, done at a desk as it is read."""

import re

import pytest

from cli_helpers import ROOT, reader
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.parameters_file import read_parameters

GUIDE = (ROOT / "docs" / "guide.md").read_text(encoding="utf-8").replace("\\\n", " ")
PAGE = " ".join(GUIDE.split())
# What a desk has: recordings that are shipped, and what a step before wrote.
DESK = re.compile(r"^    (peg-on-hole (?:setup --yes|calibrate|replay) .*)$", re.M)
CONTRADICTED = "joints.hole_rpy=0,0,0"
# Numbers of each step that the guide shows; words around them may change.
SHOWN = {
    "setup --yes --from": (
        "0.067 +- 0.25 degrees", "13, 13, 13 N", "0.80224 kg", "12.8 mm", "0.41 degrees",
    ),
    "setup --yes --config": (),
    "calibrate bags/setup_cell/presses": ("13, 13, 13 N", "acts_on: robot", "axes: base"),
    "calibrate bags/setup_cell/poses": ("0.8022", "+- 0.0055", "5.997", "+- 0.053"),
    "replay bags/setup_cell/hang": ("tare_automatic: 1",),
    "replay bags/setup_cell/run": ("inserted", "3.306", "2.564", "201"),
}  # fmt: skip


@pytest.fixture(scope="module")
def at_a_desk(tmp_path_factory):
    """Run the steps in their order; return the folder, what each printed, and what runs more."""
    pytest.importorskip("pinocchio")
    folder = tmp_path_factory.mktemp("desk")
    run = reader(folder)
    lines = [line for line in DESK.findall(GUIDE) if CONTRADICTED not in line]
    return folder, {line.removeprefix("peg-on-hole "): run(line) for line in lines}, run


def test_every_step_at_a_desk_is_one_of_these(at_a_desk):
    begun = {next(b for b in SHOWN if line.startswith(b)) for line in at_a_desk[1]}
    assert begun == set(SHOWN) and len(at_a_desk[1]) == len(SHOWN)


@pytest.mark.parametrize("begin", SHOWN)
def test_a_step_prints_what_the_guide_shows(at_a_desk, begin):
    printed = next(text for line, text in at_a_desk[1].items() if line.startswith(begin))
    printed = " ".join(printed.split())
    for shown in SHOWN[begin]:
        assert shown in printed and shown in PAGE


def test_the_node_is_started_with_what_was_set_up(at_a_desk):
    folder, *_ = at_a_desk
    (started,) = re.findall(r"^    peg-on-hole node --config (\S+)", GUIDE, re.M)
    wrench = from_parameters(read_parameters(folder / started)).wrench
    assert wrench.acts_on == "robot" and wrench.tare_automatically
    assert (folder / "report.html").stat().st_size > 100_000


def test_a_hole_that_is_stated_upright_is_named(at_a_desk):
    *_, run = at_a_desk
    (line,) = (line for line in DESK.findall(GUIDE) if CONTRADICTED in line)
    with pytest.raises(AssertionError, match="contradicted: joints.hole_rpy") as failed:
        run(line)
    for shown in ("22 +- 0.14 degrees", "[0.11876, 0.37035, 0.022272]"):
        assert shown in str(failed.value) and shown in PAGE


@pytest.mark.nightly
def test_a_copied_configuration_finds_the_robot_beside_it(tmp_path):
    pytest.importorskip("pinocchio")
    run = reader(tmp_path)
    (copied,) = re.findall(r"^    (cp .*)$", GUIDE, re.M)
    run(copied)
    assert "inserted" in run(
        "peg-on-hole replay bags/cell_ur_like.mcap --config cell_ur_like.yaml"
    )
