"""The transform on /tf. The wheels have no tf2_msgs: another type lends the topic its name."""

import sys
from types import ModuleType

import pytest
import rclpy
from rclpy.qos import QoSProfile
from rosbags.typesys import Stores, get_typestore
from std_msgs.msg import String

from dds_peer import wait_until
from inputs import joints, wrench
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.transforms import TRANSFORMS
from peg_on_hole_ros.ros.node import PegOnHoleNode
from peg_on_hole_ros.ros.process import init

pytestmark = pytest.mark.xdist_group("dds")

MS = 1_000_000


def test_the_pose_is_a_transform_where_tf2_msgs_is(monkeypatch):
    package, messages = ModuleType("tf2_msgs"), ModuleType("tf2_msgs.msg")
    # What is published are bytes, which no publisher looks into.
    messages.TFMessage = String
    for module in (package, messages):
        monkeypatch.setitem(sys.modules, module.__name__, module)
    init([])
    context, came = rclpy.Context(), []
    rclpy.init(context=context)
    display = rclpy.create_node("display", context=context)
    display.create_subscription(String, "/tf", came.append, QoSProfile(depth=100), raw=True)
    executor = rclpy.executors.SingleThreadedExecutor(context=context)
    executor.add_node(display)
    node = PegOnHoleNode([])
    try:
        node.trigger_configure()
        node.trigger_activate()
        wait_until(
            lambda: node.count_subscribers("/tf") and display.count_publishers("/tf"),
            "both to know of each other",
        )
        for k in range(1, 102):
            node.arrivals.joints(Encoder(JOINTS_TYPE)(joints(k * MS)))
            node.arrivals.wrench(Encoder(WRENCH_TYPE)(wrench(k * MS)))
            node.process()
        wait_until(lambda: len(came) >= 6, "six transforms", executor)
    finally:
        node.close()
        node.destroy_node()
        display.destroy_node()
        rclpy.shutdown(context=context)
        rclpy.shutdown()
    read = get_typestore(Stores.ROS2_JAZZY).deserialize_cdr
    told = [each for payload in came for each in read(payload, TRANSFORMS).transforms]
    assert [each.header.stamp.nanosec // MS for each in told] == [1, 21, 41, 61, 81, 101]
    assert {(each.header.frame_id, each.child_frame_id) for each in told} == {("hole", "peg")}
