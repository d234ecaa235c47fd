"""
The topics of a node, taken twenty times a second and not one by one.

Nothing here waits for a message: however slow a page is, the node does not notice.
"""

import time

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from peg_on_hole_ros.config.configuration import BY_NAME, from_parameters
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.messages.beside_estimates import DIAGNOSTICS, LATCHED, TOPICS
from peg_on_hole_ros.watch.page_updates import DIAGNOSTICS_TOPIC, WHOLE, PageUpdates
from peg_on_hole_ros.watch.polling import DEPTH, subscribe, taken

LATEST_ONLY = ("state_stddev", "contacts_stddev", "pose", "contact/k", "contact/b1", "contact/b2")
EVERY_CHANGE = ("contact_mode", "alarms")
# Of all nodes that report, each once a second.
_DIAGNOSTICS_DEPTH = 200
# Without an estimate for so long it is said [s].
SILENT_AFTER = 1.0


class WatchedNode:
    """
    A node that may come, go and come back.

    Parameters
    ----------
    name : str
        Full name of the node, as in /cell/peg_on_hole.

    Attributes
    ----------
    configuration : Configuration or None
        As the node has it, once it has said so.
    frames : PageUpdates

    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.configuration: Configuration | None = None
        self.frames = PageUpdates(name)
        self._context = rclpy.Context()
        rclpy.init(context=self._context, signal_handler_options=SignalHandlerOptions.NO)
        self._node = rclpy.create_node("peg_on_hole_watch", context=self._context)
        # What is asked is answered there; the topics are taken by hand.
        self._asking = rclpy.create_node("peg_on_hole_watch_asks", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._asking)
        self._parameters = AsyncParameterClient(self._asking, name)
        self._answer: Future | None = None
        self._subscriptions = {
            topic: self._subscribe(topic) for topic in (*WHOLE, *LATEST_ONLY, *EVERY_CHANGE)
        }
        # Of all nodes.
        self._subscriptions[DIAGNOSTICS_TOPIC] = subscribe(
            self._node, DIAGNOSTICS_TOPIC, DIAGNOSTICS, False, False, _DIAGNOSTICS_DEPTH
        )
        self._latest: dict[str, object] = {}
        self._every = *WHOLE, *EVERY_CHANGE, DIAGNOSTICS_TOPIC
        self._arrived_at = time.monotonic()
        self._wrong = ""

    def _subscribe(self, topic):
        latched = topic in LATCHED
        depth = 1 if topic in LATEST_ONLY else 100 if topic in EVERY_CHANGE else DEPTH
        name = f"{self.name}/{topic}"
        return subscribe(self._node, name, TOPICS[topic], latched, topic in WHOLE, depth)

    def frame(self) -> dict:
        """Take what has arrived; return an update of the page (`PageUpdates`), with `status`."""
        self._ask()
        arrived = {topic: taken(self._subscriptions[topic]) for topic in self._every}
        for topic in LATEST_ONLY:
            for message in taken(self._subscriptions[topic]):
                self._latest[topic] = message
        scene = (self.configuration or Configuration()).scene
        frame = self.frames.frame(arrived, self._latest, scene)
        if "t" in frame:
            self._arrived_at = time.monotonic()
        frame["status"] = self._status()
        return frame

    def _ask(self):
        """Have the node say its settings, whenever it has come anew."""
        self._executor.spin_once(timeout_sec=0)
        if not self._publishers():
            self.configuration, self._answer = None, None
            return
        if self.configuration is not None or self._wrong:
            return
        if self._answer is None:
            if self._parameters.services_are_ready():
                self._answer = self._parameters.get_parameters(list(BY_NAME))
            return
        if self._answer.done():
            values = map(parameter_value_to_python, self._answer.result().values)
            given = {name: value for name, value in zip(BY_NAME, values) if value is not None}
            self._answer = None
            try:
                self.configuration = from_parameters(given)  # type: ignore[arg-type]
            except PegOnHoleError as error:
                self._wrong = f"the node's settings are of another version: {error}"

    def _publishers(self):
        return self._node.count_publishers(f"{self.name}/state")

    def _status(self):
        """Return what keeps the page from being right; empty: nothing."""
        silent = time.monotonic() - self._arrived_at
        if not self._publishers():
            return f"no node {self.name} is active: start it, or name another with --node"
        if silent > SILENT_AFTER:
            return (
                f"no estimate for {silent:.0f} s: does the wrench come, do joint states? "
                "/diagnostics reports what became of them"
            )
        if self.configuration is None:
            return self._wrong or "waiting for the node's settings: the drawing has the defaults"
        return ""

    def close(self) -> None:
        """Leave the network."""
        self._executor.shutdown()
        self._asking.destroy_node()
        self._node.destroy_node()
        rclpy.try_shutdown(context=self._context)
