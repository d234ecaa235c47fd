"""Messages of several blocks in one order by time, in the memory of those that overlap."""

from collections.abc import Callable, Iterable, Iterator
from heapq import heappop, heappush
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.bags.storage.decoders import Decoder
from peg_on_hole_ros.bags.storage.first_pass import Block
from peg_on_hole_ros.bags.storage.fixed_layouts import NO_LAYOUT, Layouts
from peg_on_hole_ros.bags.storage.message_rows import MessageRows, unpacked


class MessageBatch(NamedTuple):
    """
    Messages, as arrays of one length.

    Attributes
    ----------
    log_ns : ndarray of int64
        When each was recorded; where that is wrong, when it must have been [ns].
    topic, file, channel, layout : ndarray of int
        Place of the topic among those that are read, of the file in the bag, number of the
        channel, place of the layout or -1.
    t_ns : ndarray of int64
        Stamp, where there is a layout [ns].
    values : ndarray, shape (n, m)
    payload : ndarray of object
        Bytes of what has no layout, else None.

    """

    log_ns: np.ndarray
    topic: np.ndarray
    file: np.ndarray
    channel: np.ndarray
    layout: np.ndarray
    t_ns: np.ndarray
    values: np.ndarray
    payload: np.ndarray

    def of(self, places: np.ndarray | slice) -> "MessageBatch":
        """Return some of them."""
        return MessageBatch(*(each[places] for each in self))


def in_order(
    blocks: Iterable[Block], load: Callable[[Block], MessageBatch]
) -> Iterator[MessageBatch]:
    """
    Yield the messages of blocks by time, those of one time in the order of the blocks.

    A message waits until no block still to come can precede it.

    Parameters
    ----------
    blocks : iterable of Block
        In the order of the file.
    load : callable
        Returns the messages of a block, in its own order.

    """
    # By the least time of what is left of a part; no two have one ordinal.
    waiting: list[tuple[int, int, MessageBatch]] = []
    for ordinal, block in sorted(enumerate(blocks), key=lambda each: each[1].first_ns):
        early = []
        while waiting and waiting[0][0] < block.first_ns:
            _, number, part = heappop(waiting)
            count = int(np.searchsorted(part.log_ns, block.first_ns))
            early.append((number, part.of(slice(count))))
            _push(waiting, number, part.of(slice(count, None)))
        if early:
            yield _merged(early)
        _push(waiting, ordinal, _sorted(load(block)))
    if waiting:
        yield _merged([(number, part) for _, number, part in waiting])


def _push(waiting, ordinal, part):
    if len(part.log_ns):
        heappush(waiting, (int(part.log_ns[0]), ordinal, part))


def _merged(numbered):
    parts = [part for _, part in sorted(numbered, key=lambda each: each[0])]
    return parts[0] if len(parts) == 1 else _sorted(joined(*parts))


def _sorted(part):
    if (part.log_ns[1:] >= part.log_ns[:-1]).all():
        return part
    return part.of(np.argsort(part.log_ns, kind="stable"))


def joined(*parts: MessageBatch) -> MessageBatch:
    """Return all messages of parts, one after the other."""
    width = max(part.values.shape[1] for part in parts)
    wide = []
    for part in parts:
        missing = width - part.values.shape[1]
        values = np.pad(part.values, ((0, 0), (0, missing))) if missing else part.values
        wide.append(part._replace(values=values))
    return MessageBatch(*(np.concatenate(each) for each in zip(*wide)))


def part_of(
    file: int, rows: MessageRows, decoders: dict[int, Decoder], layouts: Layouts | None, most: int
) -> MessageBatch:
    """
    Return those messages of a block that have a decoder, as numbers where a layout fits.

    Parameters
    ----------
    file : int
        Place in the bag.
    rows : MessageRows
    decoders : dict of int to Decoder
        By channel.
    layouts : Layouts or None
        None: all messages stay bytes.
    most : int
        Bytes that messages which were packed one by one may take together.

    """
    channels = np.fromiter(decoders, np.int64, len(decoders))
    rows = unpacked(rows.of(np.flatnonzero(np.isin(rows.channel, channels))), most)
    n = len(rows.channel)
    topic, layout = np.zeros(n, np.int64), np.full(n, NO_LAYOUT)
    t_ns, values = np.zeros(n, np.int64), np.zeros((n, 0))
    for channel, decoder in decoders.items():
        at = np.flatnonzero(rows.channel == channel)
        topic[at] = decoder.number
        if layouts is None or not decoder.columns or not len(at):
            continue
        found = layouts.columns(decoder.columns, rows.of(at))
        layout[at], t_ns[at] = found.layout, found.t_ns
        missing = found.values.shape[1] - values.shape[1]
        if missing > 0:
            values = np.pad(values, ((0, 0), (0, missing)))
        values[at, : found.values.shape[1]] = found.values
    payload = np.full(n, None, object)
    left = np.flatnonzero(layout == NO_LAYOUT)
    for i, start, end in zip(left.tolist(), rows.start[left].tolist(), rows.end[left].tolist()):
        payload[i] = rows.data[start:end]
    files = np.full(n, file)
    return MessageBatch(rows.log_ns, topic, files, rows.channel, layout, t_ns, values, payload)
