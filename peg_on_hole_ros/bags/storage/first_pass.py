"""What a first pass through the files of a bag learns: topics, blocks, wrong log times, loss."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mcap.records import Channel, Schema, Statistics

from peg_on_hole_ros.bags.storage.decoders import serving
from peg_on_hole_ros.bags.storage.log_times import ABOUT, LogTimes
from peg_on_hole_ros.bags.storage.message_rows import MessageRows, unpacked
from peg_on_hole_ros.bags.storage.oversized import Skipped
from peg_on_hole_ros.messages.cdr_layout import stamps

# Messages whose log times are decided together.
_DECIDED_TOGETHER = 4096


class Block(NamedTuple):
    """
    A chunk, a run of messages outside chunks, or a stretch of the messages of an SQLite file.

    Attributes
    ----------
    file, start, length : int
        Index of the file; where the chunk's content, or the run of records, lies in it. Of an
        SQLite file ids of the first and the last message.
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

    def with_log_times_repaired(self, rows: MessageRows) -> MessageRows:
        """Return its messages with wrong log times replaced."""
        if not len(self.wrong):
            return rows
        log_ns = rows.log_ns.copy()
        log_ns[self.wrong] = self.place_ns
        return rows._replace(log_ns=log_ns)


class _Read(NamedTuple):
    # A block with channels and log times of its messages, which of them have a stamp, and these.
    block: Block
    channel: np.ndarray
    log_ns: np.ndarray
    at: np.ndarray
    stamp_ns: np.ndarray


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


class FileContent:
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
    skipped : list of Skipped
        What was too large to be read.
    damage : str

    """

    def __init__(self, path: Path, topics: dict[str, TopicInfo]) -> None:
        self.path, self.topics = path, topics
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.blocks: list[Block] = []
        self.metadata: dict[str, dict[str, str]] = {}
        self.skipped: list[Skipped] = []
        self.damage = ""
        self._counts: Counter[int] = Counter()
        self._stamped: dict[int, bool] = {}
        self._log_times = LogTimes()
        # Messages by block whose log times are not yet decided.
        self._open: list[_Read] = []
        self._read = 0

    def add_channel(self, channel: Channel) -> None:
        """Take a channel; its schema has to be there, if it has one."""
        known = self.channels.get(channel.id)
        if known == channel:
            return
        if known is not None:
            # What came so far is of the one before.
            self._decide(0)
        self.channels[channel.id] = channel
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

    def add(self, rows: MessageRows, block: Block, most: int) -> None:
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
        at, stamp_ns = self._stamps(rows, most)
        self._open.append(_Read(block, rows.channel, rows.log_ns, at, stamp_ns))
        self._counts.update(dict(zip(*_counted(rows.channel))))
        self._read += len(rows.channel)
        # A file of small chunks is decided as one of large ones.
        if self._read >= _DECIDED_TOGETHER:
            self._decide(ABOUT)

    def skip(self, skipped: Skipped) -> None:
        """Take note of what is too large to be read."""
        self.skipped.append(skipped)
        self._counts.update(skipped.channels)

    def finish(self) -> None:
        """Take note that no messages follow."""
        self._decide(0)

    def _stamps(self, rows, most):
        """Return which messages have a stamp, and the stamps [ns]."""
        channels = [number for number, stamped in self._stamped.items() if stamped]
        places = np.flatnonzero(np.isin(rows.channel, channels))
        stamped = unpacked(rows.of(places), most)
        has, t_ns = stamps(stamped.data, stamped.start, stamped.end)
        return places[has], t_ns[has]

    def _decide(self, behind):
        """Decide of log times, of blocks that have so many messages behind them."""
        reads = self._open
        ends = np.cumsum([len(each.at) for each in reads])
        stamped = int(ends[-1]) if reads else 0
        done = int(np.searchsorted(ends, max(stamped - behind, 0), "right"))
        if not done:
            return
        count, some = int(ends[done - 1]), slice(int(ends[done - 1]) + behind)
        log_ns = np.concatenate([each.log_ns[each.at] for each in reads])[some]
        stamp_ns = np.concatenate([each.stamp_ns for each in reads])[some]
        wrong, place_ns = self._log_times.placed(log_ns, stamp_ns, count)
        for read, end in zip(reads[:done], ends.tolist()):
            first = end - len(read.at)
            of = slice(*np.searchsorted(wrong, [first, end]))
            self._take(read, read.at[wrong[of] - first], place_ns[of])
        self._open = reads[done:]
        self._read = sum(len(each.channel) for each in self._open)

    def _take(self, read, wrong, place_ns):
        """Take the messages of a block whose log times have been decided."""
        channel, log_ns = read.channel, read.log_ns.copy()
        log_ns[wrong] = place_ns
        first, last = int(log_ns.min()), int(log_ns.max())
        block = read.block._replace(first_ns=first, last_ns=last)
        self.blocks.append(block._replace(wrong=wrong, place_ns=place_ns))
        replaced = np.bincount(channel[wrong], minlength=int(channel.max()) + 1)
        for number in np.unique(channel).tolist():
            info = self.topics[self.channels[number].topic]
            of = log_ns[channel == number]
            first, last = int(of.min()), int(of.max())
            info.first_ns = min(info.first_ns, first) if info.count else first
            info.last_ns = max(info.last_ns, last) if info.count else last
            info.count += len(of)
            info.wrong_log_times += int(replaced[number])

    def span(self) -> tuple[int, int] | None:
        """Return the least and the greatest log time [ns]; None: it has no messages."""
        if not self.blocks:
            return None
        first = min(block.first_ns for block in self.blocks)
        return first, max(block.last_ns for block in self.blocks)

    def lost(self, statistics: Statistics) -> str:
        """Return how many messages its statistics count that were not there, or nothing."""
        counts = statistics.channel_message_counts
        short = {number: n - self._counts[number] for number, n in counts.items()}
        total = statistics.message_count
        lost = total - self._counts.total()
        if lost <= 0 or not all(skipped.whole for skipped in self.skipped):
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


def _counted(channel):
    return (each.tolist() for each in np.unique(channel, return_counts=True))
