"""What a first pass through the files of a bag learns: topics, blocks, wrong log times, loss."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mcap.records import Channel, Schema, Statistics

from peg_on_hole_ros.bags.log_times import LogTimes
from peg_on_hole_ros.bags.message_places import Rows, gathered, unpacked
from peg_on_hole_ros.bags.schemas import serving

# Encapsulation, then the stamp.
_STAMP = np.dtype([("form", "<u2"), ("options", "<u2"), ("sec", "<i4"), ("nanosec", "<u4")])
_LITTLE_ENDIAN = 0x0100


class Block(NamedTuple):
    """
    A chunk, a run of messages outside chunks, or the messages of an SQLite file of some time.

    Attributes
    ----------
    file, start, length : int
        Index of the file; where the chunk's content, or the run of records, lies in it. Of an
        SQLite file the least and the greatest log time [ns].
    chunk : bool
    first_ns, last_ns : int
        Least and greatest log time in it, wrong ones replaced [ns].
    wrong, place_ns : ndarray of int64, shape (m,)
        Which of its messages have a wrong log time, and the time that takes its place [ns].

    """

    file: int
    start: int
    length: int
    chunk: bool
    first_ns: int = 0
    last_ns: int = 0
    wrong: np.ndarray = np.empty(0, np.int64)
    place_ns: np.ndarray = np.empty(0, np.int64)

    def in_place(self, rows: Rows) -> Rows:
        """Return its messages with wrong log times replaced."""
        if not len(self.wrong):
            return rows
        log_ns = rows.log_ns.copy()
        log_ns[self.wrong] = self.place_ns
        return rows._replace(log_ns=log_ns)


@dataclass
class TopicInfo:
    """What a scan learnt about one topic; `types` has more than one entry only in an odd bag."""

    name: str
    types: list[str] = field(default_factory=list)
    encodings: list[str] = field(default_factory=list)
    count: int = 0
    first_ns: int = 0
    last_ns: int = 0
    wrong_log_times: int = 0
    # Types within its definition that the bag leaves out.
    lacking: str = ""


class Found:
    """
    Content of one file as far as it could be read; `damage` says why it ended early.

    Attributes
    ----------
    path : Path
    topics : dict of str to TopicInfo
        Of the whole bag.
    schemas : dict of int to Schema
    channels : dict of int to Channel
    blocks : list of Block
    metadata : dict of str to dict of str to str
    damage : str

    """

    def __init__(self, path: Path, topics: dict[str, TopicInfo]) -> None:
        self.path, self.topics = path, topics
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.blocks: list[Block] = []
        self.metadata: dict[str, dict[str, str]] = {}
        self.damage = ""
        self._counts: Counter[int] = Counter()
        self._stamped: dict[int, bool] = {}
        self._log_times = LogTimes()

    def add_channel(self, channel: Channel) -> None:
        """Take a channel; its schema has to be there, if it has one."""
        known = self.channels.get(channel.id)
        self.channels[channel.id] = channel
        if known == channel:
            return
        info = self.topics.setdefault(channel.topic, TopicInfo(channel.topic))
        schema = self.schemas.get(channel.schema_id)
        name = schema.name if schema else ""
        if name not in info.types:
            info.types.append(name)
        encoding = f"{channel.message_encoding}, {schema.encoding if schema else 'no schema'}"
        if encoding not in info.encodings:
            info.encodings.append(encoding)
        found = serving(schema)
        info.lacking = info.lacking or found.lacking
        self._stamped[channel.id] = found.stamped

    def check(self, channels: Iterable[int]) -> None:
        """Refuse messages of a channel that was not declared."""
        for channel in channels:
            if channel not in self.channels:
                raise ValueError(f"a message of channel {channel}, which is not declared")

    def add(self, rows: Rows, block: Block, most: int) -> None:
        """
        Take the messages of a block.

        Raises
        ------
        ValueError
            Of a channel that was not declared, or packed ones that take more than `most` bytes.

        """
        self.check(np.unique(rows.channel).tolist())
        if not len(rows.channel):
            return
        wrong, place_ns = self._wrong(rows, most)
        block = block._replace(wrong=wrong, place_ns=place_ns)
        log_ns = block.in_place(rows).log_ns
        block = block._replace(first_ns=int(log_ns.min()), last_ns=int(log_ns.max()))
        self.blocks.append(block)
        replaced = np.bincount(rows.channel[wrong], minlength=int(rows.channel.max()) + 1)
        for number in np.unique(rows.channel).tolist():
            info = self.topics[self.channels[number].topic]
            of = log_ns[rows.channel == number]
            first, last = int(of.min()), int(of.max())
            info.first_ns = min(info.first_ns, first) if info.count else first
            info.last_ns = max(info.last_ns, last) if info.count else last
            info.count += len(of)
            info.wrong_log_times += int(replaced[number])
            self._counts[number] += len(of)

    def _wrong(self, rows, most):
        channels = [number for number, stamped in self._stamped.items() if stamped]
        places = np.flatnonzero(np.isin(rows.channel, channels))
        stamped = unpacked(rows.of(places), most)
        long = np.flatnonzero(stamped.end - stamped.start >= _STAMP.itemsize)
        stamp = gathered(stamped.data, stamped.start[long], _STAMP)
        good = (stamp["form"] == _LITTLE_ENDIAN) & (stamp["nanosec"] < 1_000_000_000)
        t_ns = stamp["sec"].astype(np.int64) * 1_000_000_000 + stamp["nanosec"]
        at = places[long[good]]
        wrong, place_ns = self._log_times.placed(rows.log_ns[at], t_ns[good])
        return at[wrong], place_ns

    def lost(self, statistics: Statistics) -> str:
        """Return how many messages its statistics count that were not there, or nothing."""
        counts = statistics.channel_message_counts
        short = {number: n - self._counts[number] for number, n in counts.items()}
        total = statistics.message_count
        lost = total - self._counts.total()
        if lost <= 0:
            return ""
        topics = ", ".join(
            sorted(
                f"{self.channels[number].topic if number in self.channels else number} {n}"
                for number, n in short.items()
                if n > 0
            )
        )
        return (
            f"{lost} of {total} messages that its index counts are not in it ({topics}): a part "
            "was cut out"
        )
