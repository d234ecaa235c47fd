"""The launch file run by ROS 2's own launch, where that is installed: the wheels have none."""

import os
import signal
import subprocess
import sys
from contextlib import contextmanager, suppress

import pytest
from lifecycle_msgs.msg import State
from rcl_interfaces.srv import GetParameters
from rclpy.qos import DurabilityPolicy, QoSProfile

from dds_peer import PATIENCE, Peer, stop
from peg_on_hole_ros.messages.beside_estimates import STRING
from peg_on_hole_ros.messages.ros_messages import message_class
from simulated import ROOT

pytest.importorskip("launch_ros")
pytestmark = pytest.mark.xdist_group("dds")

LAUNCH = """
import sys
from launch import LaunchDescription, LaunchService
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
file, *given = sys.argv[1:]
words = [each.split(":=") for each in given]
source = IncludeLaunchDescription(PythonLaunchDescriptionSource(file), launch_arguments=words)
service = LaunchService(noninteractive=True)
service.include_launch_description(LaunchDescription([source]))
sys.exit(service.run())
"""


@pytest.fixture
def installed(tmp_path):
    """Return an environment in which ROS 2 finds this checkout as an installed package."""
    share = tmp_path / "share"
    marker = share / "ament_index" / "resource_index" / "packages" / "peg_on_hole_ros"
    marker.parent.mkdir(parents=True)
    marker.touch()
    (share / "peg_on_hole_ros").symlink_to(ROOT)
    program = tmp_path / "lib" / "peg_on_hole_ros" / "peg_on_hole"
    program.parent.mkdir(parents=True)
    program.write_text(f"#!{sys.executable}\nfrom peg_on_hole_ros.ros.node import main\nmain()\n")
    program.chmod(0o755)
    before = os.environ.get("AMENT_PREFIX_PATH", sys.prefix)
    paths = {"AMENT_PREFIX_PATH": f"{tmp_path}{os.pathsep}{before}"}
    paths["PYTHONPATH"] = os.pathsep.join([str(ROOT), *filter(None, sys.path)])
    return os.environ | paths


@contextmanager
def launched(environment, file=ROOT / "launch" / "peg_on_hole.launch.py", **arguments):
    words = [f"{name}:={value}" for name, value in arguments.items()]
    process = subprocess.Popen(
        [sys.executable, "-c", LAUNCH, str(file), *words],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    try:
        yield process
    finally:
        # The node too, which outlives a launch that is killed.
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def test_every_argument_reaches_the_node(installed, tmp_path):
    topics = {
        "wrench": "/sensor/wrench",
        "joint_states": "/arm/joint_states",
        "robot_description": "/arm/robot_description",
    }
    params = tmp_path / "cell.yaml"
    text = (ROOT / "config" / "cell_franka_like.yaml").read_text(encoding="utf-8")
    params.write_text(text.replace("peg_on_hole:", "/**:", 1), encoding="utf-8")
    peer = Peer("cell/estimator")
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    names = ["use_sim_time", "joints.tip_frame", "autostart"]
    given = {"params": params, "name": "estimator", "namespace": "cell", "use_sim_time": "true"}
    given["autostart"] = "true"
    try:
        publishers = [
            peer.node.create_publisher(kind, topics[name], qos)
            for name, kind, qos in (
                ("wrench", peer.wrench.msg_type, QoSProfile(depth=10)),
                ("joint_states", peer.joints.msg_type, QoSProfile(depth=10)),
                ("robot_description", message_class(STRING), latched),
            )
        ]
        with launched(installed, **given, **topics) as process:
            values = peer.ask("get_parameters", GetParameters.Request(names=names)).values
            peer.spin_until(
                lambda: (
                    process.poll() is not None
                    or all(each.get_subscription_count() for each in publishers)
                ),
                "the node to listen where it was told to",
            )
            assert process.poll() is None, process.communicate()[0]
            text = stop(process)
    finally:
        peer.close()
    assert (values[0].bool_value, values[1].string_value) == (True, "tool0")
    assert values[2].bool_value
    assert "active: listening to /sensor/wrench and /arm/joint_states" in text
    assert "waiting for the robot's description on /arm/robot_description" in text


def test_a_file_for_another_name_is_refused_and_the_launch_ends(installed):
    config = ROOT / "config" / "cell_ur_like.yaml"
    with launched(installed, params=config, namespace="cell") as process:
        text, _ = process.communicate(timeout=PATIENCE)
    assert "has parameters for /peg_on_hole, but this node is /cell/peg_on_hole" in text


def test_without_arguments_it_is_the_default_configuration_s_node(installed):
    peer = Peer()
    try:
        with launched(installed) as process:
            peer.wait_for_matching()
            text = stop(process)
    finally:
        peer.close()
    assert "active: listening to /wrench and /joint_states" in text


def test_a_node_that_is_not_to_start_itself_waits(installed):
    peer = Peer()
    try:
        with launched(installed, autostart="false") as process:
            assert peer.state() == State.PRIMARY_STATE_UNCONFIGURED
            stop(process)
    finally:
        peer.close()


def test_two_holes_are_two_nodes_of_one_launch(installed):
    peers = [Peer(f"{hole}/peg_on_hole") for hole in ("left", "right")]
    names = ["frames.hole", "joints.source"]
    try:
        with launched(installed, ROOT / "examples" / "two_holes.launch.py") as process:
            request = GetParameters.Request(names=names)
            found = [
                [value.string_value for value in peer.ask("get_parameters", request).values]
                for peer in peers
            ]
            stop(process)
    finally:
        for peer in peers:
            peer.close()
    assert found == [["left_hole", "robot"], ["right_hole", "robot"]]
