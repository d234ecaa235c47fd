"""What publishers have sent and a subscription has never given, by the numbers that they give."""

import inspect
from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

# Publishers come and go for days.
_MOST_PUBLISHERS = 64
# Taken at a time; a publisher may be faster than this end.
_MOST_TAKEN = 256


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
