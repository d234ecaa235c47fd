"""An input that is silent: the log says once why, and where it may be found."""

import pytest
import rclpy

from dds_peer import wait_until
from inputs import joints, wrench
from peg_on_hole_ros.messages.beside_estimates import STRING
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.ros_messages import message_class
from peg_on_hole_ros.ros.diagnostics import Diagnostics
from peg_on_hole_ros.ros.local_dds import free_domain
from peg_on_hole_ros.ros.node import PegOnHoleNode
from peg_on_hole_ros.ros.process import init

pytestmark = pytest.mark.xdist_group("dds")


@pytest.fixture
def driver(monkeypatch):
    """Return a node of another participant, and one of ours, where nobody else is or was."""
    monkeypatch.setenv("ROS_DOMAIN_ID", str(free_domain()))
    init([])
    context = rclpy.Context()
    rclpy.init(context=context)
    other, node = rclpy.create_node("driver", context=context), PegOnHoleNode([])
    yield other, node
    node.close()
    node.destroy_node()
    other.destroy_node()
    rclpy.shutdown(context=context)
    rclpy.shutdown()


def known(node, topic):
    wait_until(lambda: node.count_publishers(topic), f"a publisher of {topic}")


def test_a_topic_of_another_name_or_type_is_named(driver):
    other, node = driver
    node.trigger_configure()
    node.trigger_activate()
    for topic, kind in (("/ft/wrench", WRENCH_TYPE), ("/joint_states", STRING)):
        other.create_publisher(message_class(kind), topic, 1)
        known(node, topic)
    told, lines = [], []
    node._outputs.diagnostics = told.append
    node._warn = lambda said: lines.extend(said)
    for _ in range(5):
        node._report()
    text = told[-1]["status"][0]["message"]
    wanted = [
        "nobody publishes /wrench; of its type there is /ft/wrench: state topics.wrench",
        "/joint_states is std_msgs/msg/String, not sensor_msgs/msg/JointState",
    ]
    assert text.startswith("no messages of wrench and joints: check topic names")
    assert text.endswith("; ".join(["", *wanted]))
    # Once each, not every second.
    assert lines == [f"no messages of {n}: {why}" for n, why in zip(("wrench", "joints"), wanted)]
    # One that publishes as it should and is still silent leaves the rest of it to the reader.
    other.create_publisher(message_class(WRENCH_TYPE), "/wrench", 1)
    known(node, "/wrench")
    node._report()
    assert "nobody publishes" not in told[-1]["status"][0]["message"]


def test_a_silence_is_logged_once_it_lasts_and_again_after_messages():
    diagnostics, logged = Diagnostics(), []
    for second, comes in enumerate("..x....x..."):
        if comes == "x":
            diagnostics.received("wrench", 1)
        diagnostics.received("joints", 1)
        _, lines = diagnostics.report(0, 10**9, {}, {})
        logged += [second] * len(lines)
    assert logged == [5, 10]


def test_what_comes_is_no_silence(driver):
    _, node = driver
    node.trigger_configure()
    node.trigger_activate()
    lines = []
    node._warn = lambda said: lines.extend(said)
    for second in range(1, 5):
        node.arrivals.joints(Encoder(JOINTS_TYPE)(joints(second * 10**6)))
        node.arrivals.wrench(Encoder(WRENCH_TYPE)(wrench(second * 10**6)))
        node.process()
        node._report()
    assert [line for line in lines if "no messages" in line] == []
