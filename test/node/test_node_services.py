"""Answers of `~/tare` and `~/reset` over real DDS, and what a program announces there."""

import re
import time

import pytest
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from std_msgs.msg import String
from std_srvs.srv import Trigger

from dds_peer import PATIENCE, Peer, node_process, stop
from inputs import hanging, joints
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.messages.beside_estimates import DIAGNOSTICS
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.ros_messages import message_class, to_ros
from simulated import ROOT

pytestmark = pytest.mark.xdist_group("dds")

MS = 1_000_000


def test_a_tare_is_a_success_only_when_something_was_taken():
    peer = Peer()
    with node_process() as process:
        peer.wait_for_matching()
        refused = peer.call("tare", Trigger.Request())
        sent = 0

        def free():
            nonlocal sent
            # No more than the node takes at once: it is to be done with all of them at the end.
            if sent < len(peer.received["state"]) + 100:
                sent += 1
                peer.joints.publish(to_ros(JOINTS_TYPE, joints(sent * MS)))
                peer.wrench.publish(to_ros(WRENCH_TYPE, hanging(sent * MS)))
            arrived = {name: len(peer.received[name]) for name in ("contact_mode", "state")}
            # A tare takes wrenches of 0.1 s.
            return arrived["contact_mode"] > 1 and arrived["state"] > 150

        peer.spin_until(free, "that the peg is free")
        taken = peer.call("tare", Trigger.Request())
        silent, end = taken, time.monotonic() + PATIENCE
        # A busy node may still have wrenches before it when they end.
        while silent.success and time.monotonic() < end:
            time.sleep(1.1)
            silent = peer.call("tare", Trigger.Request())
        reset = peer.call("reset", Trigger.Request())
        text = stop(process)
    peer.close()
    assert not refused.success
    assert refused.message == "nothing taken: no wrench and orientation have arrived yet"
    assert taken.success and taken.message.startswith("tare over")
    # A sensor that has died carries nobody knows what.
    assert not silent.success and silent.message.startswith("nothing taken: no wrench has come")
    # Told at the end at the latest.
    assert sum(int(n) for n in re.findall(r"tare refused: (\d+) time", text)) == 2
    assert reset.success and reset.message.startswith("filter and monitor are restarted")


def test_motions_are_announced_and_poses_taken():
    peer = Peer()
    try:
        qos = QoSProfile(depth=10)
        expect = peer.node.create_publisher(String, "/peg_on_hole/expect", qos)
        with node_process() as process:
            peer.wait_for_matching()
            peer.spin_until(lambda: expect.get_subscription_count() == 1, "who listens")
            for text in ("miracles", "lift_off"):
                expect.publish(String(data=text))
            stamps = iter(range(10**9 + MS, 100 * 10**9, MS))

            def answered():
                t_ns = next(stamps)
                peer.joints.publish(to_ros(JOINTS_TYPE, joints(t_ns)))
                peer.wrench.publish(to_ros(WRENCH_TYPE, hanging(t_ns)))
                return len(peer.received["state"]) > 150

            peer.spin_until(answered, "an estimate")
            answer = peer.call("payload", Trigger.Request())
            text = stop(process)
    finally:
        peer.close()
    assert "~/expect: 'miracles' is not one of lift_off, insertion, nothing" in text
    # What a program announces, or a setting asks for, is no warning.
    assert "expected: lift_off" in text and "expected: 1 time" not in text
    assert answer.success and answer.message.startswith("pose 1 taken: tilt the peg by 20 degrees")


def lift_off(begin=5.8, end=7.7):
    """Return serialised messages of the shipped bag about its lift-off at 6.856 s."""
    topics = ["/wrench", "/joint_states"]
    found = list(Bag(ROOT / "bags" / "working_cycle.mcap").with_payloads(topics))
    first = found[0][0].log_ns
    times = [(item.log_ns - first) * 1e-9 for item, _ in found]
    return [(item.topic, payload) for (item, payload), t in zip(found, times) if begin <= t < end]


def later(payload, seconds):
    """Return a serialised message that begins with a header, with a later stamp."""
    stamp = int.from_bytes(payload[4:8], "little") + seconds
    return payload[:4] + stamp.to_bytes(4, "little") + payload[8:]


def losses(peer):
    """Return level and text of each `contact_loss` that has come, and forget them."""
    payloads, peer.received["alarms"][:] = list(peer.received["alarms"]), []
    arrays = [deserialize_message(payload, message_class(DIAGNOSTICS)) for payload in payloads]
    return [
        (status.level[0], status.message)
        for array in arrays
        for status in array.status
        if status.name.endswith("contact_loss")
    ]


@pytest.mark.nightly
def test_an_announced_lift_off_is_no_alarm_and_the_next_one_is():
    peer = Peer()
    publishers = {"/wrench": peer.wrench, "/joint_states": peer.joints}
    recorded = lift_off()
    try:
        expect = peer.node.create_publisher(String, "/peg_on_hole/expect", QoSProfile(depth=10))
        with node_process() as process:
            peer.wait_for_matching()
            peer.spin_until(lambda: expect.get_subscription_count() == 1, "who listens")

            def play(seconds):
                peer.received["state"].clear()
                rest, sent = iter(recorded), 0

                def done():
                    nonlocal sent
                    # As fast as the node takes them; few wrenches have no state.
                    while sent < len(peer.received["state"]) + 100:
                        topic, payload = next(rest, (None, b""))
                        if topic is None:
                            return len(peer.received["state"]) > sent - 50
                        publishers[topic].publish(later(payload, seconds))
                        sent += topic == "/wrench"
                    return False

                peer.spin_until(done, "estimates of a lift-off")
                return losses(peer)

            expect.publish(String(data="lift_off"))
            # Once that is answered the node has what was sent before it.
            peer.call("payload", Trigger.Request())
            announced = play(0)
            # Nobody has said that a second one comes, nor taken the first back.
            again = play(20)
            text = stop(process)
    finally:
        peer.close()
    assert text.count("expected: ") == 1
    assert {level for level, _ in announced} == {0}
    assert any(said.startswith("expected (lift_off): ") for _, said in announced)
    assert max(level for level, _ in again) == 2
    assert not any(said.startswith("expected") for _, said in again)
