"""Read bags: an `.mcap` file or a rosbag2 folder, in order of log time, in bounded memory."""

import heapq
import struct
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory

from peg_on_hole_ros.edges.bags.files import BagFiles, bag_files, listed
from peg_on_hole_ros.edges.bags.scan import (
    Block,
    Scan,
    TopicInfo,
    chunk_content,
    messages_of,
    open_file,
    scan_file,
)
from peg_on_hole_ros.edges.messages.definitions import definition
from peg_on_hole_ros.errors import BagError

# A recorder that splits may put messages that came together into either file, and leaves no gap
# but that between two messages [ns].
_APART_NS = 1_000_000_000
# Of the messages, and of their definitions.
_ENCODINGS = ("cdr, ros2msg", "cdr, ros2idl", "cdr, ")
# A payload that does not fit its definition.
_UNDECODABLE = (struct.error, ValueError, IndexError, OverflowError, MemoryError)


class BagMessage(NamedTuple):
    """
    One message of a bag.

    Attributes
    ----------
    topic : str
    log_ns : int
        When it was recorded [ns].
    message : object
        Fields as attributes, named as in ROS.

    """

    topic: str
    log_ns: int
    message: Any


def absolute(topic: str) -> str:
    """Return the name that a bag has for a topic; one without a slash lies in the root."""
    return topic if topic.startswith("/") else f"/{topic}"


class Bag:
    """
    A bag whose records have been read through once.

    Parameters
    ----------
    path : str or Path
        An `.mcap` file or a folder of them.
    progress : callable, optional
        Called with the share of each file that was read.

    Attributes
    ----------
    path : Path
        As it was given.
    topics : dict of str to TopicInfo
    metadata : dict of str to dict of str to str
        MCAP metadata by name.
    damage : str
        Why reading ended early; empty for a whole bag.
    unnamed : tuple of Path
        MCAP files of the folder that its metadata.yaml does not name, and that were not read.
    undecodable : Counter
        By topic: payloads that `messages` skipped since they do not fit their definition.

    """

    def __init__(self, path: str | Path, progress: Callable[[float], None] | None = None):
        self.path = Path(path)
        self.topics: dict[str, TopicInfo] = {}
        self.undecodable: Counter[str] = Counter()
        self.damage = ""
        self.metadata: dict[str, dict[str, str]] = {}
        self._scans: list[Scan] = []
        files = bag_files(path)
        self.unnamed = files.unnamed
        for index, file in enumerate(files.files):
            scan = scan_file(file, index, self.topics, progress)
            self._scans.append(scan)
            self.metadata |= scan.metadata
            if scan.damage:
                self.damage = f"{file} is {scan.damage}" + _behind(files.files[index + 1 :])
                break
        _check_one_recording(files, self._scans)
        # Sorting is stable: blocks that begin at one time stay in the order of the file.
        blocks = [block for scan in self._scans for block in scan.blocks]
        self._order = sorted(range(len(blocks)), key=lambda i: blocks[i].first_ns)
        self._blocks = blocks

    @property
    def count(self) -> int:
        """Number of all messages that can be read."""
        return sum(info.count for info in self.topics.values())

    def require(self, types: dict[str, str], remedy: str = "") -> None:
        """
        Raise BagError unless each topic is there, with messages, of its type.

        Parameters
        ----------
        types : dict of str to str
            Topic to ROS type, as in `geometry_msgs/msg/WrenchStamped`.
        remedy : str
            What to do where a topic is missing.

        """
        remedy = f"; {remedy}" if remedy else ""
        cut = f"; {self.damage}" if self.damage else ""
        if not self.count:
            raise BagError(f"{self.path} holds no messages{cut}")
        for topic, ros_type in types.items():
            info = self.topics.get(topic)
            if info is None or not info.count:
                raise BagError(
                    f"{self.path} has no messages on {topic} ({ros_type}); it has: "
                    f"{self.listing()}{remedy}{cut}"
                )
            if info.types != [ros_type]:
                found = " and ".join(name or "no type" for name in info.types)
                raise BagError(
                    f"{self.path}: {topic} is {found}, not {ros_type}; it has: {self.listing()}"
                    f"{remedy}"
                )
            for encoding in info.encodings:
                if encoding not in _ENCODINGS:
                    raise BagError(
                        f"{self.path}: {topic} is encoded as {encoding}; only messages of ROS 2 "
                        "(cdr, with ros2msg or ros2idl) can be read"
                    )

    def listing(self) -> str:
        """Return topics with type and count, for an error message."""
        rows = (
            f"{info.name} ({' and '.join(info.types)}, {info.count})"
            for info in sorted(self.topics.values(), key=lambda info: info.name)
            if info.count
        )
        return ", ".join(rows) or "nothing"

    def messages(self, topics: Iterable[str]) -> Iterator[BagMessage]:
        """Yield decoded messages in order of log time, those of one time in the file's order."""
        for message, _ in self.with_payloads(topics):
            yield message

    def with_payloads(self, topics: Iterable[str]) -> Iterator[tuple[BagMessage, bytes]]:
        """Yield what `messages` does, each with the bytes in which it was recorded."""
        wanted = set(topics)
        decoders = [_decoders(scan, wanted) for scan in self._scans]
        for log_ns, file, channel_id, payload in self._payloads(decoders):
            topic, decode = decoders[file][channel_id]
            try:
                message = decode(payload)
            except _UNDECODABLE:
                self.undecodable[topic] += 1
                continue
            yield BagMessage(topic, log_ns, message), payload

    def _payloads(self, channels):
        """Merge the blocks: a message waits until no block still to come can precede it."""
        heap: list = []
        streams = [open_file(scan.path) for scan in self._scans]
        try:
            for ordinal in self._order:
                block = self._blocks[ordinal]
                while heap and heap[0][0] < block.first_ns:
                    yield _unpacked(heapq.heappop(heap))
                content = _content(streams[block.file], block)
                for position, (channel_id, log_ns, payload) in enumerate(messages_of(content)):
                    if channel_id in channels[block.file]:
                        item = (log_ns, ordinal, position, block.file, channel_id, payload)
                        heapq.heappush(heap, item)
            while heap:
                yield _unpacked(heapq.heappop(heap))
        finally:
            for stream in streams:
                stream.close()


def _behind(unread):
    """Return which parts are not read, as one before them is damaged, to be added to that."""
    names = listed([file.name for file in unread])
    return f"; the parts behind it are not read: {names}" if unread else ""


def _check_one_recording(files: BagFiles, scans: list[Scan]):
    """
    Refuse files that no description holds together and that do not follow one another in time.

    A recorder goes on in the next part with the next message. It may have been paused there, so
    a gap is believed where the files are called as it calls them.
    """
    if files.description is not None:
        return
    spans = []
    for scan in scans:
        if scan.blocks:
            first = min(block.first_ns for block in scan.blocks)
            spans.append((first, max(block.last_ns for block in scan.blocks), scan.path.name))
    for (begun, end, before), (begin, last, after) in zip(spans, spans[1:]):
        what = ""
        if begin - end > _APART_NS and not files.named_by_recorder():
            what = f"{after} begins {(begin - end) * 1e-9:.3f} s after {before} has ended"
        elif begun >= last:
            what = f"{after} was recorded before {before}"
        elif end - begin > min(_APART_NS, (last - begin) // 2, (end - begun) // 2):
            what = f"{before} and {after} overlap by {(min(end, last) - begin) * 1e-9:.3f} s"
        if what:
            raise BagError(
                f"{files.path} has no metadata.yaml, and {what}, so they are not parts of one "
                f"recording; {files.remedy()}"
            )


def _unpacked(item):
    log_ns, _, _, file, channel_id, payload = item
    return log_ns, file, channel_id, payload


def _content(stream, block: Block):
    try:
        stream.seek(block.start)
        body = stream.read(block.length)
    except OSError as error:
        raise BagError(f"cannot read {stream.name}: {error.strerror}") from None
    return chunk_content(body, validate=False) if block.chunk else body


def _decoders(scan, wanted):
    factory = DecoderFactory()
    decoders = {}
    for channel in scan.channels.values():
        schema = scan.schemas.get(channel.schema_id)
        if channel.topic in wanted and schema is not None:
            if not schema.data or schema.encoding == "ros2idl":
                # Some recorders leave the definition out, or have it as IDL, from which the same
                # bytes come; that of a type known here will do.
                text = definition(schema.name).encode()
                schema = Schema(id=schema.id, name=schema.name, encoding="ros2msg", data=text)
            try:
                decode = factory.decoder_for(channel.message_encoding, schema)
            except Exception as error:
                # The parser of definitions has a dozen exceptions with no base but this.
                raise BagError(
                    f"{scan.path}: the definition of {schema.name} on {channel.topic} cannot be "
                    f"read: {error}"
                ) from None
            if decode is not None:
                decoders[channel.id] = (channel.topic, decode)
    return decoders
