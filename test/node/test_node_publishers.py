"""More publish on a topic of the node than should."""

import pytest
import rclpy

from inputs import joints, wrench
from peg_on_hole_ros.edges.live.process import init
from peg_on_hole_ros.edges.messages.cdr import Encoder
from peg_on_hole_ros.edges.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.edges.messages.ros_messages import message_class
from peg_on_hole_ros.edges.node import PegOnHoleNode

pytestmark = pytest.mark.xdist_group("dds")

MS = 1_000_000


@pytest.mark.parametrize("remapped", [[], ["-r", "/wrench:=/ft"]])
def test_wrenches_of_two_are_told_while_they_come(remapped):
    arguments = ["--ros-args", *remapped]
    init(arguments)
    try:
        node = PegOnHoleNode(arguments)
        node.trigger_configure()
        node.trigger_activate()
        told, topic = [], "/ft" if remapped else "/wrench"
        node._outputs.diagnostics = told.append
        for count in (1, 2):
            node.create_publisher(message_class(WRENCH_TYPE), topic, 1)
            node.arrivals.joints(Encoder(JOINTS_TYPE)(joints(count * MS)))
            node.arrivals.wrench(Encoder(WRENCH_TYPE)(wrench(count * MS)))
            node.process()
            node._report()
        node.close()
        node.destroy_node()
    finally:
        rclpy.shutdown()
    found = [fields["status"][0] for fields in told]
    assert [(status["level"], status["message"]) for status in found] == [
        (0, "all messages used"),
        (1, "2 publish on the topic of the wrench, which has to be one sensor's"),
    ]
