"""
Walk the records of an MCAP file once, check every CRC, and note where messages lie.

A cut-off or damaged file gives what lies before the damage: whole chunks, or single messages
where the recorder wrote none. The library's seeking reader gives nothing at all of such a file.
Its StreamReader reads every entry of every index, so that its walk alone takes as long as all of
reading does here (0.08 s for 90 000 messages), and has no bound on what a chunk unpacks to. So
records are stepped over here, and read by `mcap.records`.
"""

import struct
import zlib
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from io import BytesIO
from pathlib import Path

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, DataEnd, Metadata, Schema, Statistics

from peg_on_hole_ros.bags.storage.first_pass import Block, FileContent, TopicInfo
from peg_on_hole_ros.bags.storage.message_rows import HEAD, MessageRows, rows_in
from peg_on_hole_ros.bags.storage.oversized import CHANNEL, Passing, Skipped, passed_chunk
from peg_on_hole_ros.bags.storage.unpacking import (
    MOST_CHUNK,
    NOTHING_IN_IT,
    ChecksumError,
    TooLarge,
    ZstdFile,
    check_size,
    chunk_content,
    open_packed,
)
from peg_on_hole_ros.errors import BagError

MAGIC = b"\x89MCAP0\r\n"
# Start of the index, start of its own index, checksum.
_FOOTER = struct.Struct("<QQI")
# What a message begins with.
_CHANNEL = struct.Struct("<H20x")
# Kind of a record that has been passed over, one that no program writes.
_PASSED = 0xFF
# Messages outside chunks are grouped, so that ordering by time holds little in memory.
_GROUP_BYTES = 1 << 20
# Those of which the content is used; a chunk's head takes little more than itself.
_USED = (
    Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE, Opcode.CHUNK, Opcode.METADATA,
    Opcode.DATA_END, Opcode.STATISTICS, Opcode.FOOTER,
)  # fmt: skip
_MOST_HEAD = 1 << 10


class _Damage(Exception):
    """Where and how a file stops being readable."""


def scan_file(
    path: Path,
    index: int,
    topics: dict[str, TopicInfo],
    progress: Callable[[float], None] | None = None,
    most: int = MOST_CHUNK,
) -> FileContent:
    """Read a whole file once, as `storages.Storage` states it."""
    found = FileContent(path, topics)
    with open_packed(path) as stream:
        # Of what is packed as a whole nobody knows how long it is.
        size = None if isinstance(stream, ZstdFile) else path.stat().st_size
        try:
            magic = stream.read(len(MAGIC))
            if magic == MAGIC:
                _FileWalk(stream, size, found, index, progress, most).all()
                return found
            found.damage = _no_begin(magic)
        except _Damage as damage:
            found.damage = str(damage)
            return found
        except OSError as error:  # of the disk
            found.damage = f"unreadable after byte {stream.tell()}: {error.strerror}"
            return found
        finally:
            found.finish()
    if not index:
        remedy = "" if magic else f"; {NOTHING_IN_IT}"
        raise BagError(f"{path} is {found.damage}{remedy}")
    # Of a recording in parts the last one may have been opened and never written.
    return found


class McapFile:
    """
    A file that has been read through, kept open.

    Parameters
    ----------
    path : Path
    most : int
        Bytes that a chunk may take unpacked.

    """

    def __init__(self, path: Path, most: int) -> None:
        self._path, self._most, self._stream = path, most, open_packed(path)

    def rows(self, block: Block) -> MessageRows:
        """Return the messages of a block."""
        try:
            self._stream.seek(block.start)
            body = self._stream.read(block.length)
        except OSError as error:
            raise BagError(f"cannot read {self._stream.name}: {error.strerror}") from None
        try:
            content = chunk_content(body, self._most, validate=False) if block.chunk else body
            return rows_in(content)
        except ValueError as error:
            raise BagError(f"{self._path} was changed while it was read: {error}") from None

    def close(self) -> None:
        """Close the file."""
        self._stream.close()


def open_file(path: Path, most: int) -> McapFile:
    """Open a file that has been read through."""
    return McapFile(path, most)


def _no_begin(magic):
    """Return what a file is that does not begin as one of MCAP, by its first bytes."""
    if not magic:
        return "empty (0 bytes)"
    if MAGIC.startswith(magic):
        return f"cut off at byte {len(magic)}"
    return f"not an MCAP file: it begins with {magic!r}"


class _FileWalk:
    """From the first record of a file to its end, or to where it is damaged."""

    def __init__(self, stream, size, found, index, progress, most):
        self._stream, self._size, self._found, self._index = stream, size, found, index
        self._progress, self._most = progress or (lambda share: None), most
        # Messages outside chunks, and where they begin.
        self._run, self._run_at = bytearray(), 0

    def all(self):
        """Walk."""
        crc = zlib.crc32(MAGIC)
        try:
            while True:
                offset = self._stream.tell()
                record = self._record(crc)
                if record is None:
                    raise _Damage(self._cut(offset))
                opcode, head, body, crc_before, crc = record
                if not opcode:
                    raise _Damage(f"damaged at byte {offset}: a record of kind 0, of zeros alone")
                try:
                    if opcode == Opcode.FOOTER:
                        self._end_run()
                        if self._stream.read(len(MAGIC)) != MAGIC:
                            raise _Damage(self._cut(offset))
                        return
                    if opcode == Opcode.DATA_END:
                        self._end_run()
                        self._end_of_data(body, crc_before)
                        return
                    self._take(offset, opcode, head, body)
                except _Damage:
                    raise
                except ChecksumError:
                    raise _Damage(
                        f"damaged: the chunk at byte {offset} does not fit its checksum"
                    ) from None
                except Exception as error:
                    # Rubbish makes parsers and decompressors raise whatever their authors
                    # thought of.
                    raise _Damage(f"damaged at byte {offset}: {error}") from None
        except (_Damage, OSError):
            with suppress(ValueError):
                self._end_run()
            raise

    def _record(self, crc):
        """
        Return the next record, and the checksum before and behind it; None: it is not whole.

        That of a kind that is not used has no content, and may have any length.
        """
        head = self._stream.read(HEAD.size)
        if len(head) < HEAD.size:
            return None
        opcode, length = HEAD.unpack(head)
        if self._size is not None and length > self._size - self._stream.tell():
            return None
        before, crc = crc, zlib.crc32(head, crc)
        content = Passing(self._stream, length, crc)
        if opcode in _USED and length <= self._most + _MOST_HEAD:
            body = self._stream.read(length)
            whole = len(body) == length
            return (opcode, head, body, before, zlib.crc32(body, crc)) if whole else None
        if opcode in _USED:
            at = self._stream.tell() - HEAD.size
            try:
                self._pass(opcode, content)
            except (ValueError, struct.error) as error:
                raise _Damage(f"damaged at byte {at}: {error}") from None
            opcode = _PASSED
        return (opcode, head, b"", before, content.crc) if content.to_the_end() else None

    def _pass(self, opcode, content):
        """Take note of a record that is larger than it may be."""
        if opcode == Opcode.CHUNK:
            skipped = passed_chunk(content, self._declared, self._most)
        elif opcode == Opcode.MESSAGE:
            size, (channel,) = content.left, CHANNEL.unpack(content.read(CHANNEL.size))
            self._found.check([channel])
            skipped = Skipped(False, size, Counter({channel: 1}), True)
        else:
            check_size(content.left, self._most)
        self._end_run()
        self._found.skip(skipped)

    def _take(self, offset, opcode, head, body):
        if opcode in (Opcode.MESSAGE, Opcode.SCHEMA, Opcode.CHANNEL):
            if self._run and opcode == Opcode.MESSAGE and len(self._run) >= _GROUP_BYTES:
                self._end_run()
            if opcode == Opcode.MESSAGE:
                self._found.check(_CHANNEL.unpack_from(body))
            else:
                # Known at once, for the messages behind it.
                self._declared(body, opcode, 0, len(body))
            if opcode == Opcode.MESSAGE or self._run:
                self._run_at = self._run_at if self._run else offset
                self._run += head + body
            return
        self._end_run()
        if opcode == Opcode.CHUNK:
            try:
                content = chunk_content(body, self._most)
            except TooLarge:
                self._found.skip(passed_chunk(BytesIO(body), self._declared, self._most))
                return
            rows = rows_in(content, lambda *where: self._declared(content, *where))
            block = Block(self._index, offset + HEAD.size, len(body), True)
            self._found.add(rows, block, self._most)
            self._progress(self._share())
        elif opcode == Opcode.METADATA:
            metadata = Metadata.read(_stream_of(body))
            self._found.metadata[metadata.name] = dict(metadata.metadata)

    def _share(self):
        if self._size is None:
            return self._stream.share()
        return self._stream.tell() / self._size

    def _declared(self, data, opcode, start, end):
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(_stream_of(data[start:end]))
            self._found.schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            self._found.add_channel(Channel.read(_stream_of(data[start:end])))

    def _end_run(self):
        """Note the messages outside chunks since the last other record as a block."""
        if self._run:
            data, self._run = bytes(self._run), bytearray()
            block = Block(self._index, self._run_at, len(data), False)
            self._found.add(rows_in(data), block, self._most)

    def _end_of_data(self, body, crc):
        stated = DataEnd.read(_stream_of(body)).data_section_crc
        if stated and stated != crc:
            raise _Damage("damaged: the data section does not fit its checksum")
        statistics = self._check_index()
        lost = self._found.lost(statistics) if statistics else ""
        if lost:
            raise _Damage(f"damaged: {lost}")

    def _check_index(self):
        """Read what follows the data: its definitions are but copies; return its statistics."""
        crc, statistics = 0, None
        while True:
            offset = self._stream.tell()
            record = self._record(crc)
            if record is None:
                raise _Damage(self._index_lost())
            opcode, head, body, _, behind = record
            if opcode in (Opcode.CHUNK, Opcode.MESSAGE):
                raise _Damage(f"damaged at byte {offset}: messages where the index has to be")
            if opcode == Opcode.FOOTER:
                break
            if not opcode:
                raise _Damage(self._index_lost())
            if opcode == Opcode.STATISTICS:
                statistics = body
            crc = behind
        whole = self._stream.read(len(MAGIC)) == MAGIC and len(body) >= _FOOTER.size
        start, _, stated = _FOOTER.unpack_from(body) if whole else (0, 0, 0)
        # All of the footer before its checksum is a part of it; 0: none was taken.
        crc = zlib.crc32(body[: _FOOTER.size - 4], zlib.crc32(head, crc))
        if not whole or start and stated not in (0, crc):
            raise _Damage(self._index_lost())
        return _statistics(statistics)

    def _index_lost(self):
        """Return what is wrong behind the data, all of which could be read."""
        if self._size is None:
            return "damaged or cut off within the index at its end: no message of it is lost"
        self._stream.seek(self._size - len(MAGIC))
        whole = self._stream.read(len(MAGIC)) == MAGIC
        what = "damaged" if whole else f"cut off at byte {self._size},"
        return f"{what} within the index at its end: no message of it is lost"

    def _cut(self, offset):
        """Return what is lost of a file that ends in the record that begins at offset."""
        why = "its recorder was stopped, or it was not copied whole"
        size = self._stream.tell() if self._size is None else self._size
        if size == offset:
            return f"cut off at byte {size}, behind a whole record: {why}"
        return f"cut off at byte {size}: {why}, and its last {size - offset} bytes cannot be read"


def _statistics(body):
    """Return what the index says of its file, or None where it does not agree with itself."""
    if body is None:
        return None
    try:
        found = Statistics.read(_stream_of(body))
    except Exception:  # rubbish, in an index without a checksum
        return None
    agrees = found.message_count == sum(found.channel_message_counts.values())
    return found if agrees else None


def _stream_of(body):
    return ReadDataStream(BytesIO(body))
