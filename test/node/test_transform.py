"""Transforms on /tf and /tf_static. The wheels have no tf2_msgs: another type lends its name."""

import sys
from contextlib import contextmanager
from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest
import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation
from std_msgs.msg import String

from arm import BENT, JOINTS, OPTIONS, URDF, Arm
from dds_peer import wait_until
from inputs import joints, wrench
from peg_on_hole_ros.config.configuration import to_parameters
from peg_on_hole_ros.config.options import Configuration, Frames
from peg_on_hole_ros.config.parameters_file import write_parameters
from peg_on_hole_ros.messages.beside_estimates import joint_state
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.transforms import TRANSFORMS
from peg_on_hole_ros.ros.node import PegOnHoleNode
from peg_on_hole_ros.ros.process import init

pytestmark = pytest.mark.xdist_group("dds")

MS = 1_000_000
LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Display:
    """Listens to transforms, as RViz does, and reads them by another implementation."""

    def __init__(self, context):
        self.node = rclpy.create_node("display", context=context)
        self.came = {"/tf": [], "/tf_static": []}
        for topic, qos in (("/tf", QoSProfile(depth=100)), ("/tf_static", LATCHED)):
            take = self.came[topic].append
            self.node.create_subscription(String, topic, take, qos, raw=True)
        self.executor = rclpy.executors.SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)

    def told(self, topic):
        read = get_typestore(Stores.ROS2_JAZZY).deserialize_cdr
        found = [read(payload, TRANSFORMS).transforms for payload in self.came[topic]]
        return [each for transforms in found for each in transforms]

    def edges(self):
        """Return parents by frame; with two parents a frame has no place."""
        found = {}
        for each in self.told("/tf") + self.told("/tf_static"):
            found.setdefault(each.child_frame_id, set()).add(each.header.frame_id)
        return found

    def until(self, topic, count):
        wait_until(lambda: len(self.came[topic]) >= count, f"{count} on {topic}", self.executor)


@contextmanager
def running(monkeypatch, *arguments):
    """A configured node and a display, which do not know of each other yet."""
    package, messages = ModuleType("tf2_msgs"), ModuleType("tf2_msgs.msg")
    # What is published are bytes, which no publisher looks into.
    messages.TFMessage = String
    for module in (package, messages):
        monkeypatch.setitem(sys.modules, module.__name__, module)
    arguments = ["--ros-args", *arguments]
    init(arguments)
    context = rclpy.Context()
    rclpy.init(context=context)
    display, node = Display(context), PegOnHoleNode(arguments)
    try:
        node.trigger_configure()
        wait_until(
            lambda: node.count_subscribers("/tf") and display.node.count_publishers("/tf"),
            "both to know of each other",
        )
        yield node, display
    finally:
        node.close()
        node.destroy_node()
        display.node.destroy_node()
        rclpy.shutdown(context=context)
        rclpy.shutdown()


def test_the_pose_is_a_transform_where_tf2_msgs_is(monkeypatch):
    with running(monkeypatch) as (node, display):
        node.trigger_activate()
        for k in range(1, 102):
            node.arrivals.joints(Encoder(JOINTS_TYPE)(joints(k * MS)))
            node.arrivals.wrench(Encoder(WRENCH_TYPE)(wrench(k * MS)))
            node.process()
        display.until("/tf", 6)
    told = display.told("/tf")
    assert [each.header.stamp.nanosec // MS for each in told] == [1, 21, 41, 61, 81, 101]
    # Angles alone do not place the hole: no transform makes one up.
    assert display.edges() == {"peg": {"hole"}}


def cell(tmp_path, frames=None, **changes):
    """Return arguments for a node of a cell with an arm."""
    found = Configuration(joints=replace(OPTIONS, **changes), frames=frames or Frames())
    path = tmp_path / "cell.yaml"
    path.write_text(write_parameters(to_parameters(found)), encoding="utf-8")
    return "--params-file", str(path)


def hold(node, rotation, count=40):
    """Have an arm hold the peg still at the hole; return the peg's axes in the root link."""
    q = Arm().joints_at(np.zeros(3), rotation, BENT)
    for k in range(1, count):
        node.arrivals.joints(Encoder(JOINTS_TYPE)(joint_state(k * MS, JOINTS, q)))
        node.arrivals.wrench(Encoder(WRENCH_TYPE)(wrench(k * MS)))
        node.process()
    hole = Rotation.from_euler("xyz", OPTIONS.hole_rpy)
    return hole * Arm().peg(q)[1]


def rotation(transform):
    q = transform.transform.rotation
    return Rotation.from_quat([q.x, q.y, q.z, q.w])


def test_arm_hole_and_peg_are_one_tree(monkeypatch, tmp_path):
    pytest.importorskip("pinocchio")
    tilted = Rotation.from_euler("y", -0.2)
    with running(monkeypatch, *cell(tmp_path)) as (node, display):
        node.trigger_activate()
        held = hold(node, tilted)
        display.until("/tf_static", 1)
        display.until("/tf", 2)
        # Who comes later is given it too.
        late = Display(display.node.context)
        late.until("/tf_static", 1)
        late.node.destroy_node()
    assert display.edges() == {"hole": {"pedestal"}, "peg": {"hole"}}
    (static,) = display.told("/tf_static")
    there = static.transform.translation
    assert (there.x, there.y, there.z) == OPTIONS.hole_xyz
    # Down the tree the peg lies as the arm, by another's kinematics, holds it: to the noise of
    # 39 orientations of 5e-5 rad a joint.
    off = (rotation(static) * rotation(display.told("/tf")[-1])).inv() * held
    assert off.magnitude() < 3e-4


def test_names_of_frames_are_those_that_are_stated(monkeypatch, tmp_path):
    pytest.importorskip("pinocchio")
    frames = Frames(hole="left_hole", peg="left_peg", base="left/pedestal")
    with running(monkeypatch, *cell(tmp_path, frames)) as (node, display):
        node.trigger_activate()
        hold(node, Rotation.from_euler("y", -0.2))
        display.until("/tf_static", 1)
        display.until("/tf", 1)
    assert display.edges() == {"left_hole": {"left/pedestal"}, "left_peg": {"left_hole"}}


def test_a_link_of_the_robot_is_given_no_second_parent(monkeypatch, tmp_path, capfd):
    pytest.importorskip("pinocchio")
    frames = Frames(hole="ft_sensor", peg="tool")
    with running(monkeypatch, *cell(tmp_path, frames)) as (node, display):
        node.trigger_activate()
        hold(node, Rotation.from_euler("y", -0.2))
        # What is published behind them has come: none of them has been.
        heard = []
        display.node.create_subscription(
            String, "/peg_on_hole/contact_mode", heard.append, LATCHED
        )
        wait_until(lambda: heard, "the contact mode", display.executor)
    assert display.edges() == {}
    said = capfd.readouterr().err
    for name, link in (("hole", "ft_sensor"), ("peg", "tool")):
        assert f"frames.{name} = '{link}' is a link of" in said


def test_a_description_that_comes_by_its_topic_places_the_hole(monkeypatch, tmp_path):
    pytest.importorskip("pinocchio")
    with running(monkeypatch, *cell(tmp_path, urdf="topic")) as (node, display):
        node.trigger_activate()
        publisher = display.node.create_publisher(String, "/robot_description", LATCHED)
        assert not display.came["/tf_static"]
        publisher.publish(String(data=URDF.read_text(encoding="utf-8")))
        executor = rclpy.executors.SingleThreadedExecutor()
        executor.add_node(node)

        def placed():
            executor.spin_once(timeout_sec=0.02)
            return display.came["/tf_static"]

        wait_until(placed, "the place of the hole", display.executor)
    assert display.edges() == {"hole": {"pedestal"}}
