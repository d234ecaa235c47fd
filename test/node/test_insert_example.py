"""The example that inserts a peg, over DDS, with a scripted robot and monitor."""

import time

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Bool, String, UInt8
from std_srvs.srv import Trigger

from dds_peer import Peer, node_process
from peg_world import World, insert, while_aligning
from simulated import ROOT

pytestmark = pytest.mark.xdist_group("dds")
EXAMPLE = (str(ROOT / "examples" / "insert.py"),)
LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Robot:
    """Publishes where the peg is and what a monitor would say, for each target that comes."""

    def __init__(self, node, world):
        self.world, self.said, self.tares, self.targets = world, [], [], 0
        of = "/peg_on_hole/"
        self.pose = node.create_publisher(PoseStamped, "current_pose", 10)
        self.wrench = node.create_publisher(WrenchStamped, "/wrench", 10)
        self.mode = node.create_publisher(String, of + "contact_mode", LATCHED)
        self.transition = node.create_publisher(Bool, of + "transition", LATCHED)
        self.level = node.create_publisher(UInt8, of + "alarm_level", LATCHED)
        self.alarms = node.create_publisher(DiagnosticArray, of + "alarms", 10)
        node.create_service(Trigger, of + "tare", self._tare)
        node.create_subscription(
            String, of + "expect", lambda message: self.said.append(message.data), 10
        )
        node.create_subscription(PoseStamped, "target_frame", self._target, 10)

    def _tare(self, _, response):
        self.tares.append(self.world.command.position[2])
        response.success = True
        return response

    def _target(self, message):
        self.targets += 1
        p = message.pose.position
        lean, spin = insert.lean_and_spin(message.pose.orientation)
        # The stage is the program's own; what was announced tells it.
        said = self.said[-1] if self.said else ""
        stage = {"insertion": "align", "lift_off": "back_off"}.get(said, "touch")
        position = np.array([p.x, p.y, p.z])
        self.world.command = insert.Command(position, lean, spin, stage)
        self.world.commands.append(self.world.command)
        self.publish()

    def publish(self):
        """Publish what is seen now."""
        seen = self.world.seen()
        pose = PoseStamped()
        p, q = pose.pose.position, pose.pose.orientation
        p.x, p.y, p.z = map(float, seen.position)
        q.x, q.y, q.z, q.w = map(float, insert.quaternion(seen.lean, seen.spin))
        self.pose.publish(pose)
        wrench = WrenchStamped()
        wrench.wrench.force.z = float(seen.force)
        self.wrench.publish(wrench)
        self.mode.publish(String(data=seen.mode))
        self.transition.publish(Bool(data=bool(seen.transition)))
        self.level.publish(UInt8(data=seen.level))
        status = [
            DiagnosticStatus(name=name, level=bytes([level]), message=text)
            for name, level, text in seen.alarms
        ]
        self.alarms.publish(DiagnosticArray(status=status))


def run(world, *parameters):
    """Run the example over DDS in a world; return robot, exit code and log."""
    peer = Peer()
    try:
        robot = Robot(peer.node, world)
        with node_process(*parameters, program=EXAMPLE) as process:
            began = 0.0

            def ended():
                nonlocal began
                # Until the first target has come nobody asks for what is seen.
                if not robot.targets and time.monotonic() - began > 0.1:
                    began = time.monotonic()
                    robot.publish()
                return process.poll() is not None

            peer.spin_until(ended, "the end of the example")
            return robot, process.returncode, process.stdout.read()
    finally:
        peer.close()


def test_the_example_inserts_and_begins_anew_after_an_error():
    world = World(alarms=while_aligning(2, "the peg wedges"))
    robot, code, text = run(world)
    assert code == 0, text
    assert "inserted" in text
    # Level and texts are two topics, of which either may come first.
    assert "'align', 'jamming: the peg wedges'" in text or "'align', 'an alarm is ERROR'" in text
    assert robot.said == ["insertion", "lift_off", "insertion"]
    # Before each of the tries, above the plate.
    assert len(robot.tares) == 2 and min(robot.tares) > world.plate + 0.005


def test_the_example_that_has_given_up_says_so_by_its_exit_code():
    _, code, text = run(World(), "-p", "tries:=1", "-p", "force_limit:=1.0")
    assert code == 2, text
    assert "given up" in text
