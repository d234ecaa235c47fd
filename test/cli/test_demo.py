"""The demonstration from end to end: a bag into the real node over DDS, back into figures."""

import os
import re
import subprocess
import sys

import pytest
from mcap.reader import make_reader
from mcap.writer import IndexType, Writer

from cli_helpers import ROOT
from inputs import closing
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import LATCHED_QOS, BagWriter
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.messages.beside_estimates import (
    JOINT_STATE,
    LATCHED,
    STRING,
    TOPICS,
    joint_state,
)
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE

pytestmark = pytest.mark.xdist_group("dds")

COUNT = 400


def demo(*arguments, cwd=None):
    command = [sys.executable, "-m", "peg_on_hole_ros.cli.demo", *map(str, arguments)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(command, env=environment, cwd=cwd, capture_output=True, text=True)


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


def test_demo_plays_compares_and_draws(tmp_path):
    """A shipped bag: first figures are those of what is determined, and say how they are meant."""
    run = demo(ROOT / "bags" / "closing_without_slip.mcap", "--out", tmp_path / "out")
    assert run.returncode == 0, run.stderr
    found = re.search(r"received (\d+) whole estimates for (\d+) wrenches", run.stdout)
    received, played = map(int, found.groups())
    assert played == 717
    # The joint state that starts the estimate may come a little after the first wrenches.
    assert played - 20 <= received <= played
    rows = dict(re.findall(r"^(gamma|N_K(?:, not determined)?) +m?\w+ +(.*)$", run.stdout, re.M))
    # Orientations have a noise of 0.1 mrad; the wrench tells more.
    error, _, _, compared = rows["gamma"].split()
    assert 0 < float(error) < 0.1 and int(compared) == received
    # It wedges at its end: from there on nothing is determined, and is no part of the first row.
    error, _, inside, determined = rows["N_K"].split()
    undetermined = int(rows["N_K, not determined"].split()[-1])
    # Some 60 N, known to 0.4 N; what is not determined would be off by tens.
    assert float(error) < 2.0 and float(inside.rstrip("%")) > 85.0
    assert 0 < undetermined < int(determined) and int(determined) + undetermined <= received
    assert "inside 95 % bounds: share of the samples" in run.stdout
    assert "not determined (reactions_determined = 0)" in run.stdout
    assert "there is no transition in the truth" in run.stdout
    assert "\r" not in run.stderr  # no progress where there is no terminal
    out = Bag(tmp_path / "out" / "closing_without_slip.mcap")
    # The try has not ended when the player goes.
    expected = {f"/peg_on_hole/{suffix}" for suffix in TOPICS} - {"/peg_on_hole/cycle"}
    assert expected <= out.topics.keys()
    with out.path.open("rb") as stream:
        channels = make_reader(stream).get_summary().channels.values()
        latched = {
            c.topic for c in channels if c.metadata == {"offered_qos_profiles": LATCHED_QOS}
        }
    assert latched == {f"/peg_on_hole/{suffix}" for suffix in LATCHED}
    picture = tmp_path / "out" / "closing_without_slip.png"
    assert picture.read_bytes()[:4] == b"\x89PNG"


def test_demo_of_a_missing_bag_is_one_line(tmp_path):
    run = demo(tmp_path / "no.mcap", "--out", tmp_path / "out")
    assert run.returncode == 3
    assert run.stderr == f"make run: error: there is no bag {tmp_path / 'no.mcap'}\n"


def test_demo_at_an_impossible_rate_is_one_line(bag):
    run = demo(bag, "--rate", 0)
    assert run.returncode == 2
    assert run.stderr == "make run: error: --rate = 0 is not within 0.01 to 10\n"


def parts_of(bag, folder):
    """
    Write a bag as a killed recorder leaves it, and return how many wrenches can be read.

    Two parts without summaries in a folder without metadata.yaml, the second of them cut off, and
    a wrench that is no more than a header's begin.
    """
    folder.mkdir()
    with bag.open("rb") as stream:
        rows = [(s, c, m) for s, c, m in make_reader(stream).iter_messages()]
    half = len(rows) // 2
    bare = {
        "index_types": IndexType.NONE, "use_statistics": False, "use_summary_offsets": False,
        "repeat_channels": False, "repeat_schemas": False, "chunk_size": 4000,
    }  # fmt: skip
    for k, part in enumerate((rows[:half], rows[half:])):
        path, channels = folder / f"{folder.name}_{k}.mcap", {}
        with path.open("wb") as stream:
            writer = Writer(stream, **bare)
            writer.start(profile="ros2")
            for schema, channel, message in part:
                if channel.topic not in channels:
                    known = writer.register_schema(schema.name, schema.encoding, schema.data)
                    channels[channel.topic] = writer.register_channel(channel.topic, "cdr", known)
                key, t_ns = channels[channel.topic], message.log_time
                writer.add_message(key, t_ns, message.data, t_ns)
            if not k:
                writer.add_message(channels["/wrench"], t_ns, message.data[:8], t_ns)
            writer.finish()
        with path.open("rb") as stream:
            assert make_reader(stream).get_summary() is None
    with path.open("r+b") as stream:
        stream.truncate(path.stat().st_size * 3 // 4)
    return Bag(folder).topics["/wrench"].count - 1


@pytest.mark.nightly
def test_demo_plays_what_a_killed_recorder_leaves_as_far_as_replay_does(bag, tmp_path, capsys):
    folder, out = tmp_path / "rb", tmp_path / "out"
    readable = parts_of(bag, folder)
    assert COUNT / 2 < readable < COUNT
    assert main(["replay", str(folder)]) == 4
    damage = capsys.readouterr().err.splitlines()[-1].removeprefix("peg-on-hole: ")
    run = demo(folder, "--out", out)
    assert run.returncode == 4, run.stderr
    assert run.stderr == f"make run: {damage}\n"
    assert f"played {readable} wrenches in " in run.stdout
    assert "not played, as they do not fit their definition: 1 on /wrench" in run.stdout
    assert f"for {readable} wrenches" in run.stdout
    assert (out / "rb.png").read_bytes()[:4] == b"\x89PNG"
    assert "/peg_on_hole/state" in Bag(out / "rb.mcap").topics


def test_the_player_keeps_the_pace_of_a_bag_and_its_bytes(bag):
    with bag.open("rb") as stream:
        reader = make_reader(stream)
        begun = reader.get_summary().statistics.message_start_time
        rows = list(reader.iter_messages(["/wrench", "/joint_states"]))
    from peg_on_hole_ros.ros.bag_publisher import recorded

    played = list(recorded(Bag(bag), ["/wrench", "/joint_states"]))
    assert [row[1:] for row in played] == [
        (message.log_time - begun, channel.topic, message.data) for _, channel, message in rows
    ]
    assert [row[0] for row in played] == sorted(row[0] for row in played)
    assert played[-1][0] == pytest.approx(1.0)


@pytest.mark.nightly
def test_truth_of_no_use_does_not_keep_the_demo_from_its_end(tmp_path):
    path = tmp_path / "a.mcap"
    with BagWriter(path, Configuration()) as writer:
        for source, message in closing(60):
            stamp = message["header"]["stamp"]
            t_ns = stamp["sec"] * 1_000_000_000 + stamp["nanosec"]
            joints = source == "joints"
            topic, kind = ("/joint_states", JOINTS_TYPE) if joints else ("/wrench", WRENCH_TYPE)
            writer.write(topic, kind, message, t_ns)
        for topic in ("/truth/state", "/truth/contacts", "/truth/contact_mode"):
            writer.write(topic, STRING, {"data": "three_point"}, t_ns)
    run = demo(path, "--out", tmp_path / "out")
    assert run.returncode == 0, run.stderr
    assert run.stderr.startswith("no comparison with the truth: ")


@pytest.mark.parametrize(
    "arguments",
    [pytest.param(("{bag}", "--out", ""), marks=pytest.mark.nightly), ("", "--out", "out")],
)
def test_an_empty_path_is_an_error_and_not_the_current_folder(arguments, bag, tmp_path):
    run = demo(*(word.format(bag=bag) for word in arguments), cwd=tmp_path)
    assert run.returncode == 2
    what = "folder" if arguments[0] else "bag"
    assert run.stderr.startswith(f"make run: error: the path of the {what} is empty; name ")
    assert len(run.stderr.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []
