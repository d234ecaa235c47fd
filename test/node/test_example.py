"""The example that stops a robot's program, over DDS."""

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import UInt8
from std_srvs.srv import Trigger

from dds_peer import Peer, node_process
from simulated import ROOT

pytestmark = pytest.mark.xdist_group("dds")
EXAMPLE = (str(ROOT / "examples" / "stop_on_error.py"),)


# Levels as they come, and behind which of them the robot is to be stopped.
LEVELS, RISES = (0, 1, 2, 2, 1, 0, 2, 0, 2), [2, 6, 8]


def test_each_rise_to_error_stops_the_robot_once():
    peer, said, stops = Peer(), [], []

    def stop(_, response):
        stops.append(len(said) - 1)
        response.success, response.message = True, "program stopped"
        return response

    try:
        peer.node.create_service(Trigger, "/dashboard_client/stop", stop)
        qos = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        alarm = peer.node.create_publisher(UInt8, "/peg_on_hole/alarm_level", qos)
        arguments = "-r", "stop:=/dashboard_client/stop"
        with node_process(*arguments, program=EXAMPLE):
            # The peer listens as well.
            peer.spin_until(lambda: alarm.get_subscription_count() == 2, "the example to listen")
            clients = peer.node.count_clients
            peer.spin_until(lambda: clients("/dashboard_client/stop") == 1, "its client")
            for level in LEVELS:
                said.append(level)
                alarm.publish(UInt8(data=level))
                if len(said) - 1 in RISES:
                    wanted = RISES.index(len(said) - 1) + 1
                    peer.spin_until(lambda: len(stops) >= wanted, "a stop")  # noqa: B023
    finally:
        peer.close()
    assert stops == RISES
