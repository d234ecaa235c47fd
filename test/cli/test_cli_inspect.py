"""`peg-on-hole inspect` says of a replay what the replay then does."""

import json

import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

from arm import OPTIONS
from cli_helpers import config, fails
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import CONFIGURATION_METADATA, BagWriter
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.configuration import from_parameters
from recorded import INPUTS, Row, write
from simulated import ROOT
from small_bags import JOINTS, MS, WRENCH, joints, wrench
from tiers import nightly


def bag_with(path, parameters=None, metadata=None, wrench_topic="/wrench", position=(0.3, 0, 0)):
    """Write 40 ms with a configuration, or metadata in its place."""
    configuration = None if parameters is None else from_parameters(parameters)
    with BagWriter(path, configuration, metadata) as writer:
        for t_ns in range(10**9, 10**9 + 40 * MS, MS):
            writer.write("/joint_states", JOINTS, joints(t_ns, map(float, position)), t_ns)
            writer.write(wrench_topic, WRENCH, wrench(t_ns), t_ns)
    return path


def told(capsys, *arguments):
    """Return what is told of a replay."""
    assert main(["inspect", *map(str, arguments), "--json"]) == 0
    return json.loads(capsys.readouterr().out)["replay"]


def test_topics_are_those_of_the_configuration_in_the_bag(tmp_path, capsys):
    path = bag_with(tmp_path / "a.mcap", {"topics.wrench": "/ft"}, wrench_topic="/ft")
    replay = told(capsys, path)
    assert replay["possible"] and replay["used"] == {"/ft": 40, "/joint_states": 40}
    # One that is given comes before it, as in a replay.
    given = config(tmp_path, "scene: {friction: 0.3}")
    assert not told(capsys, path, "--config", given)["possible"]


def test_a_configuration_in_the_bag_that_cannot_be_used_stops_only_the_replay(tmp_path, capsys):
    unknown = {CONFIGURATION_METADATA: {"scene.fricton": "0.2"}}
    robot = {
        "joints.source": "robot",
        "joints.urdf": str(tmp_path / "gone.urdf"),
        "joints.tip_frame": "tool",
    }
    for name, path in (
        ("scene.fricton", bag_with(tmp_path / "a.mcap", metadata=unknown)),
        ("gone.urdf", bag_with(tmp_path / "b.mcap", robot)),
    ):
        replay = told(capsys, path)
        assert not replay["possible"] and name in replay["reason"]
        assert replay["used"] == {"/joint_states": 40, "/wrench": 40}
        fails(capsys, 2, replay["reason"], "replay", path)
        assert main(["inspect", str(path)]) == 0
        assert f"a replay is not possible: {replay['reason']}" in capsys.readouterr().out


def test_a_configuration_that_is_given_is_refused_as_by_a_replay(tmp_path, capsys):
    path = bag_with(tmp_path / "a.mcap")
    urdf = tmp_path / "none.urdf"
    robot = f"joints: {{source: robot, urdf: {urdf}, tip_frame: t, names: [j]}}"
    given = config(tmp_path, robot)
    for command in ("inspect", "replay", "calibrate"):
        out = ["--out", tmp_path / "c"] if command == "calibrate" else []
        message = f"joints.urdf: there is no file {urdf}"
        fails(capsys, 2, message, command, path, "--config", given, *out)


def test_joint_states_are_dropped_as_in_a_replay(tmp_path, capsys):
    path = bag_with(tmp_path / "a.mcap", position=(4.0, 0.0, 0.0))
    replay = told(capsys, path)
    assert replay["dropped"] == {"/joint_states: out_of_range": 40}
    assert replay["reason"] == (
        "no message on /joint_states can be used; angles are in radians: degrees? the order of "
        "joints.names? a peg that points up: joints.hole_rpy"
    )


def test_joint_states_of_a_robot_are_dropped_as_in_a_replay(tmp_path, capsys):
    pytest.importorskip("pinocchio")
    names = ", ".join(OPTIONS.names)
    robot = f"source: robot, urdf: {OPTIONS.urdf}, tip_frame: {OPTIONS.tip_frame}"
    given = config(tmp_path, f"joints: {{{robot}, names: [{names}]}}")
    path = tmp_path / "a.mcap"
    with BagWriter(path) as writer:
        for t_ns in range(10**9, 10**9 + 10 * MS, MS):
            message = joints(t_ns, [90.0] * len(OPTIONS.names)) | {"name": list(OPTIONS.names)}
            writer.write("/joint_states", JOINTS, message, t_ns)
            writer.write("/wrench", WRENCH, wrench(t_ns), t_ns)
    replay = told(capsys, path, "--config", given)
    assert replay["dropped"] == {"/joint_states: outside_joint_limits": 10}
    assert not replay["possible"]


def test_what_is_stated_by_half_is_told_of_a_configuration_in_the_bag_too(tmp_path, capsys):
    half = {"wrench.bias_torque_stddev": 0.01}
    given = config(tmp_path, "wrench: {bias_torque_stddev: 0.01}")
    for arguments in (
        [bag_with(tmp_path / "a.mcap", half)],
        [bag_with(tmp_path / "b.mcap"), "--config", given],
    ):
        assert main(["inspect", *map(str, arguments)]) == 0
        said = capsys.readouterr().err
        assert said.count("unless the bias of the forces is known") == 1


def test_all_that_is_unreadable_is_counted_together(tmp_path, capsys):
    # A definition that is another's: what is long enough has no wrench, what is shorter nothing.
    path = bag_with(tmp_path / "a.mcap", wrench_topic="/other")
    with path.open("rb") as stream, (tmp_path / "b.mcap").open("wb") as out:
        writer = Writer(out)
        writer.start(profile="ros2")
        joint_schema = None
        for schema, channel, message in make_reader(stream).iter_messages(["/joint_states"]):
            if joint_schema is None:
                joint_schema = writer.register_schema(schema.name, schema.encoding, schema.data)
                states = writer.register_channel(channel.topic, "cdr", joint_schema)
            writer.add_message(states, message.log_time, message.data, message.log_time)
        strange = writer.register_schema(WRENCH, "ros2msg", b"float64 x")
        wrenches = writer.register_channel("/wrench", "cdr", strange)
        for i, size in enumerate((8, 8, 8, 2, 2)):
            writer.add_message(wrenches, 10**9 + i, b"\0\1\0\0" + bytes(size), 10**9 + i)
        writer.finish()
    assert told(capsys, tmp_path / "b.mcap")["dropped"] == {"/wrench: unreadable": 5}


@pytest.mark.parametrize(
    ("text", "silent"),
    [
        # The peg turns while nobody says so: what comes next is no motion of it.
        *nightly(("{}", (2.5, 5.5)), ("{}", (3.0, 7.5))),
        # What the data say in place of a setting decides what fits from then on.
        ("wrench: {acts_on: robot}", (1.0, 1.0)),
    ],
)
def test_what_a_replay_would_use_is_what_it_uses(tmp_path, capsys, text, silent):
    found = list(Bag(ROOT / "bags" / "working_cycle.mcap").with_payloads(INPUTS))
    begin, end = (found[0][0].log_ns + round(each * 1e9) for each in silent)
    rows = [
        Row(message.topic, message.log_ns, payload)
        for message, payload in found
        if message.topic == "/wrench" or not begin <= message.log_ns < end
    ]
    path, settings = tmp_path / "a.mcap", config(tmp_path, text)
    write(path, rows)
    would = told(capsys, path, "--config", settings)
    summary = tmp_path / "summary.json"
    assert main(["replay", str(path), "--config", str(settings), "--summary", str(summary)]) == 0
    capsys.readouterr()
    messages = json.loads(summary.read_text())["messages"]
    assert sum(would["used"].values()) == messages["used"]
    assert sum(would["dropped"].values()) == sum(messages["dropped"].values())
