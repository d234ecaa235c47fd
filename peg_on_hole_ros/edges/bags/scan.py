"""
Walk the records of an MCAP file once, check every CRC, and note where messages lie.

A cut-off or damaged file gives what lies before the damage: whole chunks, or single messages
where the recorder wrote none. The library's seeking reader gives nothing at all of such a file.
"""

import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, DataEnd, Metadata, Schema
from mcap.stream_reader import CRCValidationError, get_chunk_data_stream

from peg_on_hole_ros.errors import BagError

MAGIC = b"\x89MCAP0\r\n"
_HEAD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")
# Start of the index, start of its own index, checksum.
_FOOTER = struct.Struct("<QQI")
# Messages outside chunks are grouped, so that ordering by time holds little in memory.
_GROUP_BYTES = 1 << 20


class Block(NamedTuple):
    """
    A chunk, or a run of messages outside chunks.

    Attributes
    ----------
    first_ns, last_ns : int
        Least and greatest log time in it.
    file, start, length : int
        Index of the file; where the chunk's content, or the run of records, lies in it.
    chunk : bool

    """

    first_ns: int
    last_ns: int
    file: int
    start: int
    length: int
    chunk: bool


@dataclass
class TopicInfo:
    """What a scan learnt about one topic; `types` has more than one entry only in an odd bag."""

    name: str
    types: list[str] = field(default_factory=list)
    encodings: list[str] = field(default_factory=list)
    count: int = 0
    first_ns: int = 0
    last_ns: int = 0


@dataclass
class Scan:
    """Content of one file as far as it could be read; `damage` says why it ended early."""

    path: Path
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    blocks: list[Block] = field(default_factory=list)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    damage: str = ""


class _Damage(Exception):
    """Where and how a file stops being readable."""


def scan_file(
    path: Path,
    index: int,
    topics: dict[str, TopicInfo],
    progress: Callable[[float], None] | None = None,
) -> Scan:
    """
    Read a whole file once, in bounded memory, and add what it holds to `topics`.

    Parameters
    ----------
    path : Path
    index : int
        Of the file within its bag.
    topics : dict of str to TopicInfo
        Filled.
    progress : callable, optional
        Called with the share that was read.

    Raises
    ------
    BagError
        The file cannot be opened, or is the first of its bag and no MCAP file.

    """
    scan = Scan(path)
    with open_file(path) as stream:
        size = path.stat().st_size
        magic = stream.read(len(MAGIC))
        if magic != MAGIC:
            scan.damage = _no_begin(magic)
            if not index:
                raise BagError(f"{path} is {scan.damage}")
            # Of a recording in parts the last one may have been opened and never written.
            return scan
        try:
            _walk_file(stream, size, scan, index, topics, progress)
        except _Damage as damage:
            scan.damage = str(damage)
        except OSError as error:  # of the disk
            scan.damage = f"unreadable after byte {stream.tell()}: {error.strerror}"
    return scan


def _no_begin(magic):
    """Return what a file is that does not begin as one of MCAP, by its first bytes."""
    if not magic:
        return "empty (0 bytes)"
    if MAGIC.startswith(magic):
        return f"cut off at byte {len(magic)}"
    return f"not an MCAP file: it begins with {magic!r}"


def open_file(path: Path) -> BinaryIO:
    """Open for reading, with an error that tells what is there instead."""
    try:
        return path.open("rb")
    except FileNotFoundError:
        raise BagError(f"there is no bag {path}") from None
    except OSError as error:
        raise BagError(f"cannot read {path}: {error.strerror}") from None


def _walk_file(stream, size, scan, index, topics, progress):
    crc = zlib.crc32(MAGIC)
    run = None
    while True:
        offset = stream.tell()
        record = _record(stream, size)
        if record is None:
            raise _Damage(_cut(size, offset))
        opcode, head, body = record
        try:
            if opcode == Opcode.FOOTER:
                if stream.read() != MAGIC:
                    raise _Damage(_cut(size, offset))
                return
            if opcode == Opcode.DATA_END:
                stated = DataEnd.read(_stream_of(body)).data_section_crc
                if stated and stated != crc:
                    raise _Damage("damaged: the data section does not fit its checksum")
                _check_index(stream, size)
                return
            crc = zlib.crc32(body, zlib.crc32(head, crc))
            if opcode == Opcode.CHUNK:
                start = offset + _HEAD.size
                times = _scan_records(chunk_content(body, True), scan, topics)
                if times:
                    scan.blocks.append(Block(*times, index, start, len(body), True))
                if progress:
                    progress(stream.tell() / size)
            elif opcode == Opcode.METADATA:
                found = Metadata.read(_stream_of(body))
                scan.metadata[found.name] = dict(found.metadata)
            else:
                times = _scan_records(head + body, scan, topics)
                if times:
                    length = len(head) + len(body)
                    run = _extend_run(scan.blocks, run, times, index, offset, length)
        except _Damage:
            raise
        except CRCValidationError:
            raise _Damage(
                f"damaged: the chunk at byte {offset} does not fit its checksum"
            ) from None
        except Exception as error:
            # Rubbish makes parsers and decompressors raise whatever their authors thought of.
            raise _Damage(f"damaged at byte {offset}: {error}") from None


def _record(stream, size):
    """Return opcode, head and content of the next record, or None where it is not whole."""
    head = stream.read(_HEAD.size)
    if len(head) < _HEAD.size:
        return None
    opcode, length = _HEAD.unpack(head)
    return None if length > size - stream.tell() else (opcode, head, stream.read(length))


def _check_index(stream, size):
    """Read what follows the data and take nothing of it: its definitions are but copies."""
    crc = 0
    while True:
        offset = stream.tell()
        record = _record(stream, size)
        if record is None:
            raise _Damage(_index_lost(stream, size))
        opcode, head, body = record
        if opcode in (Opcode.CHUNK, Opcode.MESSAGE):
            raise _Damage(f"damaged at byte {offset}: messages where the index has to be")
        if opcode == Opcode.FOOTER:
            break
        crc = zlib.crc32(body, zlib.crc32(head, crc))
    whole = stream.read() == MAGIC and len(body) >= _FOOTER.size
    start, _, stated = _FOOTER.unpack_from(body) if whole else (0, 0, 0)
    # All of the footer before its checksum is a part of it; 0: none was taken.
    crc = zlib.crc32(body[: _FOOTER.size - 4], zlib.crc32(head, crc))
    if not whole or start and stated not in (0, crc):
        raise _Damage(_index_lost(stream, size))


def _index_lost(stream, size):
    """Return what is wrong behind the data of a file of a size, all of which could be read."""
    stream.seek(size - len(MAGIC))
    what = "damaged" if stream.read() == MAGIC else f"cut off at byte {size},"
    return f"{what} within the index at its end: no message of it is lost"


def _cut(size, offset):
    """Return what is lost of a file of a size that ends in the record that begins at offset."""
    why = "its recorder was stopped, or it was not copied whole"
    if size == offset:
        return f"cut off at byte {size}, behind a whole record: {why}"
    return f"cut off at byte {size}: {why}, and its last {size - offset} bytes cannot be read"


def _extend_run(blocks, run, times, index, offset, length):
    """Add one message outside chunks to the run before it, or begin another; return the run."""
    adjoins = run is not None and blocks[-1] is run and run.start + run.length == offset
    if adjoins and run.length < _GROUP_BYTES:
        first, last = min(run.first_ns, times[0]), max(run.last_ns, times[1])
        blocks[-1] = Block(first, last, index, run.start, run.length + length, False)
        return blocks[-1]
    blocks.append(Block(*times, index, offset, length, False))
    return blocks[-1]


def _scan_records(data, scan, topics):
    first = last = None
    for opcode, start, end in walk(data):
        if opcode == Opcode.MESSAGE:
            channel_id, _, log_ns, _ = _MESSAGE.unpack_from(data, start)
            if channel_id not in scan.channels:
                raise ValueError(f"a message of channel {channel_id}, which is not declared")
            info = topics[scan.channels[channel_id].topic]
            if not info.count or log_ns < info.first_ns:
                info.first_ns = log_ns
            if not info.count or log_ns > info.last_ns:
                info.last_ns = log_ns
            info.count += 1
            first = log_ns if first is None else min(first, log_ns)
            last = log_ns if last is None else max(last, log_ns)
        elif opcode == Opcode.SCHEMA:
            schema = Schema.read(_stream_of(data[start:end]))
            scan.schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            _add_channel(Channel.read(_stream_of(data[start:end])), scan, topics)
    return None if first is None else (first, last)


def _add_channel(channel, scan, topics):
    scan.channels[channel.id] = channel
    info = topics.setdefault(channel.topic, TopicInfo(channel.topic))
    schema = scan.schemas.get(channel.schema_id)
    name = schema.name if schema else ""
    if name not in info.types:
        info.types.append(name)
    encoding = f"{channel.message_encoding}, {schema.encoding if schema else 'no schema'}"
    if encoding not in info.encodings:
        info.encodings.append(encoding)


def walk(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, start and end of the content of each record."""
    position, size = 0, len(data)
    while position < size:
        opcode, length = _HEAD.unpack_from(data, position)
        position += _HEAD.size
        if length > size - position:
            raise ValueError(f"a record of {length} bytes is longer than what holds it")
        yield opcode, position, position + length
        position += length


def messages_of(data: bytes) -> Iterator[tuple[int, int, bytes]]:
    """Yield channel id, log time [ns] and payload of each message."""
    for opcode, start, end in walk(data):
        if opcode == Opcode.MESSAGE:
            channel_id, _, log_ns, _ = _MESSAGE.unpack_from(data, start)
            yield channel_id, log_ns, data[start + _MESSAGE.size : end]


def chunk_content(body: bytes, validate: bool) -> bytes:
    """Return the records within a chunk, decompressed."""
    stream, length = get_chunk_data_stream(Chunk.read(_stream_of(body)), validate_crc=validate)
    return stream.read(length)


def _stream_of(body):
    return ReadDataStream(BytesIO(body))
