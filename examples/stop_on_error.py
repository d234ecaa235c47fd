"""
Stop a robot's program when the monitor of its peg raises an alarm of level ERROR.

    python examples/stop_on_error.py --ros-args -r stop:=/dashboard_client/stop

`stop` is a std_srvs/Trigger, as drivers have one. It is called once for each rise to ERROR, and
again only after the level has fallen. A monitor that falls silent is no all-clear: watch
/diagnostics for that.
"""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import UInt8
from std_srvs.srv import Trigger

ERROR = 2


class StopOnError(Node):
    """Calls `stop` where /peg_on_hole/alarm_level rises to ERROR."""

    def __init__(self):
        super().__init__("stop_on_error")
        self._level, self._wanted = 0, False
        self._stop = self.create_client(Trigger, "stop")
        latched = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_timer(0.02, self._call)
        self.create_subscription(UInt8, "/peg_on_hole/alarm_level", self._take, latched)

    def _take(self, message):
        risen = message.data >= ERROR > self._level
        self._level = message.data
        if risen:
            self._wanted = True
            if not self._stop.service_is_ready():
                self.get_logger().error("ERROR, and nobody offers the service: tried on and on")
            self._call()

    def _call(self):
        # A request before the two have found each other would be lost.
        if self._wanted and self._stop.service_is_ready():
            self._wanted = False
            self._stop.call_async(Trigger.Request()).add_done_callback(self._answered)

    def _answered(self, future):
        answer = future.result()
        (self.get_logger().info if answer.success else self.get_logger().error)(
            f"stop: {answer.message or answer.success}"
        )


def main():
    """Run until stopped."""
    rclpy.init()
    try:
        rclpy.spin(StopOnError())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
