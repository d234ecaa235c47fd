"""The sensor's pose by the link that frame_id names, and a description that is in the bag."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from arm import OPTIONS, URDF, Arm
from cli_helpers import fails
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import URDF_METADATA, BagWriter
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.configuration import to_parameters
from peg_on_hole_ros.config.options import Configuration, WrenchInput
from peg_on_hole_ros.config.parameters_file import write_parameters
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.messages.beside_estimates import STRING, joint_state
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.plain import header
from peg_on_hole_ros.messages.stream import message_stream
from peg_on_hole_ros.robot.sensor_frame import mounting
from peg_on_hole_ros.robot.urdf_source import awaited

MS = 1_000_000
TEXT = URDF.read_text(encoding="utf-8")


def configuration(joints=OPTIONS, **wrench):
    return Configuration(wrench=WrenchInput(**wrench), joints=joints)


def expected(link):
    """Pose of a link in the peg frame by the arm's own formulas, at any joints."""
    joints = {f"arm_{i}": 0.1 * i for i in range(1, 8)} | {"finger_left": 0.0, "finger_right": 0.0}
    (p_T, R_T, _), (p_S, R_S, _) = (
        Arm(tip=name).tip(joints) for name in (OPTIONS.tip_frame, link)
    )
    R_P = R_T * Rotation.from_euler("xyz", OPTIONS.peg_rpy)
    p_P = p_T + R_T.apply(OPTIONS.peg_xyz)
    return R_P.inv().apply(p_S - p_P), R_P.inv() * R_S


@pytest.mark.parametrize("link", ["ft_sensor", "flange", "tool"])
def test_pose_of_a_link_that_is_rigid_with_the_tip(link):
    found = mounting(configuration(), link)
    xyz, rotation = expected(link)
    assert found.wrench.sensor_xyz == pytest.approx(xyz, abs=1e-8)
    turn = Rotation.from_euler("xyz", found.wrench.sensor_rpy).inv() * rotation
    assert turn.magnitude() < 1e-8
    assert found.line.startswith(f"sensor: at '{link}', wrench.sensor_xyz: [")
    # What is found agrees with itself, and is not told again.
    again = mounting(replace(configuration(), wrench=found.wrench), link)
    assert again == (found.wrench, "")


def test_of_a_chamfered_peg_the_sensors_place_counts_from_the_shoulder():
    """What the URDF has of sensor and tip stays; the shoulder is nearer to the sensor."""
    sharp = configuration()
    chamfered = replace(sharp, scene=replace(sharp.scene, peg_chamfer=4e-4, hole_chamfer=7e-4))
    found, before = (
        np.array(mounting(c, "ft_sensor").wrench.sensor_xyz) for c in (chamfered, sharp)
    )
    assert before - found == pytest.approx([0.0, 0.0, 4e-4], abs=1e-9)


def test_what_is_stated_and_contradicts_is_an_error_unless_it_is_meant():
    xyz = tuple(expected("ft_sensor")[0] + [0.0, 0.0, 2e-3])
    with pytest.raises(PegOnHoleError) as error:
        mounting(configuration(sensor_xyz=xyz), "ft_sensor")
    text = str(error.value)
    assert text.startswith(f"wrench.sensor_xyz = {list(xyz)} is not where ")
    assert text.endswith("take it out, or state wrench.sensor_pose: stated")
    meant = configuration(sensor_xyz=xyz, sensor_pose="stated")
    assert mounting(meant, "ft_sensor") == (meant.wrench, "")
    with pytest.raises(PegOnHoleError, match="^wrench.sensor_rpy = "):
        mounting(configuration(sensor_rpy=(0.0, 0.0, 1.0)), "ft_sensor")
    near = configuration(sensor_xyz=tuple(expected("ft_sensor")[0] + [5e-4, 0.0, 0.0]))
    used = mounting(near, "ft_sensor").wrench
    assert used.sensor_xyz == near.wrench.sensor_xyz
    assert used.sensor_rpy != near.wrench.sensor_rpy


@pytest.mark.parametrize(
    ("frame", "text"),
    [
        ("sensor_link", "frame_id 'sensor_link' of the wrench is no link of "),
        ("", "frame_id '' of the wrench is no link of "),
        ("base", "frame_id 'base' of the wrench is a link that tool moves against: numbers in "),
    ],
)
def test_a_frame_that_tells_no_pose_is_told_where_none_is_stated(frame, text):
    found = mounting(configuration(), frame)
    assert found.wrench == WrenchInput() and found.line.startswith(text)
    stated = configuration(sensor_xyz=(0.0, 0.0, 0.1))
    assert mounting(stated, frame) == (stated.wrench, "")


def test_a_tip_that_is_no_link_is_no_matter_of_the_sensor():
    wrong = configuration()
    wrong = replace(wrong, joints=replace(wrong.joints, tip_frame="tol"))
    assert mounting(wrong, "ft_sensor") == (wrong.wrench, "")


def test_the_pegs_own_angles_have_no_links():
    plain = Configuration()
    assert mounting(plain, "anything") == (plain.wrench, "")


def write_bag(path, frame="ft_sensor", description=TEXT, late=0, before=()):
    """
    A bag of an arm at rest; its description comes after some messages, as recorders write.

    Others may come before it.
    """
    names = [f"arm_{i}" for i in range(1, 8)]
    arm = Arm()
    upright = Rotation.from_euler("y", -0.2)
    q = arm.joints_at(np.zeros(3), upright, [0.3, 0.5, -0.2, 1.2, 0.3, -1.1, 0.4])
    zero = dict(zip("xyz", (0.0, 0.0, 0.0)))
    with BagWriter(path) as bag:
        for k in range(100):
            t_ns = 10**9 + k * MS
            if k < len(before):
                bag.write("/robot_description", STRING, {"data": before[k]}, t_ns)
            if k == late and description:
                bag.write("/robot_description", STRING, {"data": description}, t_ns)
            if k % 2 == 0:
                bag.write("/joint_states", JOINTS_TYPE, joint_state(t_ns, names, q), t_ns)
            wrench = {"force": {**zero, "z": -5.0}, "torque": zero}
            bag.write(
                "/wrench", WRENCH_TYPE, {"header": header(t_ns, frame), "wrench": wrench}, t_ns
            )
    return path


def parameters_file(tmp_path, urdf="topic", **wrench):
    found = to_parameters(configuration(replace(OPTIONS, urdf=urdf), **wrench))
    path = tmp_path / "cell.yaml"
    path.write_text(write_parameters(found), encoding="utf-8")
    return path


def replayed(bag, config, tmp_path):
    out, summary = tmp_path / "out.mcap", tmp_path / "s.json"
    arguments = ["replay", bag, "--config", config, "--out", out, "--summary", summary]
    assert main([str(a) for a in arguments]) == 0
    return Bag(out), json.loads(summary.read_text())


def test_a_replay_takes_description_and_pose_from_the_bag(tmp_path, capsys):
    pytest.importorskip("pinocchio")
    bag = write_bag(tmp_path / "a.mcap", late=40)
    out, summary = replayed(bag, parameters_file(tmp_path), tmp_path)
    assert summary["messages"]["used"] == 150
    assert capsys.readouterr().err.count("sensor: at 'ft_sensor', wrench.sensor_xyz: [") == 1
    # Who replays the output needs neither topic nor file, and has the pose that was used.
    assert out.metadata[URDF_METADATA]["text"] == TEXT
    stored = json.loads(out.metadata["peg_on_hole_configuration"]["wrench.sensor_xyz"])
    assert stored == pytest.approx(expected("ft_sensor")[0], abs=1e-8)


def test_a_bag_without_the_description_is_refused_with_what_to_do(tmp_path, capsys):
    bag = write_bag(tmp_path / "a.mcap", description=None)
    config = parameters_file(tmp_path)
    message = (
        f"{bag} has no messages on /robot_description (std_msgs/msg/String); it has: "
        "/joint_states (sensor_msgs/msg/JointState, 50), /wrench "
        "(geometry_msgs/msg/WrenchStamped, 100); name the robot's description as a file in "
        "joints.urdf"
    )
    fails(capsys, 3, message, "replay", bag, "--config", config)
    # Looked at, it says so and tells all else.
    assert main(["inspect", str(bag), "--config", str(config)]) == 0
    assert f"a replay is not possible: {message}" in capsys.readouterr().out


FOREIGN = "<robot name='gripper'><link name='hand'/></robot>"


@pytest.mark.parametrize("first", ["", FOREIGN, "no XML"])
def test_the_first_description_that_is_this_robots_is_used(tmp_path, first):
    bag = write_bag(tmp_path / "a.mcap", late=40, before=[first, first])
    out, summary = replayed(bag, parameters_file(tmp_path), tmp_path)
    assert summary["messages"]["used"] == 150
    assert out.metadata[URDF_METADATA]["text"] == TEXT


@pytest.mark.parametrize(
    ("before", "told"),
    [
        ([""], "the robot's description is empty"),
        (
            [FOREIGN, FOREIGN, ""],
            "joints.tip_frame = 'tool' is no link of the robot's description; it has: hand (and 1 "
            "more)",
        ),
    ],
)
def test_descriptions_that_are_none_of_this_robot_blame_the_topic(tmp_path, capsys, before, told):
    bag = write_bag(tmp_path / "a.mcap", description=None, before=before)
    message = (
        f"{bag}: no description on /robot_description can be used: {told}; name the robot's "
        "description as a file in joints.urdf"
    )
    fails(capsys, 2, message, "replay", bag, "--config", parameters_file(tmp_path))


def test_a_stream_refuses_an_empty_description_and_takes_the_next():
    stream = message_stream(configuration(replace(OPTIONS, urdf="topic")))
    for text, told in (("", "is empty$"), (FOREIGN, "'tool' is no link of the robot's descr")):
        with pytest.raises(PegOnHoleError, match=told):
            stream.use_robot_description(text)
        assert awaited(stream.pipeline.configuration.joints)
    stream.use_robot_description(TEXT)
    assert stream.pipeline.configuration.joints.description == TEXT


def test_a_faulty_description_within_a_bag_is_not_blamed_on_the_file_that_it_names(
    tmp_path, capsys
):
    bag, out = write_bag(tmp_path / "a.mcap"), tmp_path / "out.mcap"
    found = configuration(replace(OPTIONS, urdf="/cell/robot.urdf", description="<robot"))
    with BagWriter(out, found) as writer:
        for topic, t_ns, message in Bag(bag).messages(["/wrench"]):
            force = {axis: getattr(message.wrench.force, axis) for axis in "xyz"}
            writer.write(topic, WRENCH_TYPE, {"wrench": {"force": force}}, t_ns)
    message = (
        f"joints.urdf: the robot's description in {out} (metadata peg_on_hole_urdf) is not XML: "
        "unclosed token: line 1, column 0"
    )
    fails(capsys, 2, message, "replay", out)


def test_a_replay_refuses_a_pose_that_contradicts(tmp_path, capsys):
    bag = write_bag(tmp_path / "a.mcap")
    config = parameters_file(tmp_path, sensor_xyz=(0.0, 0.0, 0.07 + 0.1))
    assert main(["replay", str(bag), "--config", str(config)]) == 2
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith(
        "peg-on-hole: error: wrench.sensor_xyz = [0.0, 0.0, 0.17] is not where the robot's "
        "description has 'ft_sensor', the frame_id of the wrench: wrench.sensor_xyz: ["
    )
    assert line.endswith("; take it out, or state wrench.sensor_pose: stated")
