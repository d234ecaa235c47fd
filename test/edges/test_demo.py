"""The demonstration from end to end: a bag into the real node over DDS, back into figures."""

import os
import re
import subprocess
import sys

import pytest
from mcap.reader import make_reader

from inputs import closing
from peg_on_hole_ros.edges.bags.reader import Bag
from peg_on_hole_ros.edges.bags.writer import LATCHED_QOS, BagWriter
from peg_on_hole_ros.edges.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.edges.messages.output import JOINT_STATE, LATCHED, STRING, TOPICS, joint_state
from peg_on_hole_ros.options import Configuration

pytestmark = pytest.mark.xdist_group("dds")

COUNT = 400


def demo(*arguments):
    command = [sys.executable, "-m", "peg_on_hole_ros.cli.demo", *map(str, arguments)]
    return subprocess.run(command, env=dict(os.environ), capture_output=True, text=True)


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """Write a made-up input whose truth is what the joint states say."""
    path = tmp_path_factory.mktemp("demo") / "closing.mcap"
    start = 10_000_000_000
    with BagWriter(path, Configuration()) as writer:
        writer.write("/truth/contact_mode", STRING, {"data": "three_point"}, start)
        t_ns = start
        for source, message in closing(COUNT):
            stamp = message["header"]["stamp"]
            t_ns = stamp["sec"] * 1_000_000_000 + stamp["nanosec"]
            if source == "joints":
                writer.write("/joint_states", JOINTS_TYPE, message, t_ns)
                angles = joint_state(t_ns, message["name"], message["position"])
                normals = joint_state(t_ns, ("K", "B1", "B2"), effort=(10.0, 5.0, 5.0))
                writer.write("/truth/state", JOINT_STATE, angles, t_ns)
                writer.write("/truth/contacts", JOINT_STATE, normals, t_ns)
            else:
                writer.write("/wrench", WRENCH_TYPE, message, t_ns)
    return path


def test_demo_plays_compares_and_draws(bag, tmp_path):
    run = demo(bag, "--rate", 0.5, "--out", tmp_path / "out")
    assert run.returncode == 0, run.stderr
    found = re.search(r"received (\d+) whole estimates for (\d+) wrenches", run.stdout)
    received, played = map(int, found.groups())
    assert played == COUNT
    # The joint state that starts the estimate may come a little after the first wrenches.
    assert COUNT - 20 <= received <= COUNT
    row = re.search(r"^gamma +rad +([\d.e-]+) .* (\d+)$", run.stdout, re.MULTILINE)
    assert float(row[1]) < 0.01
    assert "there is no transition in the truth" in run.stdout
    assert "\r" not in run.stderr  # no progress where there is no terminal
    out = Bag(tmp_path / "out" / "closing.mcap")
    assert {f"/peg_on_hole/{suffix}" for suffix in TOPICS} <= out.topics.keys()
    with (tmp_path / "out" / "closing.mcap").open("rb") as stream:
        channels = make_reader(stream).get_summary().channels.values()
        latched = {
            c.topic for c in channels if c.metadata == {"offered_qos_profiles": LATCHED_QOS}
        }
    assert latched == {f"/peg_on_hole/{suffix}" for suffix in LATCHED}
    assert (tmp_path / "out" / "closing.png").read_bytes()[:4] == b"\x89PNG"


def test_demo_of_a_missing_bag_is_one_line(tmp_path):
    run = demo(tmp_path / "no.mcap", "--out", tmp_path / "out")
    assert run.returncode == 3
    assert run.stderr == f"make run: error: there is no bag {tmp_path / 'no.mcap'}\n"


def test_demo_at_an_impossible_rate_is_one_line(bag):
    run = demo(bag, "--rate", 0)
    assert run.returncode == 2
    assert run.stderr == "make run: error: --rate = 0 is not within 0.01 to 10\n"
