"""The node's inputs: subscriptions that count what is lost, what waits, and why nothing comes."""

import inspect
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

from peg_on_hole_ros.config.options import Topics
from peg_on_hole_ros.messages.cdr_layout import stamp_ns
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE

# Publishers come and go for days.
_MOST_PUBLISHERS = 64
# Taken at a time; a publisher may be faster than this end.
_MOST_TAKEN = 256
_MOST_NAMED = 4


class Numbered:
    """
    The callback of a raw subscription, which counts what is missing between two messages.

    DDS lets go of the oldest that wait, and a network of any, without a word. But each publisher
    numbers what it sends. Where the middleware gives no numbers nothing is counted.

    Parameters
    ----------
    take : callable
        Called with each message, as it was serialised.
    missing : callable
        Called with how many of a publisher are missing before one that came.
    alone : callable
        Returns whether there is one publisher only: without names of theirs (Jazzy has none)
        numbers of several cannot be told apart.

    """

    # rclpy asks a callback how many arguments it takes, to give it what is known of a message.
    __signature__ = inspect.signature(lambda payload, known: None)

    def __init__(
        self,
        take: Callable[[bytes], None],
        missing: Callable[[int], None],
        alone: Callable[[], bool],
    ) -> None:
        self._take, self._missing, self._alone = take, missing, alone
        self._last: dict[bytes, int] = {}

    def __call__(self, *given: Any) -> None:
        """Take a message and what is known of it: two arguments, or from EventsExecutor a pair."""
        payload, known = given if len(given) > 1 else given[0]
        self._take(payload)
        number = known.get("publication_sequence_number")
        if number is None:
            return
        publisher = bytes(known.get("publisher_gid", {}).get("data", b""))
        last = self._last.get(publisher)
        if len(self._last) > _MOST_PUBLISHERS:
            self._last.clear()
        self._last[publisher] = number
        if last is not None and number > last + 1 and (publisher or self._alone()):
            self._missing(number - last - 1)


def subscribe(
    node: Node,
    kind: type,
    topic: str,
    depth: int,
    take: Callable[[bytes], None],
    missing: Callable[[int], None],
) -> Subscription:
    """
    Subscribe to the bytes of messages, of publishers that are reliable and of those that are not.

    Parameters
    ----------
    node : Node
    kind : type
        Class of the messages.
    topic : str
        As it is given; it may be remapped.
    depth : int
        Of the queue.
    take, missing : callable
        See `Numbered`.

    """
    named = node.resolve_topic_name(topic)
    counted = Numbered(take, missing, lambda: node.count_publishers(named) == 1)
    # Best effort matches publishers of both kinds.
    qos = QoSProfile(depth=depth, reliability=ReliabilityPolicy.BEST_EFFORT)
    return node.create_subscription(kind, topic, counted, qos, raw=True)


def take_waiting(subscription: Subscription) -> int:
    """Hand on what a subscription of `subscribe` holds; return how many messages that were."""
    handle, kind = subscription.handle, subscription.msg_type
    numbered: Any = subscription.callback
    with handle:
        for count in range(_MOST_TAKEN):
            given = handle.take_message(kind, True)
            if given is None:
                return count
            numbered(given)
    return _MOST_TAKEN


class WaitingMessages:
    """
    Messages that wait, merged by stamp: DDS keeps no order between topics.

    The joint states among them would then be late. So what is there together is handed on in the
    order of stamps, each source for itself in the order in which it came.

    Parameters
    ----------
    most : int, optional
        How many of each source may wait; beyond, what is next in the order of stamps is pushed
        out, of either source: one alone would leave the other behind, and the node would work
        off what is oldest of it only. None: any number.
    pushed_out : callable, optional
        Called with the source, `wrench` or `joints`, of each message that is.

    Attributes
    ----------
    received : int
        How many have come, whatever became of them.

    """

    def __init__(
        self, most: int | None = None, pushed_out: Callable[[str], None] = lambda source: None
    ) -> None:
        self._waiting: dict[str, deque[bytes]] = {"wrench": deque(), "joints": deque()}
        self._wrench, self._joints = self._waiting.values()
        self._most, self._pushed_out = most, pushed_out
        self.received = 0

    def __len__(self) -> int:
        """Return how many wait."""
        return len(self._wrench) + len(self._joints)

    def wrench(self, payload: bytes) -> None:
        """Take a serialised WrenchStamped."""
        self._add("wrench", payload)

    def joints(self, payload: bytes) -> None:
        """Take a serialised JointState."""
        self._add("joints", payload)

    def _add(self, source, payload):
        waiting = self._waiting[source]
        waiting.append(payload)
        self.received += 1
        while self._most is not None and len(waiting) > self._most:
            self._pushed_out(self._next()[0])

    def take(self) -> Iterator[tuple[str, bytes]]:
        """Yield and remove (source, payload); of equal stamps the joint state comes first."""
        while self._wrench or self._joints:
            yield self._next()

    def _next(self):
        if not self._wrench or (
            self._joints and stamp_ns(self._joints[0]) <= stamp_ns(self._wrench[0])
        ):
            return "joints", self._joints.popleft()
        return "wrench", self._wrench.popleft()


def why_silent(node: Node, topics: Topics, source: str) -> str:
    """
    Return what is odd about the publishers of an input that is silent; empty: nothing is.

    Parameters
    ----------
    node : Node
        Who listens.
    topics : Topics
        To what.
    source : str
        `wrench` or `joints`.

    """
    name, kind = {
        "wrench": ("wrench", WRENCH_TYPE),
        "joints": ("joint_states", JOINTS_TYPE),
    }[source]
    topic = node.resolve_topic_name(getattr(topics, name))
    kinds = {info.topic_type for info in node.get_publishers_info_by_topic(topic)}
    if kind in kinds:
        return ""
    if kinds:
        return f"{topic} is {' and '.join(sorted(kinds))}, not {kind}"
    own = node.get_publisher_names_and_types_by_node(node.get_name(), node.get_namespace())
    left_out = {other for other, _ in own}
    others = sorted(
        other
        for other, found in node.get_topic_names_and_types()
        if kind in found and other not in left_out and node.count_publishers(other)
    )
    told = f"nobody publishes {topic}"
    if not others:
        return told
    more = " and more" if len(others) > _MOST_NAMED else ""
    return (
        f"{told}; of its type there is {', '.join(others[:_MOST_NAMED])}{more}: "
        f"state topics.{name}"
    )
