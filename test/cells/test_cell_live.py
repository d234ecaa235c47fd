"""A robot cell's bag played into the running node over DDS, description and all."""

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message

from dds_peer import Peer, node_process, stop
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.truth import read_truth
from peg_on_hole_ros.messages.beside_estimates import STRING
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.ros_messages import message_class
from simulated import ROOT
from tiers import at_push

pytest.importorskip("pinocchio")
pytestmark = pytest.mark.xdist_group("dds")

# In the air, touch-down on one side at 1.7 s, three contacts from 1.9 s on.
SECONDS = 2.4
BEHIND = 100  # wrenches on their way; half of the node's queue


def modes_of(peer):
    told = peer.received["contact_mode"]
    return [deserialize_message(each, message_class(STRING)).data for each in told]


@pytest.mark.parametrize("name", at_push(["franka_like"], ["ur_like", "franka_like", "iiwa_like"]))
def test_the_node_follows_a_cell_from_the_air_to_three_contacts(name):
    bag = Bag(ROOT / "bags" / f"cell_{name}.mcap")
    config = ROOT / "config" / f"cell_{name}.yaml"
    truth, peer, sent = read_truth(bag), Peer(), 0
    topics = {
        "/robot_description": (STRING, 1),
        "/joint_states": (JOINTS_TYPE, 1000),
        "/wrench": (WRENCH_TYPE, 1000),
    }
    first = bag.topics["/wrench"].first_ns
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    description = peer.node.create_publisher(message_class(STRING), "/robot_description", latched)
    # The others have a file beside their parameters.
    by_topic = "/robot_description" in bag.topics
    send = {
        "/robot_description": description,
        "/joint_states": peer.joints,
        "/wrench": peer.wrench,
    }
    try:
        with node_process("--params-file", str(config)) as process:
            peer.wait_for_matching()
            peer.spin_until(
                lambda: description.get_subscription_count() == by_topic, "who listens"
            )
            for item, payload in bag.with_payloads([t for t in topics if t in bag.topics]):
                if item.log_ns - first > SECONDS * 1e9:
                    break
                send[item.topic].publish(payload)
                if item.topic == "/robot_description":
                    waited = "the robot's description has come"
                    peer.spin_until(lambda: peer.received["/diagnostics"], waited)
                if item.topic == "/wrench":
                    sent += 1
                    # The first may come before the description has been read.
                    got = peer.received["state"]
                    peer.spin_until(lambda: len(got) >= sent - BEHIND, "estimates")  # noqa: B023
            peer.spin_until(lambda: modes_of(peer)[-1:] == ["three_point"], "three contacts")
            text = stop(process)
    finally:
        peer.close()
    assert "sensor: at 'ft_sensor'" in text and "rror" not in text
    assert "open" in modes_of(peer)
    last = deserialize_message(peer.received["state"][-1], message_class(JOINTS_TYPE))
    t_ns = last.header.stamp.sec * 10**9 + last.header.stamp.nanosec
    # Gears that give 0.7 mrad, where no encoder sees it.
    assert last.position[0] == pytest.approx(truth.at(t_ns)[0], abs=1.5e-3)
