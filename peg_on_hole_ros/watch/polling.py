"""Subscriptions that are polled: all that has come is taken now and then."""

from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

from peg_on_hole_ros.messages.ros_messages import message_class

# Half a second at 4 kHz.
DEPTH = 2000


def subscribe(
    node: Node, topic: str, ros_type: str, latched: bool, raw: bool, depth: int = DEPTH
) -> Subscription:
    """
    Return a subscription that nothing calls.

    Best effort asks nothing of the publisher: however slow one is here, it does not notice. Only
    what is published on change is reliable, and comes to those who are late.
    """
    qos = QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if latched else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )
    return node.create_subscription(
        message_class(ros_type), topic, lambda message: None, qos, raw=raw
    )


def taken(subscription: Subscription) -> list[Any]:
    """Return what has come since, the oldest first; bytes of a raw one, messages otherwise."""
    found: list[Any] = []
    # At most a queue: a publisher that is faster must not hold this up for ever.
    for _ in range(DEPTH):
        with subscription.handle:
            message = subscription.handle.take_message(subscription.msg_type, subscription.raw)
        if message is None:
            break
        found.append(message[0])
    return found
