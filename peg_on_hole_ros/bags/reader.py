"""Read bags in order of log time, in bounded memory: as arrays, or message by message."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from peg_on_hole_ros.bags.batch import Batch, Item
from peg_on_hole_ros.bags.storage.bag_files import bag_files, check_one_recording
from peg_on_hole_ros.bags.storage.decoders import decoders_of
from peg_on_hole_ros.bags.storage.first_pass import FileContent, TopicInfo
from peg_on_hole_ros.bags.storage.fixed_layouts import NO_LAYOUT, Layouts
from peg_on_hole_ros.bags.storage.oversized import skipped_lines
from peg_on_hole_ros.bags.storage.storages import OpenFiles, storage_of
from peg_on_hole_ros.bags.storage.time_order import in_order, part_of
from peg_on_hole_ros.bags.storage.unpacking import MOST_CHUNK
from peg_on_hole_ros.errors import BagError
from peg_on_hole_ros.messages.encapsulation import foreign
from peg_on_hole_ros.safe_text import cut, listed

# Of the messages, and of their definitions.
_ENCODINGS = ("cdr, ros2msg", "cdr, ros2idl", "cdr, ")
_NAMELESS = "cdr, no schema"
_ROS1 = "ros1"
# Of a topic with its type and count, in an error [characters].
_LONGEST_ROW = 200


class BagMessage(NamedTuple):
    """
    One message of a bag.

    Attributes
    ----------
    topic : str
    log_ns : int
        When it was recorded; where that is wrong, when it must have been [ns].
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
        An `.mcap` or `.db3` file, packed as a whole or not, or a folder of them.
    progress : callable, optional
        Called with the share of each file that was read.
    most_chunk : int
        Bytes that a chunk may take unpacked.

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
        Files of the folder that its metadata.yaml does not name, and that were not read.
    undecodable : Counter
        By topic: payloads that were skipped since they do not fit their definition.

    """

    def __init__(
        self,
        path: str | Path,
        progress: Callable[[float], None] | None = None,
        most_chunk: int = MOST_CHUNK,
    ) -> None:
        self.path = Path(path)
        self.topics: dict[str, TopicInfo] = {}
        self.undecodable: Counter[str] = Counter()
        self._foreign: dict[str, set[str]] = {}
        self.damage = ""
        self.metadata: dict[str, dict[str, str]] = {}
        self._scans: list[FileContent] = []
        self._most = most_chunk
        files = bag_files(path)
        self.unnamed, self._stands_for = files.unnamed, files.stands_for
        for index, file in enumerate(files.files):
            scan = storage_of(file).scan_file(file, index, self.topics, progress, most_chunk)
            self._scans.append(scan)
            self.metadata |= scan.metadata
            if scan.damage:
                self.damage = f"{file} is {scan.damage}" + _behind(files.files[index + 1 :])
                break
        spans = [(scan.span(), scan.path.name) for scan in self._scans]
        check_one_recording(files, [(*span, name) for span, name in spans if span])
        self._blocks = [block for scan in self._scans for block in scan.blocks]

    @property
    def count(self) -> int:
        """Number of all messages that can be read."""
        return sum(info.count for info in self.topics.values())

    @property
    def span_ns(self) -> tuple[int, int]:
        """First and last time of the recorder's clock, of a bag with messages [ns]."""
        held = [info for info in self.topics.values() if info.count]
        return min(info.first_ns for info in held), max(info.last_ns for info in held)

    @property
    def skipped(self) -> list[str]:
        """What was too large to be read, and what would read it, a line each."""
        skipped = []
        for scan in self._scans:
            topics = {number: channel.topic for number, channel in scan.channels.items()}
            skipped += [(each, topics) for each in scan.skipped]
        return skipped_lines(skipped, self._most)

    def require(self, types: dict[str, str], remedy: str = "") -> None:
        """
        Raise BagError unless each topic is there, with messages, of its type.

        A topic whose type the bag does not name is taken for what it has to be.

        Parameters
        ----------
        types : dict of str to str
            Topic to ROS type, as in `geometry_msgs/msg/WrenchStamped`.
        remedy : str
            What to do where a topic is missing.

        """
        remedy = f"; {remedy}" if remedy else ""
        more = "".join(f"; {line}" for line in [*filter(None, [self.damage]), *self.skipped])
        if not self.count:
            raise BagError(f"{self.path} holds no messages{more}")
        for topic, ros_type in types.items():
            info = self.topics.get(topic)
            if info is None or not info.count:
                raise BagError(
                    f"{self.path} has no messages on {topic} ({ros_type}); it has: "
                    f"{self.listing(ros_type)}{remedy}{more}"
                )
            for encoding in info.encodings:
                self._check_encoding(topic, encoding)
            if info.types not in ([ros_type], [""]):
                found = " and ".join(name or "no type" for name in info.types)
                raise BagError(
                    f"{self.path}: {topic} is {found}, not {ros_type}; it has: "
                    f"{self.listing(ros_type)}"
                    f"{remedy}"
                )

    def _check_encoding(self, topic, encoding):
        if encoding.startswith(_ROS1):
            raise BagError(
                f"{self.path}: {topic} is encoded as {encoding}, so this is a recording of ROS 1; "
                f"convert the bag it was made of: rosbags-convert --src RECORDING.bag --dst FOLDER"
            )
        if encoding not in (*_ENCODINGS, _NAMELESS):
            raise BagError(
                f"{self.path}: {topic} is encoded as {encoding}; only messages of ROS 2 "
                "(cdr, with ros2msg or ros2idl) can be read"
            )

    def listing(self, ros_type: str = "") -> str:
        """Return topics with type and count, for an error message; those of a type come first."""
        infos = [info for info in self.topics.values() if info.count]
        infos.sort(key=lambda info: (ros_type not in info.types, info.name))
        rows = (
            f"{cut(info.name)} ({' and '.join(name or 'no type' for name in info.types)}, "
            f"{info.count})"
            for info in infos
        )
        return listed(rows, longest=_LONGEST_ROW) if infos else "nothing"

    def remarks(self, types: dict[str, str]) -> list[str]:
        """
        Return a line for each thing that was not as it should be and could be read all the same.

        Parameters
        ----------
        types : dict of str to str
            Topics that are of interest, with their types.

        """
        told = [
            f"files: {read.name} is read for the {named} of metadata.yaml"
            for named, read in self._stands_for.items()
        ]
        told += self.skipped
        infos = [self.topics[topic] for topic in types if topic in self.topics]
        wrong = sum(info.wrong_log_times for info in infos)
        if wrong:
            topics = ", ".join(
                f"{info.name} {info.wrong_log_times}" for info in infos if info.wrong_log_times
            )
            told.append(
                f"log time: {wrong} messages ({topics}) have a log time that cannot be, far from "
                "their stamp and from the messages about them; they are placed by their stamp"
            )
        for info in infos:
            if info.lacking:
                told.append(
                    f"definition: that of {' and '.join(info.types)} on {info.name} is incomplete "
                    f"(it lacks {info.lacking}): read by the type's name"
                )
            if info.types == [""]:
                told.append(
                    f"definition: {info.name} has no type in the bag; read as {types[info.name]}"
                )
        return told

    def messages(self, topics: Iterable[str]) -> Iterator[BagMessage]:
        """Yield decoded messages in order of log time, those of one time in the file's order."""
        for message, _ in self.with_payloads(topics):
            yield message

    def with_payloads(self, topics: Iterable[str]) -> Iterator[tuple[BagMessage, bytes]]:
        """Yield what `messages` does, each with the bytes in which it was recorded."""
        names = list(topics)
        decoders = self._decoders(dict.fromkeys(names))
        for part in self._parts(decoders, None):
            columns = part.log_ns, part.topic, part.file, part.channel
            rows = zip(*(column.tolist() for column in columns), part.payload)
            for log_ns, topic, file, channel, payload in rows:
                message = self._decoded(decoders[file][channel], payload)
                if message is not None:
                    yield BagMessage(names[topic], log_ns, message), payload

    def batches(self, types: dict[str, str], efforts: bool = False) -> Iterator[Batch]:
        """
        Yield all messages of some topics in order of log time, as arrays.

        Parameters
        ----------
        types : dict of str to str
            Topics with their types; wrenches and joint states become numbers.
        efforts : bool
            Whether efforts of joint states are read too, behind the positions.

        """
        decoders, layouts = self._decoders(types), Layouts(efforts)
        for part in self._parts(decoders, layouts):
            others, kept = {}, np.ones(len(part.log_ns), bool)
            for i in np.flatnonzero(part.layout == NO_LAYOUT).tolist():
                decoder = decoders[int(part.file[i])][int(part.channel[i])]
                message = self._decoded(decoder, part.payload[i])
                kept[i] = message is not None
                if kept[i]:
                    others[i] = message
            if not kept.all():
                now = np.cumsum(kept) - 1
                others = {int(now[i]): message for i, message in others.items()}
                part = part.of(kept)
            numbers = part.topic, part.log_ns, part.t_ns, part.layout, part.values
            yield Batch(types, layouts.all, *numbers, others)

    def items(self, types: dict[str, str], joints: tuple[str, ...] = ()) -> Iterator[Item]:
        """
        Yield the messages of `batches` one by one, as samples.

        Parameters
        ----------
        types : dict of str to str
            Topics with their types.
        joints : tuple of str
            Those whose positions have to be finite; empty: all.

        """
        for batch in self.batches(types):
            yield from batch.items(joints)

    def foreign(self) -> list[str]:
        """Return a line for each way of serialising that was met so far and is not read."""
        return [
            f"encoding: messages on {listed(sorted(topics))} are in {kind}, which is not read: "
            "have them published and recorded in CDR (XCDR1), as ROS 2 does"
            for kind, topics in self._foreign.items()
        ]

    def _decoded(self, decoder, payload):
        kind = foreign(payload)
        if kind:
            # Read as CDR it would give other numbers.
            self.undecodable[decoder.topic] += 1
            self._foreign.setdefault(kind, set()).add(decoder.topic)
            return None
        try:
            return decoder.decode(payload)
        except Exception:
            # A payload that does not fit its definition, or a definition of what the library
            # cannot read, as wstring: it has a dozen exceptions with no base but this.
            self.undecodable[decoder.topic] += 1
            return None

    def _parts(self, decoders, layouts):
        """Yield messages of the channels that have a decoder, in their order."""
        with OpenFiles([scan.path for scan in self._scans], self._most) as files:

            def load(block):
                rows = block.with_log_times_repaired(files.rows(block))
                return part_of(block.file, rows, decoders[block.file], layouts, self._most)

            yield from in_order(self._blocks, load)

    def _decoders(self, types):
        return [
            decoders_of(scan.path, scan.channels.values(), scan.schemas, types)
            for scan in self._scans
        ]


def _behind(unread):
    """Return which parts are not read, as one before them is damaged, to be added to that."""
    names = listed([file.name for file in unread])
    return f"; the parts behind it are not read: {names}" if unread else ""
