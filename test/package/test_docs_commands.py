"""Every command in README and docs: all are understood, those of the tutorial are run in order."""

import os
import re
import shlex
import subprocess
import sys

import pytest

from cli_helpers import ROOT
from peg_on_hole_ros.cli.main import parser

PAGES = [ROOT / "README.md", ROOT / "SECURITY.md", *sorted((ROOT / "docs").rglob("*.md"))]
COMMAND = re.compile(r"^(?:    |> )?((?:peg-on-hole|sed) (?:.*\\\n)*.*)$", re.M)


def commands(page, pattern=COMMAND):
    text = page.read_text(encoding="utf-8")
    return [found.replace("\\\n", " ") for found in pattern.findall(text)]


BLOCKS = [
    pytest.param(line, id=f"{page.stem}: {line[:40]}")
    for page in PAGES
    for line in commands(page)
    if line.startswith("peg-on-hole")
]


def test_there_are_commands_to_test():
    assert len(BLOCKS) > 20


@pytest.mark.parametrize("line", BLOCKS)
def test_each_command_is_understood(line):
    words = shlex.split(line, comments=True)[1:]
    parsed = parser().parse_args([word for word in words if word != ">"])
    assert parsed.command == words[0]


def shell(tmp_path):
    """Return what runs a line of a page in a folder that has the checkout's files."""
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

    return run


def test_the_guide_gives_a_first_estimate_without_a_robot(tmp_path):
    pytest.importorskip("pinocchio")
    run, page = shell(tmp_path), ROOT / "docs" / "guide.md"
    (copied,) = commands(page, re.compile(r"^    (cp .*)$", re.M))
    run(copied)
    (line,) = (line for line in commands(page) if " replay bags/" in line)
    told = run(line)
    assert "inserted" in told and (tmp_path / "report.html").stat().st_size > 100_000
    # What was copied finds the URDF beside it.
    told = run("peg-on-hole replay bags/cell_ur_like.mcap --config cell_ur_like.yaml")
    assert "inserted" in told


def test_the_tutorial_does_what_it_says(tmp_path):
    run = shell(tmp_path)
    lines = commands(ROOT / "docs" / "tutorial.md")
    assert len(lines) >= 7
    told = {(line.split()[1], line.split()[2]): run(line) for line in lines}
    made = {path.name for path in tmp_path.iterdir()}
    assert {"out.mcap", "report.html", "half.mcap", "both.html", "calibrated.yaml"} <= made
    # The setting was found in the file, and has an effect.
    assert "friction: 0.1" in (tmp_path / "half.yaml").read_text(encoding="utf-8")
    assert "scene.friction" in told["compare", "whole.mcap"]
    replayed = told["replay", "bags/working_cycle.mcap"]
    assert "aborted" in replayed and "inserted" in replayed
