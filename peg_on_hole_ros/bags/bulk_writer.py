"""Many messages of fixed layouts into an MCAP file at once, by the library's writer."""

from typing import NamedTuple

import numpy as np
from mcap.opcode import Opcode
from mcap.records import MessageIndex
from mcap.writer import Writer

# What stands before a message's payload, from the record's first byte on.
_MESSAGE_HEAD = np.dtype(
    [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log", "<u8"),
        ("publish", "<u8"),
    ]
)
_BEFORE_CHANNEL = 9
_ENTRY = np.dtype([("log", "<u8"), ("offset", "<u8")])


class Column(NamedTuple):
    """
    Messages of one channel, of one length.

    Attributes
    ----------
    channel : int
    payloads : ndarray of uint8, shape (n, length)

    """

    channel: int
    payloads: np.ndarray


class _Index(MessageIndex):
    """A message index that is also given many entries at once, in order with the others."""

    def __init__(self, channel_id):
        super().__init__(channel_id=channel_id, records=[])
        self._parts: list[np.ndarray] = []

    def extend(self, log_ns, offsets):
        self._take_records()
        part = np.empty(len(log_ns), _ENTRY)
        part["log"], part["offset"] = log_ns, offsets
        self._parts.append(part)

    def _take_records(self):
        if self.records:
            self._parts.append(np.array(self.records, _ENTRY))
            self.records.clear()

    def write(self, stream):
        self._take_records()
        entries = b"".join(part.tobytes() for part in self._parts)
        stream.start_record(Opcode.MESSAGE_INDEX)
        stream.write2(self.channel_id)
        stream.write4(len(entries))
        stream.write(entries)
        stream.finish_record()


class BulkWriter(Writer):
    """A `mcap.writer.Writer` that also takes rows of messages; its chunks and indexes are used."""

    def add_rows(self, t_ns: np.ndarray, columns: list[Column]) -> None:
        """
        Add a message of each column for each stamp: all of the first stamp, all of the next.

        Parameters
        ----------
        t_ns : ndarray of int64, shape (n,)
            Log and publish times [ns].
        columns : list of Column

        """
        records = np.hstack([_records(t_ns, column) for column in columns])
        ends = np.cumsum([_MESSAGE_HEAD.itemsize + column.payloads.shape[1] for column in columns])
        offsets = [0, *ends[:-1].tolist()]
        first = 0
        while first < len(t_ns):
            # As with single messages, a chunk ends with the first that reaches its size.
            room = self._Writer__chunk_size - self._Writer__chunk_builder.count
            last = min(first + max(room // records.shape[1], 0) + 1, len(t_ns))
            self._add(t_ns[first:last], records[first:last], columns, offsets)
            first = last

    def _add(self, t_ns, records, columns, offsets):
        chunk, statistics = self._Writer__chunk_builder, self._Writer__statistics
        begin, n = chunk.count, len(t_ns)
        first_ns, last_ns = int(t_ns.min()), int(t_ns.max())
        for told, empty in (
            (chunk, not chunk.num_messages),
            (statistics, not statistics.message_count),
        ):
            told.message_start_time = first_ns if empty else min(told.message_start_time, first_ns)
            told.message_end_time = max(told.message_end_time, last_ns)
        for column, offset in zip(columns, offsets):
            index = chunk.message_indices.get(column.channel)
            if not isinstance(index, _Index):
                fresh = _Index(column.channel)
                fresh.records += index.records if index else []
                index = chunk.message_indices[column.channel] = fresh
            index.extend(t_ns, begin + offset + np.arange(n) * records.shape[1])
            statistics.channel_message_counts[column.channel] += n
        chunk.num_messages += n * len(columns)
        statistics.message_count += n * len(columns)
        chunk.record_writer.write(records.tobytes())
        self._Writer__maybe_finalize_chunk()


def _records(t_ns, column):
    head = np.empty(len(t_ns), _MESSAGE_HEAD)
    head["opcode"] = Opcode.MESSAGE
    head["length"] = _MESSAGE_HEAD.itemsize - _BEFORE_CHANNEL + column.payloads.shape[1]
    head["channel"], head["sequence"] = column.channel, 0
    head["log"] = head["publish"] = t_ns
    return np.hstack([head.view(np.uint8).reshape(len(t_ns), -1), column.payloads])
