"""
The topics of a node for the Foxglove app, where no bridge of ROS 2 is installed.

A topic that nobody looks at is not taken. What a slow app does not take in time is dropped before
it, and the node does not notice.
"""

import re
import threading
import time
from collections.abc import Callable, Sequence

import foxglove
import rclpy
from foxglove.websocket import ChannelView, Client
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.messages.beside_estimates import DIAGNOSTICS, LATCHED, TOPICS
from peg_on_hole_ros.messages.definitions import definition
from peg_on_hole_ros.watch.polling import subscribe, taken

LOOK_PERIOD = 0.02  # [s] between two looks at what has come
# For so long the apps may take their leave [s].
LEAVE_TIME = 0.5
# What may wait for an app: a second of all topics at 1 kHz.
_WAITING = 16 * 1024


class _Asked(foxglove.ServerListener):
    """Remembers which topics an app has begun to look at; it is told so by another thread."""

    def __init__(self) -> None:
        self.topics: set[str] = set()

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        self.topics.add(channel.topic)


class _Topic:
    """A topic of the node, and the app's channel for it."""

    def __init__(
        self, node: Node, context: foxglove.Context, name: str, ros_type: str, latched: bool
    ) -> None:
        self.name = name
        self._node, self._type, self._latched = node, ros_type, latched
        schema = foxglove.Schema(
            name=ros_type, encoding="ros2msg", data=definition(ros_type).encode()
        )
        self._channel = foxglove.Channel(
            name, schema=schema, message_encoding="cdr", context=context
        )
        self._subscription: Subscription | None = None
        self._last: bytes | None = None

    def forward(self, asked: bool) -> None:
        """Give the app what has come; if it has just asked, what was last declared."""
        if asked and self._latched and self._last is not None:
            self._channel.log(self._last)
        if not self._channel.has_sinks():
            self._leave()
            return
        if self._subscription is None:
            self._subscription = subscribe(
                self._node, self.name, self._type, self._latched, raw=True
            )
        for message in taken(self._subscription):
            self._last = message
            self._channel.log(message)

    def _leave(self):
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
        self._subscription, self._last = None, None


def run(
    name: str, host: str, port: int, ready: Callable[[str], None], stopping: Sequence[int]
) -> None:
    """
    Serve until stopped.

    Parameters
    ----------
    name : str
        Full name of the node, as in /cell/peg_on_hole; it may come, go and come back.
    host : str
        Address to listen on.
    port : int
        0: any that is free.
    ready : callable
        Is given the address that the app asks for.
    stopping : sequence of int
        Of `note_signals`.

    Raises
    ------
    PegOnHoleError
        The address cannot be had.

    """
    asked, channels = _Asked(), foxglove.Context()
    try:
        server = foxglove.start_server(
            name=name, host=host, port=port, server_listener=asked, context=channels,
            message_backlog_size=_WAITING,
        )  # fmt: skip
    except RuntimeError as error:
        # The library's own words end in the system's.
        why = re.sub(r"^.*?: Failed to bind port: | \(os error \d+\)$", "", str(error))
        raise PegOnHoleError(
            f"--port {port} on {host} cannot be had: {why}; name another, or 0 for any that is "
            "free"
        ) from None
    context = rclpy.Context()
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("peg_on_hole_foxglove", context=context)
    of_node = {f"{name}/{topic}": kind for topic, kind in TOPICS.items()}
    latched = {f"{name}/{topic}" for topic in LATCHED}
    topics = [
        _Topic(node, channels, topic, kind, topic in latched)
        for topic, kind in {**of_node, "/diagnostics": DIAGNOSTICS}.items()
    ]
    try:
        ready(f"ws://{f'[{host}]' if ':' in host else host}:{server.port}")
        while not stopping:
            for topic in topics:
                new = topic.name in asked.topics
                asked.topics.discard(topic.name)
                topic.forward(new)
            time.sleep(LOOK_PERIOD)
    finally:
        # It waits for every client, also for one that does not read or never sends its request.
        ending = threading.Thread(target=server.stop, daemon=True)
        ending.start()
        ending.join(LEAVE_TIME)
        node.destroy_node()
        rclpy.try_shutdown(context=context)
