"""The order in which messages reached the pipeline, as an MCAP file that replays bit for bit."""

from errno import EISDIR
from os import strerror
from pathlib import Path

from mcap.writer import CompressionType, IndexType, Writer

from peg_on_hole_ros.bags.writer import (
    CONFIGURATION_METADATA,
    configuration_metadata,
    description_metadata,
)
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.messages.beside_estimates import PREFIX, STRING
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.definitions import definition

# Calls of ~/reset and ~/tare change the estimate, so they are part of what arrived.
EVENT_TOPIC = f"{PREFIX}events"
# A killed node loses what is not in a complete chunk: small ones, about 0.1 s at 1.5 kHz.
CHUNK_BYTES = 16 * 1024
# The writer keeps the place of each chunk for an index at the end, some 0.6 kB: 40 MB in two hours
# at 1 kHz, where a node records for days. A longer record has no index, as that of a killed node:
# programs read it from its beginning, as this one does all.
MOST_INDEXED = 1 << 16


class ArrivalRecord:
    """
    A bag written message by message, in the order of the calls.

    Log times are the wall clock made strictly increasing, so that a reader's order is the order
    of arrival; the bytes are those that arrived. One of more than some MOST_INDEXED chunks
    has no index.

    Parameters
    ----------
    path : str or Path
        An existing file is kept: the record then goes beside it, with a number in its name.
    configuration : Configuration
        Stored as metadata, as in a replay's output; its topics are the record's, so their names
        are absolute.
    markers_rate : float
        Of the node, stored likewise [Hz]: its markers depend on it.

    Attributes
    ----------
    path : Path
        What is written.

    Raises
    ------
    PegOnHoleError
        The file cannot be written.

    """

    def __init__(
        self, path: str | Path, configuration: Configuration, markers_rate: float
    ) -> None:
        try:
            self.path, self._stream = _new_file(Path(path).expanduser())
        except OSError as error:
            raise PegOnHoleError(
                f"record_arrivals = {str(path)!r} cannot be written: {error.strerror}; "
                "name a file in a folder that exists and may be written to"
            ) from None
        self._writer = Writer(
            self._stream, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD
        )
        self._writer.start(profile="ros2", library="peg_on_hole_ros")
        self._writer.add_metadata(
            CONFIGURATION_METADATA, configuration_metadata(configuration, markers_rate)
        )
        for name, values in description_metadata(configuration).items():
            self._writer.add_metadata(name, values)
        topics = configuration.topics
        self._channels = (
            (topics.wrench, WRENCH_TYPE),
            (topics.joint_states, JOINTS_TYPE),
            (EVENT_TOPIC, STRING),
        )
        self._wrench, self._joints, self._event = self._register()
        self._encode = Encoder(STRING)
        self._last_ns = self._bytes = 0

    def wrench(self, payload: bytes, now_ns: int) -> None:
        """Append a serialised WrenchStamped that came in at a wall-clock time [ns]."""
        self._append(self._wrench, payload, now_ns)

    def joints(self, payload: bytes, now_ns: int) -> None:
        """Append a serialised JointState."""
        self._append(self._joints, payload, now_ns)

    def event(self, name: str, now_ns: int) -> None:
        """Append `reset` or `tare`."""
        self._append(self._event, self._encode({"data": name}), now_ns)

    def describe(self, configuration: Configuration) -> None:
        """Keep the robot's description, which came after the record was begun."""
        for name, values in description_metadata(configuration).items():
            self._writer.add_metadata(name, values)

    def close(self) -> None:
        """
        Finish the file; nothing can be appended after it.

        Raises
        ------
        OSError
            What was left could not be written; the file is closed, and as that of a killed node.

        """
        if not self._stream.closed:
            with self._stream:
                self._writer.finish()

    def _register(self):
        """Return the numbers of the channels, the same ones for every writer."""
        schemas = [
            self._writer.register_schema(ros_type, "ros2msg", definition(ros_type).encode())
            for _, ros_type in self._channels
        ]
        return [
            self._writer.register_channel(topic, "cdr", schema)
            for (topic, _), schema in zip(self._channels, schemas)
        ]

    def _drop_index(self):
        """Go on with a writer that knows nothing of the chunks so far, and says nothing of any."""
        self._writer.flush()
        self._writer = Writer(
            self._stream,
            chunk_size=CHUNK_BYTES,
            compression=CompressionType.ZSTD,
            # Half a summary would hide the other half of the chunks: a file without any is read
            # from its beginning.
            index_types=IndexType.MESSAGE,
            repeat_channels=False,
            repeat_schemas=False,
            use_statistics=False,
            use_summary_offsets=False,
        )
        self._register()
        self._bytes = 0

    def _append(self, channel, payload, now_ns):
        self._bytes += len(payload)
        if self._bytes > MOST_INDEXED * CHUNK_BYTES:
            self._drop_index()
        self._last_ns = max(now_ns, self._last_ns + 1)
        self._writer.add_message(
            channel, log_time=self._last_ns, publish_time=self._last_ns, data=payload
        )


def _new_file(path):
    if path.is_dir():
        # Opened, it would look like an existing record, and a numbered one go beside the folder.
        raise IsADirectoryError(EISDIR, strerror(EISDIR))
    for number in range(1_000_000):
        candidate = path.with_name(f"{path.stem}_{number}{path.suffix}") if number else path
        try:
            return candidate, candidate.open("xb")
        except FileExistsError:
            continue
    raise OSError(17, f"{path} and all its numbered names exist")
