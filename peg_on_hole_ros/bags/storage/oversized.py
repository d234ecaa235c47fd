"""Chunks and messages that take more than they may: what they hold is counted, not kept."""

import struct
import zlib
from collections import Counter
from collections.abc import Callable, Iterable
from contextlib import suppress
from io import BytesIO
from typing import Any, BinaryIO, NamedTuple

import lz4.frame
import zstandard
from mcap.opcode import Opcode

from peg_on_hole_ros.bags.storage.unpacking import CHUNK_HEAD, ZstdFile, size_text
from peg_on_hole_ros.safe_text import listed

HEAD = struct.Struct("<BQ")
CHANNEL = struct.Struct("<H")
# Read at a time, and of a definition at most [bytes].
_PIECE = 1 << 20
# What a chunk may state: as much as --max-chunk may be [bytes].
_MOST_STATED = 1 << 32
# Unpacked of a chunk at most, so many times what a chunk may take: a bomb has no end.
_MOST_WALKED = 16


class Skipped(NamedTuple):
    """
    Something that was passed over.

    Attributes
    ----------
    of_chunk : bool
        Whether it is a chunk, and no single message.
    size : int
        What it takes [bytes].
    channels : Counter
        Messages in it by channel.
    whole : bool
        Whether all of it could be counted.

    """

    of_chunk: bool
    size: int
    channels: Counter[int]
    whole: bool


class Passing:
    """
    The content of a record that is read once and not kept.

    Parameters
    ----------
    stream : BinaryIO or ZstdFile
        At its begin.
    length : int
        Of the content [bytes].
    crc : int
        Checksum of all before it.

    Attributes
    ----------
    crc : int
        Of all that has been read.
    left : int
        What has not [bytes].

    """

    def __init__(self, stream: BinaryIO | ZstdFile, length: int, crc: int) -> None:
        self._stream, self.left, self.crc = stream, length, crc

    def read(self, size: int = -1) -> bytes:
        """Return up to so many bytes, no more than a piece."""
        size = min(self.left, _PIECE) if size < 0 else min(size, self.left, _PIECE)
        part = self._stream.read(size) if size else b""
        self.crc, self.left = zlib.crc32(part, self.crc), self.left - len(part)
        return part

    def to_the_end(self) -> bool:
        """Read what is left; return whether all was there."""
        while self.left and self.read():
            pass
        return not self.left


def passed_chunk(
    packed: Passing | BytesIO, declared: Callable[[bytes, int, int, int], None], most: int
) -> Skipped:
    """
    Return what a chunk holds, and hand on what it declares.

    Parameters
    ----------
    packed : Passing or BytesIO
        Its content.
    declared : callable
        Takes the content of a schema or channel, its opcode, and where it begins and ends in it.
    most : int
        Bytes that a chunk may take unpacked.

    Raises
    ------
    ValueError
        It states a size that no chunk has, as where it is damaged.

    """
    _, _, size, _, length = CHUNK_HEAD.unpack(packed.read(CHUNK_HEAD.size))
    if size > _MOST_STATED:
        raise ValueError(f"a chunk states that it takes {size} bytes")
    compression = packed.read(length).decode(errors="replace")
    packed.read(8)
    counts: Counter[int] = Counter()
    whole = False
    # Rubbish makes decompressors raise whatever their authors thought of. It is passed over as
    # well, and what of it was counted is told.
    with suppress(Exception):
        whole = _walk(_opened(packed, compression), declared, counts, _MOST_WALKED * most)
    return Skipped(True, size, counts, whole)


def _opened(packed: Any, compression: str) -> Any:
    if compression == "zstd":
        unpacker = zstandard.ZstdDecompressor()
        return unpacker.stream_reader(packed, read_across_frames=True, closefd=False)
    return lz4.frame.LZ4FrameFile(packed) if compression == "lz4" else packed


def _walk(stream, declared, counts, most):
    """Count messages by channel; return whether it was walked to its end."""
    walked = 0
    while head := _read(stream, HEAD.size):
        opcode, length = HEAD.unpack(head)
        walked += HEAD.size + length
        if not opcode or walked > most:
            return False
        used = opcode in (Opcode.SCHEMA, Opcode.CHANNEL)
        body = _read(stream, min(length, _PIECE if used else CHANNEL.size))
        if used and len(body) == length:
            declared(body, opcode, 0, length)
        elif opcode == Opcode.MESSAGE:
            counts[CHANNEL.unpack(body)[0]] += 1
        left = length - len(body)
        while left and (piece := stream.read(min(left, _PIECE))):
            left -= len(piece)
        if left:
            return False
    return True


def _read(stream, size):
    parts, left = [], size
    while left and (part := stream.read(left)):
        parts.append(part)
        left -= len(part)
    return b"".join(parts)


def skipped_lines(skipped: Iterable[tuple[Skipped, dict[int, str]]], most: int) -> list[str]:
    """
    Return what was passed over, and what would read it.

    Parameters
    ----------
    skipped : iterable of (Skipped, dict of int to str)
        With the topics by the number of their channel.
    most : int
        Bytes that each may take.

    """
    chunks = [each for each in skipped if each[0].of_chunk]
    messages = [each for each in skipped if not each[0].of_chunk]
    allowed = f"more than the {size_text(most)} that --max-chunk allows"
    lines = []
    if messages:
        names = {topics[channel] for each, topics in messages for channel in each.channels}
        on = f"on {listed(names)}" if len(names) == 1 else f"({_held(messages)})"
        lines.append(f"skipped: {_largest('record', messages)} {on}, {allowed}; the rest is read")
    if chunks:
        held = _held(chunks) or "none that could be counted"
        more = "" if all(each.whole for each, _ in chunks) else " and more"
        enough = -(-max(each.size for each, _ in chunks) // 2**20) + 1
        lines.append(
            f"skipped: {_largest('chunk', chunks)} unpacked, {allowed}, with the messages in it "
            f"({held}{more}); the rest is read, and with --max-chunk {enough} all"
        )
    return lines


def _largest(what, skipped):
    size = size_text(max(each.size for each, _ in skipped))
    return (
        f"a {what} of {size}" if len(skipped) == 1 else f"{len(skipped)} {what}s of up to {size}"
    )


def _held(skipped):
    by_topic: Counter[str] = Counter()
    for each, topics in skipped:
        for channel, count in each.channels.items():
            by_topic[topics.get(channel, f"channel {channel}")] += count
    return listed(f"{topic} {count}" for topic, count in sorted(by_topic.items()))
