"""The guide from a robot to the first estimate, as it is read."""

import os
import re
import subprocess
import sys

import pytest

from cli_helpers import ROOT


def test_the_guide_gives_a_first_estimate_without_a_robot(tmp_path):
    pytest.importorskip("pinocchio")
    for folder in ("bags", "config"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    program = tmp_path / "peg-on-hole"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m peg_on_hole_ros.cli.main "$@"\n')
    program.chmod(0o755)
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PATH": path}

    def run(line):
        done = subprocess.run(
            ["/bin/sh", "-c", line], cwd=tmp_path, env=environment, capture_output=True, text=True
        )
        assert done.returncode == 0, f"{line}\n{done.stderr}"
        return done.stdout

    text = (ROOT / "docs" / "guide.md").read_text(encoding="utf-8").replace("\\\n", " ")
    (copied,) = re.findall(r"^    (cp .*)$", text, re.M)
    run(copied)
    (line,) = re.findall(r"^    (peg-on-hole replay bags/.*)$", text, re.M)
    assert "inserted" in run(line) and (tmp_path / "report.html").stat().st_size > 100_000
    # What was copied finds the URDF beside it.
    told = run("peg-on-hole replay bags/cell_ur_like.mcap --config cell_ur_like.yaml")
    assert "inserted" in told
