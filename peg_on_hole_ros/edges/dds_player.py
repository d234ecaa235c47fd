"""Plays a bag's input into a running node over DDS and keeps what the node publishes."""

import struct
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import rclpy
from mcap.reader import make_reader
from mcap.writer import Writer
from rclpy.experimental import EventsExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from peg_on_hole_ros.edges.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.edges.message_definitions import definition
from peg_on_hole_ros.edges.messages import BOOL, DIAGNOSTICS, LATCHED, MARKERS, STRING, TOPICS
from peg_on_hole_ros.edges.ros_messages import message_class
from peg_on_hole_ros.errors import PegOnHoleError

PREFIX = "/peg_on_hole/"
PATIENCE = 120.0  # [s] for the node to start, a cold compilation included
SILENCE = 3.0  # [s] without an estimate after the last wrench, then the rest is lost
DEPTH = 20_000
_WITHOUT_HEADER = (BOOL, STRING, MARKERS)
_STAMP = struct.Struct("<iI")


class Player:
    """
    A node with publishers of wrench and joint states and subscriptions to all outputs.

    Parameters
    ----------
    wrench_topic, joints_topic : str
    process : subprocess.Popen
        The node; if it ends, waiting for it ends with an error.

    Attributes
    ----------
    received : list of (str, str, int, bytes)
        Topic, type, stamp [ns], serialised message; in order of arrival. What has no stamp of its
        own has that of the newest estimate.

    """

    def __init__(self, wrench_topic: str, joints_topic: str, process: subprocess.Popen):
        rclpy.init()
        self._process = process
        self._node = rclpy.create_node("peg_on_hole_player")
        self._executor = EventsExecutor()
        self._executor.add_node(self._node)
        # Best effort, as force-torque drivers send; the node takes both.
        qos = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT)
        self._inputs = {
            topic: self._node.create_publisher(message_class(ros_type), topic, qos)
            for topic, ros_type in ((wrench_topic, WRENCH_TYPE), (joints_topic, JOINTS_TYPE))
        }
        self._wrench_topic = wrench_topic
        self.received: list[tuple[str, str, int, bytes]] = []
        self._newest_ns = 0
        outputs = {PREFIX + suffix: ros_type for suffix, ros_type in TOPICS.items()}
        outputs["/diagnostics"] = DIAGNOSTICS
        self._outputs = [self._subscribe(*item) for item in outputs.items()]

    def _subscribe(self, topic, ros_type):
        qos = QoSProfile(depth=DEPTH)
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
            all(publisher.get_subscription_count() for publisher in self._inputs.values())
            and all(subscription.get_publisher_count() for subscription in self._outputs)
        ):
            if self._process.poll() is not None:
                raise PegOnHoleError(f"the node ended with code {self._process.returncode}")
            if time.monotonic() > end:
                raise PegOnHoleError(f"the node did not come up within {PATIENCE:g} s")
            self._executor.spin_once(timeout_sec=0.05)

    def play(
        self, path: Path, rate: float, progress: Callable[[float], None] | None = None
    ) -> tuple[int, float]:
        """
        Publish the bag's input at its own pace times `rate`, as it was serialised.

        Parameters
        ----------
        path : Path
            An .mcap file.
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
        begun = time.monotonic()
        for share, offset_ns, topic, payload in _recorded(path, list(self._inputs)):
            self._spin_to(begun + offset_ns * 1e-9 / rate)
            self._inputs[topic].publish(payload)
            if topic == self._wrench_topic:
                wrenches, last_ns = wrenches + 1, stamp_ns(payload)
                if wrenches % 100 == 0:
                    self._check_node()
                    if progress:
                        progress(share)
        seconds = time.monotonic() - begun
        self._drain(last_ns)
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
                    channels[topic] = writer.register_channel(topic, "cdr", schema)
                writer.add_message(channels[topic], t_ns, payload, t_ns)
            writer.finish()

    def _spin_to(self, due):
        while True:
            left = due - time.monotonic()
            if left <= 0:
                return
            self._executor.spin_once(timeout_sec=left)

    def _drain(self, last_ns):
        end = time.monotonic() + SILENCE
        seen = self._newest_ns
        while time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.05)
            if self._newest_ns != seen:
                seen, end = self._newest_ns, time.monotonic() + SILENCE
            if seen >= last_ns:
                # The other topics of the last stamp are on their way.
                end = min(end, time.monotonic() + 0.2)
                last_ns = seen + 1

    def _check_node(self):
        if self._process.poll() is not None:
            raise PegOnHoleError(
                f"the node ended with code {self._process.returncode} while the bag was played"
            )


def stamp_ns(payload: bytes) -> int:
    """Return the stamp of a serialised message that begins with a header [ns]."""
    sec, nanosec = _STAMP.unpack_from(payload, 4)
    return sec * 1_000_000_000 + nanosec


def _recorded(path, topics):
    with path.open("rb") as stream:
        reader = make_reader(stream)
        statistics = reader.get_summary().statistics
        first = statistics.message_start_time
        whole = max(1, statistics.message_end_time - first)
        for _, channel, message in reader.iter_messages(topics):
            offset_ns = message.log_time - first
            yield offset_ns / whole, offset_ns, channel.topic, message.data
