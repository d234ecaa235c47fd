"""A bag of a robot's joint states gives the estimates that the peg's own angles give."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from mcap.reader import make_reader
from rclpy.serialization import deserialize_message
from scipy.spatial.transform import Rotation

from arm import JOINTS, OPTIONS, URDF, Arm, angles
from cli_helpers import fails
from dds_peer import Peer, node_process, stop
from peg_on_hole_ros.bags.estimates import estimates
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.configuration import to_parameters
from peg_on_hole_ros.config.parameters_file import write_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.messages.beside_estimates import joint_state
from peg_on_hole_ros.messages.decode import (
    JOINTS_TYPE,
    WRENCH_TYPE,
    joint_sample,
    wrench_sample,
)
from peg_on_hole_ros.messages.ros_messages import message_class, to_ros
from peg_on_hole_ros.records import AngleMeasurement, JointSample
from peg_on_hole_ros.replay.run import replay_bag
from peg_on_hole_ros.robot.kinematics import orientation_source
from robot_bags import arm_path, robot_configuration, write_robot_bag
from simulated import ROOT
from small_bags import write_bag

pytest.importorskip("pinocchio")
pytestmark = pytest.mark.xdist_group("dds_starts")

SAMPLE = ROOT / "bags" / "closing_with_slip.mcap"


@pytest.fixture(scope="module")
def replayed(tmp_path_factory):
    """Outputs and summaries of both replays, and how many states the robot's bag has."""
    folder = tmp_path_factory.mktemp("robot")
    bag = folder / "robot.mcap"
    counts = write_robot_bag(bag, SAMPLE, seed=4)
    summaries = []
    for name, source in (("robot", bag), ("peg", SAMPLE)):
        out, summary = folder / f"{name}_out.mcap", folder / f"{name}.json"
        arguments = ["replay", source, "--out", out, "--summary", summary]
        assert main([str(a) for a in arguments]) == 0
        summaries.append((list(estimates(Bag(out))), json.loads(summary.read_text())))
    return bag, counts, *summaries


def test_the_output_has_the_place_of_the_hole_in_the_arm_s_tree(replayed):
    robot_bag = replayed[0]
    out = Bag(robot_bag.parent / "robot_out.mcap")
    (row,) = out.messages(["/tf_static"])
    (placed,) = row.message.transforms
    assert (placed.header.frame_id, placed.child_frame_id) == ("pedestal", "hole")
    there, turn = placed.transform.translation, placed.transform.rotation
    assert (there.x, there.y, there.z) == OPTIONS.hole_xyz
    turned = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w])
    assert (turned.inv() * Rotation.from_euler("xyz", OPTIONS.hole_rpy)).magnitude() < 1e-9
    # It holds for all that is in the bag, and is kept for who listens later.
    assert row.log_ns == min(info.first_ns for info in out.topics.values())
    with (robot_bag.parent / "robot_out.mcap").open("rb") as stream:
        channels = make_reader(stream).get_summary().channels.values()
    (kept,) = (each.metadata for each in channels if each.topic == "/tf_static")
    assert "durability: 1" in kept["offered_qos_profiles"]
    # The peg's own angles do not place the hole.
    assert "/tf_static" not in Bag(robot_bag.parent / "peg_out.mcap").topics


def test_every_joint_state_of_the_arm_is_used_and_the_grippers_are_counted(replayed):
    _, (arm, gripper), (_, robot), (_, peg) = replayed
    assert robot["messages"]["used"] == peg["messages"]["used"]
    assert robot["messages"]["dropped"] == {"joints_dropped_missing_joint": gripper}
    assert arm > 300 and gripper > 60


def test_errors_are_those_that_the_bounds_promise(replayed):
    _, _, (rows, robot), (_, peg) = replayed
    for i, name in enumerate(("gamma", "psi", "phi")):
        # One noise seed, errors of one stamp like those of the stamps beside it: some fifty
        # independent ones, whose 95 % bounds cover 95 % give or take 3 %.
        assert robot["coverage95"][name] > 0.87, name
        predicted = np.mean([row.stddev[i] for row in rows])
        assert 0.6 < robot["rmse"][name] / predicted < 1.4, name
    for name in ("K", "B1", "B2"):
        # Reactions hang on the wrench, which is the same: the angles' noise hardly enters.
        assert robot["rmse"][name] == pytest.approx(peg["rmse"][name], rel=0.05)


def test_estimates_differ_from_those_of_the_pegs_angles_as_two_noises_do(replayed):
    _, _, (robot, _), (peg, _) = replayed
    assert [row.t_ns for row in robot] == [row.t_ns for row in peg]
    for i in range(3):
        differences = np.array([a.values[i] - b.values[i] for a, b in zip(robot, peg)])
        spread = np.array([np.hypot(a.stddev[i], b.stddev[i]) for a, b in zip(robot, peg)])
        assert np.sqrt(np.mean((differences / spread) ** 2)) < 1.4
    assert [row.mode for row in robot] == [row.mode for row in peg]


@cache
def measured():
    """The first samples of the bag, each joint state with joints that hold the peg just there."""
    bag = Bag(SAMPLE)
    samples = []
    for topic, _, message in bag.messages(["/wrench", "/joint_states"]):
        take = wrench_sample if topic == "/wrench" else joint_sample
        samples.append(take(message))
        if len(samples) == 400:
            break
    states = [s for s in samples if isinstance(s, JointSample)]
    path = arm_path([s.position for s in states], tolerance=1e-11)
    return samples, dict(zip((s.t_ns for s in states), path))


@pytest.mark.nightly
def test_outputs_are_those_of_the_same_angles_with_covariance_by_differences():
    configuration = robot_configuration(SAMPLE)
    samples, joints = measured()
    arm, h = Arm(), 1e-6

    def by_differences(sample):
        q = joints[sample.t_ns]
        sides = (angles(arm.peg(q + e)[1]) - angles(arm.peg(q - e)[1]) for e in h * np.eye(7))
        J = np.array([(np.pi - (np.pi - side) % (2 * np.pi)) / (2 * h) for side in sides]).T
        covariance = OPTIONS.position_stddev**2 * J @ J.T
        return AngleMeasurement(sample.t_ns, np.array(sample.position), covariance)

    robot = Pipeline(configuration, orientation_source(configuration.joints))
    other = Pipeline(configuration, by_differences)
    compared = apart = 0
    for sample in samples:
        if isinstance(sample, JointSample):
            robot.on_joints(JointSample(sample.t_ns, JOINTS, tuple(joints[sample.t_ns])))
            other.on_joints(sample)
            continue
        a, b = robot.on_wrench(sample), other.on_wrench(sample)
        assert (a is None) == (b is None)
        if a is None:
            continue
        compared += 1
        # The floor of 1e-6 rad adds 2e-4 of the variance; the filter passes no more than that on.
        stddev = np.sqrt(np.diagonal(b.state_covariance))
        error = a.state - b.state
        error[1:3] = np.pi - (np.pi - error[1:3]) % (2 * np.pi)
        assert error / stddev == pytest.approx(np.zeros(6), abs=2e-3)
        assert np.sqrt(np.diagonal(a.state_covariance)) == pytest.approx(stddev, rel=1e-3)
        near = np.abs(a.normal - b.normal).max() < 2e-3 * b.normal_stddev.max()
        apart += not (near and a.normal_stddev == pytest.approx(b.normal_stddev, rel=1e-3))
    assert compared > 250
    # Reactions whose accelerations are at the very limit of a surprise are weighed in one of the
    # two only.
    assert apart < 0.01 * compared


def parameters_file(tmp_path, **changes):
    parameters = to_parameters(robot_configuration(SAMPLE))
    parameters |= {f"joints.{name}": value for name, value in changes.items()}
    path = tmp_path / "robot.yaml"
    path.write_text(write_parameters(parameters), encoding="utf-8")
    return path


def test_replay_refuses_what_does_not_fit_with_code_2(replayed, tmp_path, capsys):
    path = parameters_file(tmp_path, tip_frame="flang")
    fails(
        capsys,
        2,
        f"joints.tip_frame = 'flang' is no link of {OPTIONS.urdf}; the nearest are: flange",
        *("replay", replayed[0], "--config", path),
    )


def test_a_robot_that_cannot_be_used_is_refused_before_compiling(tmp_path, monkeypatch):
    def compiles(configuration):
        raise AssertionError("compiling")

    monkeypatch.setattr("peg_on_hole_ros.replay.run.warm", compiles)
    configuration = robot_configuration(SAMPLE)
    joints = replace(configuration.joints, tip_frame="flang")
    configuration = replace(configuration, joints=joints)
    with pytest.raises(PegOnHoleError, match="^joints.tip_frame = 'flang' is no link"):
        replay_bag(Bag(write_bag(tmp_path / "a.mcap", count=4)), configuration, 0.0, [])


def test_node_reads_the_robots_joints(tmp_path):
    samples, joints = measured()
    peer = Peer()
    try:
        with node_process("--params-file", str(parameters_file(tmp_path))) as process:
            peer.wait_for_matching()
            t_ns, q = next(iter(joints.items()))
            state = joint_state(t_ns, JOINTS[::-1], q[::-1])
            peer.joints.publish(to_ros(JOINTS_TYPE, state))
            stamps = iter(range(t_ns, t_ns + 10**10, 1_000_000))

            def answered():
                stamp = next(stamps)
                sides = {"force": dict(zip("xyz", (0.0, 0.0, 0.0)))}
                header = joint_state(stamp, [])["header"]
                wrench = {"header": header, "wrench": sides | {"torque": sides["force"]}}
                peer.wrench.publish(to_ros(WRENCH_TYPE, wrench))
                return peer.received["state"]

            peer.spin_until(answered, "an estimate from the robot's joints")
            state = deserialize_message(peer.received["state"][0], message_class(JOINTS_TYPE))
            # Begun at rest and not yet known to touch, nothing has moved since: what is left is
            # how well the joints are solved for, 1e-11 rad, in psi and phi over sin(gamma) = 0.17.
            truth = next(s for s in samples if isinstance(s, JointSample)).position
            error = np.subtract(state.position, truth)
            error[1:] -= 2 * np.pi * np.round(error[1:] / (2 * np.pi))
            assert error == pytest.approx(np.zeros(3), abs=1e-9)
            assert "rror" not in stop(process)
    finally:
        peer.close()


@pytest.mark.nightly
def test_node_says_why_it_cannot_be_configured(tmp_path):
    path = parameters_file(tmp_path, names=["arm_1"])
    with node_process("--params-file", str(path)) as process:
        text, _ = process.communicate(timeout=60)
    assert "joints.names lacks arm_2, arm_3, arm_4, arm_5, arm_6, arm_7" in text
    assert process.returncode == 2


@pytest.mark.nightly
def test_names_of_a_description_reach_the_log_of_a_node_as_text(tmp_path):
    """XML lets names have what a terminal obeys, such as CSI (0x9b)."""
    urdf = tmp_path / "a.urdf"
    text = URDF.read_text(encoding="utf-8").replace('"tool"', '"\x9b31mtool"')
    urdf.write_text(text.replace("arm_2", "\x9b5marm_2"), encoding="utf-8")
    path = parameters_file(tmp_path, names=["arm_1"], urdf=str(urdf), tip_frame="\x9b31mtool")
    with node_process("--params-file", str(path)) as process:
        text, _ = process.communicate(timeout=60)
    assert "\x9b" not in text and process.returncode == 2
    assert "joints.names lacks \\x9b5marm_2, arm_3" in text
    assert "which move \\x9b31mtool: every joint" in text
