"""What starting costs is held by structure: what is imported, compiled and told, never by time."""

import os
import pty
import subprocess
import sys

import pytest

from cli_helpers import COMMANDS, ROOT
from peg_on_hole_ros.startup.compiling import log_quarters

HEAVY = {
    "numpy", "scipy", "numba", "llvmlite", "yaml", "mcap", "mcap_ros2", "rosbags", "rclpy",
    "matplotlib", "plotly", "rich", "filterpy", "zstandard",
}  # fmt: skip
IMPORTED = """
import contextlib, sys
from peg_on_hole_ros.cli.main import main
with contextlib.suppress(SystemExit):
    main(sys.argv[1:])
print("\\n".join({name.partition(".")[0] for name in sys.modules}), file=sys.stderr)
"""
COMPILES = """
import sys
from peg_on_hole_ros.cli import main
sys.argv[0] = "peg-on-hole"
sys.exit(main.main(sys.argv[1:]))
"""


def imported(*arguments):
    done = subprocess.run(
        [sys.executable, "-c", IMPORTED, *arguments],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout, set(done.stderr.split())


@pytest.mark.parametrize(
    "arguments", [["--help"], ["--version"], *([c, "--help"] for c in [*COMMANDS, "watch"])]
)
def test_help_imports_nothing_heavy(arguments):
    told, found = imported(*arguments)
    assert told.startswith(("usage: peg-on-hole", "peg-on-hole "))
    assert found & HEAVY == set()


def test_a_replay_without_report_imports_none():
    bag = ROOT / "bags" / "closing_without_slip.mcap"
    told, found = imported("replay", str(bag))
    assert "717 outputs" in told and "numba" in found
    assert found & {"plotly", "matplotlib", "rosbags", "rclpy", "filterpy", "rich"} == set()


def on_terminal(cache, *command):
    """Run a command whose errors go to a terminal; return what stands there."""
    ours, theirs = pty.openpty()
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "XDG_CACHE_HOME": str(cache)}
    environment.pop("NUMBA_CACHE_DIR", None)
    subprocess.run(command, env=environment, stdout=subprocess.DEVNULL, stderr=theirs, check=True)
    os.close(theirs)
    text = b""
    try:
        while part := os.read(ours, 65536):
            text += part
    except OSError:  # the end of a terminal that nobody holds any more
        pass
    os.close(ours)
    return text.decode()


@pytest.mark.nightly
def test_compiling_is_told_with_progress_and_done_once_for_all_ways_of_starting(tmp_path):
    # Looking through a bag compiles one function, in seconds; of these topics it has none.
    bag = str(ROOT / "bags" / "closing_without_slip.mcap")
    looking = "inspect", bag, "--wrench-topic", "/none", "--joints-topic", "/neither"
    first = on_terminal(tmp_path, sys.executable, "-m", "peg_on_hole_ros.cli.main", *looking)
    line, _, rest = first.partition("\r\n")
    assert line == "compiling, for the first start of this version only: one to four minutes"
    assert "compiling   0 %" in rest
    (folder,) = (tmp_path / "peg_on_hole_ros").iterdir()
    kept = sorted(folder.rglob("*.nb*"))
    assert kept
    again = on_terminal(tmp_path, sys.executable, "-c", COMPILES, *looking)
    assert "compiling" not in again
    assert sorted(folder.rglob("*.nb*")) == kept


def test_a_log_is_told_how_long_compiling_takes_and_each_quarter_once():
    lines = []
    tell = log_quarters(lines.append)
    for share in (0.0, 0.1, 0.3, 0.31, 0.8, 1.0):
        tell(share)
    assert lines[0].endswith("first start of this version only: one to four minutes")
    assert lines[1:] == ["compiling: 25 %", "compiling: 75 %", "compiling: 100 %"]
