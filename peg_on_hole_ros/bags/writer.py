"""Write messages given as plain dicts to an MCAP file that any ROS 2 tool opens."""

import json
from collections.abc import Collection, Iterable
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import BinaryIO

from mcap.writer import CompressionType

from peg_on_hole_ros import __version__
from peg_on_hole_ros.bags.bulk_writer import BulkWriter, Column
from peg_on_hole_ros.config.configuration import to_parameters
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.columns import OutputColumns
from peg_on_hole_ros.messages.definitions import definition
from peg_on_hole_ros.robot.urdf_source import description_of

CONFIGURATION_METADATA = "peg_on_hole_configuration"
# The robot's URDF as `text`: who replays the bag needs no file, and the bag names none.
URDF_METADATA = "peg_on_hole_urdf"

# What a recorder notes of a publisher that keeps its last message for late subscribers; `ros2 bag
# play` offers the same. Numbers as in rmw (keep last, reliable, transient local, automatic): newer
# releases write names and read both, Humble reads only numbers.
LATCHED_QOS = """\
- history: 1
  depth: 1
  reliability: 1
  durability: 1
  deadline: {sec: 9223372036, nsec: 854775807}
  lifespan: {sec: 9223372036, nsec: 854775807}
  liveliness: 1
  liveliness_lease_duration: {sec: 9223372036, nsec: 854775807}
  avoid_ros_namespace_conventions: false
"""


class BagWriter:
    """
    A bag being written; use it in a `with` block.

    The file has its name only when it is whole: it is written as NAME.part and renamed at the
    end, and removed if the block raises.

    Parameters
    ----------
    path : str or Path
        To write; an existing file is replaced.
    configuration : Configuration, optional
        Stored as MCAP metadata `peg_on_hole_configuration`, every value as JSON.
    metadata : dict of str to dict of str to str, optional
        More metadata.
    chunk_bytes : int
        Of messages that are compressed together; what a cut-off file loses at most.
    latched : collection of str
        Topics that are played with durability transient local.

    Raises
    ------
    PegOnHoleError
        The file cannot be written there; from every method, too, as where the disk is full.

    """

    def __init__(
        self,
        path: str | Path,
        configuration: Configuration | None = None,
        metadata: dict[str, dict[str, str]] | None = None,
        chunk_bytes: int = 1 << 20,
        latched: Collection[str] = (),
    ) -> None:
        self.path = Path(path)
        self._part = part_of(self.path)
        self._metadata = dict(metadata or {})
        if configuration is not None:
            self._metadata[CONFIGURATION_METADATA] = configuration_metadata(configuration)
            self._metadata |= description_metadata(configuration)
        self._chunk_bytes = chunk_bytes
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, tuple[int, Encoder]] = {}
        self._latched = frozenset(latched)

    def write(self, topic: str, ros_type: str, message: dict, t_ns: int) -> None:
        """
        Append one message, with its stamp as log time.

        Parameters
        ----------
        topic : str
            Absolute.
        ros_type : str
            As in `sensor_msgs/msg/JointState`.
        message : dict
            Fields by name, nested; a field left out has its default.
        t_ns : int
            Log and publish time [ns], not negative.

        """
        self._check_stamp(t_ns)
        channel, encode = self._channels.get(topic) or self._channel(topic, ros_type)
        try:
            self._writer.add_message(channel, t_ns, encode(message), t_ns)
        except OSError as error:
            raise self._cannot_write(error) from None

    def _check_stamp(self, t_ns):
        if t_ns < 0:
            raise PegOnHoleError(
                f"cannot write {self.path}: a stamp of {t_ns * 1e-9:.9g} s is below 0 s, "
                "where a bag has no times; correct the stamps, or leave out this output"
            )

    def _channel(self, topic, ros_type):
        schema = self._schemas.get(ros_type)
        if schema is None:
            text = definition(ros_type).encode()
            schema = self._schemas[ros_type] = self._writer.register_schema(
                ros_type, "ros2msg", text
            )
        metadata = {"offered_qos_profiles": LATCHED_QOS} if topic in self._latched else {}
        channel = self._writer.register_channel(topic, "cdr", schema, metadata)
        self._channels[topic] = channel, Encoder(ros_type)
        return self._channels[topic]

    def write_all(self, prefix: str, messages: Iterable[tuple[str, str, dict]], t_ns: int) -> None:
        """Append (topic suffix, type, message) triples of one stamp."""
        for suffix, ros_type, message in messages:
            topic = suffix if suffix.startswith("/") else prefix + suffix
            self.write(topic, ros_type, message, t_ns)

    def write_columns(self, prefix: str, columns: OutputColumns) -> None:
        """Append all messages of many stamps, as `write_all` would those of each."""
        self._check_stamp(int(columns.t_ns.min()))
        topics, encoded = columns.topics(), []
        for topic in topics:
            name = prefix + topic.name
            channel, encode = self._channels.get(name) or self._channel(name, topic.ros_type)
            payloads = encode.many(topic.message, columns.t_ns, topic.numbers)
            encoded.append(Column(channel, payloads))
        first = 0
        for i, messages in [*columns.beside, (len(columns) - 1, [])]:
            places = slice(first, i + 1)
            if first <= i:
                rows = [Column(channel, payloads[places]) for channel, payloads in encoded]
                try:
                    self._writer.add_rows(columns.t_ns[places], rows)
                except OSError as error:
                    raise self._cannot_write(error) from None
            self.write_all(prefix, messages, int(columns.t_ns[i]))
            first = i + 1

    def add_metadata(self, name: str, values: dict[str, str]) -> None:
        """Store metadata known only at the end; a name given twice keeps the later values."""
        self._metadata[name] = values

    def __enter__(self) -> "BagWriter":
        """Open the file, and return itself."""
        self._stream: BinaryIO | None = None
        try:
            self._stream = self._part.open("wb")
            self._writer = BulkWriter(
                self._stream, chunk_size=self._chunk_bytes, compression=CompressionType.ZSTD
            )
            self._writer.start(profile="ros2", library=f"peg_on_hole_ros {__version__}")
        except BaseException as error:
            # There is no block to leave yet. A file that could not be opened is not ours.
            if self._stream or not isinstance(error, OSError):
                self._remove()
            raise self._cannot_write(error) from None
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Finish the file, or remove it if the block raised or the end cannot be written."""
        if kind is not None:
            self._remove()
            return
        try:
            for name, values in self._metadata.items():
                self._writer.add_metadata(name, values)
            self._writer.finish()
            assert self._stream
            self._stream.close()
            self._part.replace(self.path)
        except BaseException as error:
            self._remove()
            raise self._cannot_write(error) from None

    def _cannot_write(self, error):
        """Return what is raised: of the system's errors a line, any other as it is."""
        if not isinstance(error, OSError):
            return error
        return PegOnHoleError(f"cannot write {self.path}: {error.strerror}")

    def _remove(self):
        # Closing writes what is left to write, which a full disk refuses once more.
        with suppress(OSError):
            if self._stream:
                self._stream.close()
        with suppress(OSError):
            self._part.unlink()


def part_of(path: Path) -> Path:
    """Return the name that a bag has while it is being written."""
    return path.with_name(path.name + ".part")


def configuration_metadata(
    configuration: Configuration, markers_rate: float | None = None
) -> dict[str, str]:
    """Return dotted name to value as JSON, with the rate of the markers [Hz] where it is known."""
    values = to_parameters(configuration)
    if markers_rate is not None:
        values["markers_rate"] = markers_rate
    return {name: json.dumps(value) for name, value in values.items()}


def description_metadata(configuration: Configuration) -> dict[str, dict[str, str]]:
    """Return the metadata that a robot's URDF is; empty without a robot, or where it is not."""
    if configuration.joints.source == "robot":
        with suppress(PegOnHoleError):
            return {URDF_METADATA: {"text": description_of(configuration.joints)}}
    return {}
