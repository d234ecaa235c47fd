"""How the process of the node ends: at once, whatever libraries still hold, and not unsaid."""

import signal
import time

import pytest

from cli_helpers import IGNORING
from dds_peer import PATIENCE, Peer, node_process, stop
from tiers import nightly

pytestmark = pytest.mark.xdist_group("dds_starts")

# [s] DDS keeps what a killed process had for twice as long.
HALF_A_LEASE = 10.0
# What the end of Python would wait for, as it does for a thread of a library that hangs.
HELD = "import atexit, time; atexit.register(time.sleep, 3600); "
PROGRAMS = {
    "ros2 run": HELD + "from peg_on_hole_ros.ros.node import main; main()",
    "command line": HELD + "import sys; from peg_on_hole_ros.cli.main import main; "
    "sys.argv.insert(1, 'node'); sys.exit(main())",
}


@pytest.mark.parametrize("name", ["command line", *nightly("ros2 run")])
def test_nothing_holds_the_process_behind_its_last_line(name):
    with node_process("-p", "scene.frictoin:=0.2", program=("-c", PROGRAMS[name])) as process:
        printed, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 2
    assert "unknown parameter 'scene.frictoin'" in printed


def test_a_node_that_is_ended_takes_its_topics_back():
    peer = Peer()
    with node_process(program=("-c", PROGRAMS["ros2 run"])) as process:
        peer.wait_for_matching()
        stop(process)
    end = time.monotonic() + HALF_A_LEASE
    while any(taken.get_publisher_count() for taken in peer.subscriptions.values()):
        assert time.monotonic() < end, "its topics stay as those of a process that was killed"
        peer.executor.spin_once(timeout_sec=0.02)
    peer.close()


@pytest.mark.parametrize(("line", "codes"), [("active: ", (0,)), *nightly(("compiling", (130,)))])
def test_sigint_ends_a_node_whose_shell_ignores_it(line, codes, tmp_path, monkeypatch):
    if line == "compiling":
        monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    with node_process(program=("-c", PROGRAMS["command line"]), shell=IGNORING) as process:
        while line not in process.stdout.readline():
            assert process.poll() is None
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=PATIENCE)
    assert process.returncode in codes
