"""What the tests of the command line share."""

import json
import os
import resource
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

from peg_on_hole_ros.cli.main import main

ROOT = Path(__file__).parents[1]
SCHEMA = json.loads((ROOT / "docs" / "summary.schema.json").read_text(encoding="utf-8"))
# What SIGINT has a shell pass on to what it starts, as a script does to what is in its background.
IGNORING = ("sh", "-c", 'trap "" INT; exec "$@"', "sh")
# [s] after SIGINT: two at rest, more where other tests have the cores.
ENDS = 10.0
COMMANDS = ["replay", "simulate", "solve", "plan", "inspect", "calibrate", "compare", "node"]


@contextmanager
def largest_file(size):
    """Let no file grow beyond a number of bytes: to whoever writes that is a full disk."""
    # Python ignores the signal.
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@contextmanager
def watching(begin, *options, errors=subprocess.STDOUT, shell=()):
    """
    Run `watch` on a port; yield the address that follows the begin of its line.

    It has to end by SIGINT in time, whoever is still connected. Its errors may go to a file.
    """
    program = [sys.executable, "-m", "peg_on_hole_ros.cli.main", "watch", *options]
    process = subprocess.Popen(
        [*shell, *program],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=errors,
        text=True,
    )
    try:
        line = process.stdout.readline()
        assert line.startswith(begin), line
        yield line.removeprefix(begin).split()[0]
        begun = time.monotonic()
        process.send_signal(2)
        rest, _ = process.communicate(timeout=60)
        assert process.returncode == 0 and rest == ""
        assert time.monotonic() - begun < ENDS
    finally:
        process.kill()
        process.communicate()


def command(*arguments, cwd=None):
    """Run the real command in a process of its own."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, "-m", "peg_on_hole_ros.cli.main", *map(str, arguments)],
        capture_output=True,
        text=True,
        env=environment,
        cwd=cwd,
        timeout=120,
        check=False,
    )


def fails(capsys, code, message, *arguments):
    """Run in this process; the error is one line, exactly this one."""
    assert main([str(a) for a in arguments]) == code
    assert capsys.readouterr().err.splitlines()[-1] == f"peg-on-hole: error: {message}"


def config(tmp_path, text, name="c.yaml"):
    path = tmp_path / name
    path.write_text("peg_on_hole:\n  ros__parameters:\n    " + text + "\n", encoding="utf-8")
    return path


def reader(folder):
    """Return what runs a line of a page, in a folder that has the checkout's files."""
    for name in ("bags", "config"):
        (folder / name).symlink_to(ROOT / name)
    program = folder / "peg-on-hole"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m peg_on_hole_ros.cli.main "$@"\n')
    program.chmod(0o755)
    path = f"{folder}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PATH": path}

    def run(line):
        done = subprocess.run(
            ["/bin/sh", "-c", line], cwd=folder, env=environment, capture_output=True, text=True
        )
        assert done.returncode == 0, f"{line}\n{done.stderr}"
        return done.stdout

    return run
