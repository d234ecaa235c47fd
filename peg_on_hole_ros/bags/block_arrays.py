"""From the messages of a block to arrays that can be put in order."""

import numpy as np

from peg_on_hole_ros.bags.columns import NO_LAYOUT, Layouts
from peg_on_hole_ros.bags.decoding import Decoder
from peg_on_hole_ros.bags.message_places import Rows, unpacked
from peg_on_hole_ros.bags.time_order import Part


def part_of(
    file: int, rows: Rows, decoders: dict[int, Decoder], layouts: Layouts | None, most: int
) -> Part:
    """
    Return those messages of a block that have a decoder, as numbers where a layout fits.

    Parameters
    ----------
    file : int
        Place in the bag.
    rows : Rows
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
    return Part(rows.log_ns, topic, files, rows.channel, layout, t_ns, values, payload)
