"""The robot's description as it comes by a topic, once."""

from collections.abc import Callable

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.messages.beside_estimates import STRING
from peg_on_hole_ros.messages.ros_messages import message_class
from peg_on_hole_ros.robot.urdf_source import MOST_URDF_BYTES
from peg_on_hole_ros.safe_text import printable


class RobotDescription:
    """
    Waits for the description; what comes after one that could be used is told, and not used.

    Parameters
    ----------
    node : Node
    configuration : Configuration
    take : callable
        Is given the description; raises PegOnHoleError where it cannot be used, and the next one
        may be.

    Attributes
    ----------
    waiting : str
        What is waited for, and what was wrong with one that came; empty: nothing is.

    """

    def __init__(
        self, node: Node, configuration: Configuration, take: Callable[[str], None]
    ) -> None:
        self._node, self._take = node, take
        topic = configuration.topics.robot_description
        self._topic = node.resolve_topic_name(topic)
        self._text: str | None = None
        self.waiting = (
            f"no estimate: the robot's description has not come on {self._topic} (joints.urdf: "
            "topic)"
        )
        qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._subscription = node.create_subscription(
            message_class(STRING), topic, self._come, qos
        )
        node.get_logger().info(f"waiting for the robot's description on {self._topic}")

    def _come(self, message):
        text, logger = message.data, self._node.get_logger()
        if text == self._text:
            return
        if not self.waiting:
            logger.warning(
                f"another description has come on {self._topic}: the node goes on with the first; "
                "clean it up and configure it again to take this one"
            )
            return
        self._text = text
        try:
            if len(text) > MOST_URDF_BYTES:
                raise PegOnHoleError(f"it has {len(text)} characters, more than {MOST_URDF_BYTES}")
            self._take(text)
        except PegOnHoleError as error:
            self.waiting = f"no estimate: what came on {self._topic} cannot be used: {error}"
            logger.error(printable(self.waiting))
            return
        self.waiting = ""
        logger.info(f"the robot's description has come on {self._topic}")

    def destroy(self) -> None:
        """Take it from the node."""
        self._node.destroy_subscription(self._subscription)
