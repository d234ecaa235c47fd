"""Plays a bag's input into a running node over DDS and keeps what the node publishes."""

import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import rclpy
from mcap.writer import Writer
from rclpy.experimental import EventsExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import LATCHED_QOS
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.messages.beside_estimates import (
    BOOL,
    DIAGNOSTICS,
    LATCHED,
    MARKERS,
    PREFIX,
    STRING,
    TOPICS,
    UINT8,
)
from peg_on_hole_ros.messages.cdr_layout import stamp_ns
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.definitions import definition
from peg_on_hole_ros.messages.ros_messages import message_class
from peg_on_hole_ros.ros.bag_publisher import QUEUE_DEPTH, BagPublisher

# For the node to start [s]: a cold compilation included, on a machine with other work.
PATIENCE = 600.0
LOST_AFTER = 3.0  # [s] without an estimate while some are awaited, then these are lost
# Most time of stamps that the node may be behind; its queues hold 200 messages by default.
AHEAD_NS = 80_000_000
_WITHOUT_HEADER = (BOOL, UINT8, STRING, MARKERS)


class Player:
    """
    A node with publishers of wrench and joint states and subscriptions to all outputs.

    Parameters
    ----------
    wrench_topic, joints_topic : str
        As the bag has them: from the root.
    process : subprocess.Popen
        The node; if it ends, waiting for it ends with an error.

    Attributes
    ----------
    received : list of (str, str, int, bytes)
        Topic, type, stamp [ns], serialised message; in order of arrival. What has no stamp of its
        own has that of the newest estimate.

    """

    def __init__(self, wrench_topic: str, joints_topic: str, process: subprocess.Popen) -> None:
        rclpy.init()
        self._process = process
        self._node = rclpy.create_node("peg_on_hole_player")
        self._executor = EventsExecutor()
        self._executor.add_node(self._node)
        self._inputs = BagPublisher(
            self._node, {wrench_topic: WRENCH_TYPE, joints_topic: JOINTS_TYPE}
        )
        self._wrench_topic = wrench_topic
        self.received: list[tuple[str, str, int, bytes]] = []
        self._newest_ns = 0
        outputs = {PREFIX + suffix: ros_type for suffix, ros_type in TOPICS.items()}
        outputs["/diagnostics"] = DIAGNOSTICS
        self._outputs = [self._subscribe(*item) for item in outputs.items()]

    def _subscribe(self, topic, ros_type):
        qos = QoSProfile(depth=QUEUE_DEPTH)
        if topic.removeprefix(PREFIX) in LATCHED:
            qos.durability = DurabilityPolicy.TRANSIENT_LOCAL
        stamped = ros_type not in _WITHOUT_HEADER
        is_state = topic == PREFIX + "state"

        def take(payload):
            t_ns = self._newest_ns
            if stamped:
                t_ns = stamp_ns(payload)
                if is_state:
                    self._newest_ns = t_ns
            self.received.append((topic, ros_type, t_ns, payload))

        return self._node.create_subscription(message_class(ros_type), topic, take, qos, raw=True)

    def wait_for_node(self) -> None:
        """
        Spin until every topic has found the node.

        Raises
        ------
        PegOnHoleError
            The node ended, or does not come.

        """
        end = time.monotonic() + PATIENCE
        while not (
            self._inputs.listened_to()
            and all(subscription.get_publisher_count() for subscription in self._outputs)
        ):
            if self._process.poll() is not None:
                raise PegOnHoleError(f"the node ended with code {self._process.returncode}")
            if time.monotonic() > end:
                raise PegOnHoleError(f"the node did not come up within {PATIENCE:g} s")
            self._executor.spin_once(timeout_sec=0.05)

    def play(
        self, bag: Bag, rate: float, progress: Callable[[float], None] | None = None
    ) -> tuple[int, float]:
        """
        Publish the bag's input at its own pace times `rate`, as it was serialised.

        Where the node falls behind, this waits for it: a slow machine takes longer, and loses
        nothing.

        Parameters
        ----------
        bag : Bag
            What of it can be decoded is played.
        rate : float
            1: as fast as it was recorded.
        progress : callable, optional
            Called with the share that is done.

        Returns
        -------
        wrenches : int
            How many were published.
        seconds : float
            How long it took [s].

        Raises
        ------
        PegOnHoleError
            The node ended while it was played.

        """
        wrenches, last_ns = 0, 0
        begun = started = time.monotonic()
        for message in self._inputs.of(bag):
            begun += self._wait_for_estimates(last_ns - AHEAD_NS)
            self._spin_to(begun + message.offset_ns * 1e-9 / rate)
            self._inputs.publish(message)
            if message.topic == self._wrench_topic:
                wrenches, last_ns = wrenches + 1, stamp_ns(message.payload)
                if wrenches % 100 == 0:
                    self._check_node()
                    if progress:
                        progress(message.share)
        self._wait_for_estimates(last_ns)
        seconds = time.monotonic() - started
        self._drain()
        return wrenches, seconds

    def close(self) -> None:
        """Leave ROS."""
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.shutdown()

    def write(self, path: Path, configuration: dict[str, str]) -> None:
        """Write what was received to an MCAP file, in order of arrival, log times the stamps."""
        with path.open("wb") as stream:
            writer = Writer(stream)
            writer.start(profile="ros2", library="peg_on_hole_ros")
            writer.add_metadata("peg_on_hole_configuration", configuration)
            channels: dict[str, int] = {}
            for topic, ros_type, t_ns, payload in self.received:
                if topic not in channels:
                    text = definition(ros_type).encode()
                    schema = writer.register_schema(ros_type, "ros2msg", text)
                    latched = topic.removeprefix(PREFIX) in LATCHED
                    metadata = {"offered_qos_profiles": LATCHED_QOS} if latched else {}
                    channels[topic] = writer.register_channel(topic, "cdr", schema, metadata)
                writer.add_message(channels[topic], t_ns, payload, t_ns)
            writer.finish()

    def _spin_to(self, due):
        while True:
            left = due - time.monotonic()
            if left <= 0:
                return
            self._executor.spin_once(timeout_sec=left)

    def _wait_for_estimates(self, t_ns):
        """Spin until there are estimates up to a stamp, or none comes; return how long [s]."""
        begun = time.monotonic()
        if self._newest_ns >= t_ns or not self._newest_ns:
            return 0.0
        end, seen = begun + LOST_AFTER, self._newest_ns
        while self._newest_ns < t_ns and time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.02)
            if self._newest_ns != seen:
                seen, end = self._newest_ns, time.monotonic() + LOST_AFTER
        return time.monotonic() - begun

    def _drain(self):
        # The other topics of the last stamps are on their way; a second brings a last diagnosis.
        end = time.monotonic() + 1.0
        while time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.05)

    def _check_node(self):
        if self._process.poll() is not None:
            raise PegOnHoleError(
                f"the node ended with code {self._process.returncode} while the bag was played"
            )
