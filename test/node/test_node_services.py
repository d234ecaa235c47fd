"""Answers of `~/tare` and `~/reset` over real DDS: success says that it was done."""

import re
import time

import pytest
from rclpy.qos import QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Trigger

from dds_peer import PATIENCE, Peer, node_process, stop
from inputs import hanging, joints, wrench
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.ros_messages import to_ros

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
            return len(peer.received["contact_mode"]) > 1

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
    assert sum(int(n) for n in re.findall(r"tare refused: (\d+) times", text)) == 2
    assert reset.success and reset.message.startswith("filter and monitor restarted")


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
            peer.joints.publish(to_ros(JOINTS_TYPE, joints(10**9)))
            stamps = iter(range(10**9 + MS, 100 * 10**9, MS))

            def answered():
                peer.wrench.publish(to_ros(WRENCH_TYPE, wrench(next(stamps))))
                return peer.received["state"]

            peer.spin_until(answered, "an estimate")
            answer = peer.call("payload", Trigger.Request())
            text = stop(process)
    finally:
        peer.close()
    assert "~/expect: 'miracles' is not one of lift_off, insertion, nothing" in text
    # What a program announces, or a setting asks for, is no warning.
    assert "expected: lift_off" in text and "expected: 1 times" not in text
    assert answer.success and answer.message.startswith("pose 1 taken: 1 still poses, all with")
