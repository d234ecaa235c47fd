"""The node's record of arrivals, which may end before the node does."""

import time
from collections.abc import Callable
from dataclasses import asdict, replace

from rclpy.node import Node

from peg_on_hole_ros.bags.arrival_record import ArrivalRecord
from peg_on_hole_ros.config.options import Configuration, NodeOptions, Topics


class ArrivalsFile:
    """
    Keeps what arrives in a file; where it cannot be written that ends, with a line in the log.

    Parameters
    ----------
    node : Node
        Whose arrivals they are.
    configuration : Configuration
    options : NodeOptions
        With the file's name, empty for none, and the rate of the markers.

    Raises
    ------
    PegOnHoleError
        The file cannot be begun.

    """

    def __init__(self, node: Node, configuration: Configuration, options: NodeOptions) -> None:
        self._logger = node.get_logger()
        self._record: ArrivalRecord | None = None
        if not options.record_arrivals:
            return
        # As they are after remapping, in this namespace: a replay knows neither.
        names = asdict(configuration.topics)
        topics = Topics(**{name: node.resolve_topic_name(topic) for name, topic in names.items()})
        self._record = ArrivalRecord(
            options.record_arrivals, replace(configuration, topics=topics), options.markers_rate
        )
        self._logger.info(f"recording arrivals to {self._record.path}")

    def wrench(self, payload: bytes) -> None:
        """Keep a serialised WrenchStamped that has come in."""
        self._write(lambda record: record.wrench(payload, time.time_ns()))

    def joints(self, payload: bytes) -> None:
        """Keep a serialised JointState that has come in."""
        self._write(lambda record: record.joints(payload, time.time_ns()))

    def event(self, name: str) -> None:
        """Keep a call of `reset` or `tare`."""
        self._write(lambda record: record.event(name, time.time_ns()))

    def describe(self, configuration: Configuration) -> None:
        """Keep the robot's description."""
        self._write(lambda record: record.describe(configuration))

    def close(self) -> None:
        """Finish the file; nothing is kept after it."""
        self._write(ArrivalRecord.close)
        self._record = None

    def _write(self, act: Callable[[ArrivalRecord], None]):
        if self._record is None:
            return
        try:
            act(self._record)
        except OSError as error:
            path, self._record = self._record.path, None
            self._logger.error(f"recording to {path} ended: {error.strerror}")
