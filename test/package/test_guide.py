"""The guide from a robot to the first estimate, as it is read."""

import re

import pytest

from cli_helpers import ROOT, reader


@pytest.mark.nightly
def test_the_guide_gives_a_first_estimate_without_a_robot(tmp_path):
    pytest.importorskip("pinocchio")
    run = reader(tmp_path)
    text = (ROOT / "docs" / "guide.md").read_text(encoding="utf-8").replace("\\\n", " ")
    (copied,) = re.findall(r"^    (cp .*)$", text, re.M)
    run(copied)
    (line,) = re.findall(r"^    (peg-on-hole replay bags/.*)$", text, re.M)
    assert "inserted" in run(line) and (tmp_path / "report.html").stat().st_size > 100_000
    # What was copied finds the URDF beside it.
    told = run("peg-on-hole replay bags/cell_ur_like.mcap --config cell_ur_like.yaml")
    assert "inserted" in told
