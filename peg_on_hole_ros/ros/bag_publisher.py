"""Publishes what a bag has for the node: wrench, joint states, and the robot's description."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import NamedTuple

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.messages.beside_estimates import STRING
from peg_on_hole_ros.messages.ros_messages import message_class

QUEUE_DEPTH = 20_000
# What comes once and stays, as drivers send it.
LATCHED_TYPES = (STRING,)


class PayloadInTime(NamedTuple):
    """
    A message of a bag, as it was serialised.

    Attributes
    ----------
    share : float
        Of the bag's time that has passed.
    offset_ns : int
        Since the bag's first message, by the recorder's clock [ns].
    topic : str
    payload : bytes

    """

    share: float
    offset_ns: int
    topic: str
    payload: bytes


class BagPublisher:
    """
    Publishers of the topics of a bag on a node.

    Parameters
    ----------
    node : Node
    types : mapping of str to str
        Topic, as the bag has it from the root, to type.

    """

    def __init__(self, node: Node, types: Mapping[str, str]) -> None:
        self._types = dict(types)
        self._publishers = {
            topic: node.create_publisher(message_class(ros_type), topic, _qos(ros_type))
            for topic, ros_type in types.items()
        }

    def stays(self, topic: str) -> bool:
        """Return whether a topic's message is kept for those who subscribe later."""
        return self._types[topic] in LATCHED_TYPES

    def listened_to(self, topics: Collection[str] | None = None) -> bool:
        """Return whether somebody has subscribed to every topic, or to every one of those."""
        chosen = self._publishers if topics is None else topics
        return all(self._publishers[topic].get_subscription_count() for topic in chosen)

    def publish(self, message: PayloadInTime) -> None:
        """Publish a message, byte for byte."""
        self._publishers[message.topic].publish(message.payload)

    def of(self, bag: Bag) -> Iterator[PayloadInTime]:
        """Yield what is to be published of a bag, in the order of the recorder's clock."""
        return recorded(bag, self._types)


def recorded(bag: Bag, topics: Iterable[str]) -> Iterator[PayloadInTime]:
    """Yield the messages of topics, in the order of the recorder's clock."""
    first, last = bag.span_ns
    whole = max(1, last - first)
    for message, payload in bag.with_payloads(list(topics)):
        offset_ns = message.log_ns - first
        yield PayloadInTime(offset_ns / whole, offset_ns, message.topic, payload)


def _qos(ros_type):
    if ros_type in LATCHED_TYPES:
        return QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    # Who listens may ask for all messages, or for the newest as drivers send them.
    return QoSProfile(depth=QUEUE_DEPTH, reliability=ReliabilityPolicy.RELIABLE)
