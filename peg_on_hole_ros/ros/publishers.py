"""Publishers of all that the node says."""

from collections.abc import Iterable

from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import DurabilityPolicy, QoSProfile

from peg_on_hole_ros.messages.beside_estimates import DIAGNOSTICS, LATCHED, TOPICS, Message
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.ros_messages import message_class, to_ros
from peg_on_hole_ros.messages.stream import Published
from peg_on_hole_ros.messages.transforms import (
    STATIC_TRANSFORM_TOPIC,
    TRANSFORM_TOPIC,
    TRANSFORMS,
    Transforms,
    static_transform,
)
from peg_on_hole_ros.robot.frame_tree import FrameTree

# For who listens to acknowledge what is said last.
_HEARD = Duration(seconds=1.0)


class Publishers:
    """
    Publishers of the outputs below the node's name, of /diagnostics, and of transforms.

    Transforms are left out where tf2_msgs is not installed.

    Parameters
    ----------
    node : LifecycleNode
        They publish while it is active.
    depth : int
        Of the outputs' queues.

    """

    def __init__(self, node: LifecycleNode, depth: int) -> None:
        self._node = node
        self._encoders = {suffix: Encoder(ros_type) for suffix, ros_type in TOPICS.items()}
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._outputs = {
            suffix: node.create_lifecycle_publisher(
                message_class(ros_type),
                f"~/{suffix}",
                latched if suffix in LATCHED else QoSProfile(depth=depth),
            )
            for suffix, ros_type in TOPICS.items()
        }
        self._diagnostics = node.create_lifecycle_publisher(
            message_class(DIAGNOSTICS), "/diagnostics", QoSProfile(depth=10)
        )
        self._transforms: Transforms | None = None
        self._tf = self._tf_static = None
        try:
            kind = message_class(TRANSFORMS)
        except ModuleNotFoundError:
            node.get_logger().info(
                f"nothing on {TRANSFORM_TOPIC} and {STATIC_TRANSFORM_TOPIC}: the package tf2_msgs "
                "is not installed"
            )
        else:
            self._tf = node.create_lifecycle_publisher(
                kind, TRANSFORM_TOPIC, QoSProfile(depth=100)
            )
            self._tf_static = node.create_lifecycle_publisher(
                kind, STATIC_TRANSFORM_TOPIC, latched
            )
            self._encode_tf = Encoder(TRANSFORMS)

    def publish(self, published: Published) -> None:
        """Publish what a wrench makes known, in its order; the node has to be active."""
        for suffix, payload in published.estimate:
            handle = self._outputs[suffix].handle
            # Nobody who comes later would be given it.
            if handle.get_subscription_count():
                handle.publish_raw(payload)
        self.publish_all(published.beside)
        if self._tf is not None and self._transforms is not None:
            transform = self._transforms.message(published.t_ns, published.pose)
            if transform is not None:
                self._tf.publish(self._encode_tf(transform))

    def place(self, tree: FrameTree, t_ns: int) -> None:
        """Take where peg and hole hang in the tree of frames; publish the hole's place [ns]."""
        self._transforms = Transforms(tree.hole, tree.peg) if tree.peg else None
        placed = static_transform(tree, t_ns)
        if self._tf_static is not None and placed is not None:
            self._tf_static.handle.publish_raw(self._encode_tf(placed[2]))

    def publish_all(self, messages: Iterable[Message]) -> None:
        """Publish messages in their order, whether or not the node is active."""
        for suffix, _, fields in messages:
            # Serialised by the replay's encoder: a fifth of rclpy's time, and the same bytes. And
            # rclpy's own publish asks for each message whether the node is active, and its type.
            self._outputs[suffix].handle.publish_raw(self._encoders[suffix](fields))

    def publish_last(self, messages: Iterable[Message]) -> None:
        """Publish the last messages before the publishers are destroyed, active or not."""
        for message in messages:
            self.publish_all([message])
            # With a publisher DDS lets go of what nobody has acknowledged.
            self._outputs[message[0]].wait_for_all_acked(_HEARD)

    def diagnostics(self, fields: dict) -> None:
        """Publish a diagnostic_msgs/DiagnosticArray on /diagnostics."""
        self._diagnostics.publish(to_ros(DIAGNOSTICS, fields))

    def destroy(self) -> None:
        """Take all from the node."""
        for publisher in (*self._outputs.values(), self._diagnostics, self._tf, self._tf_static):
            if publisher is not None:
                self._node.destroy_lifecycle_publisher(publisher)
