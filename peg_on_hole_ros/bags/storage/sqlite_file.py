"""
Recordings in SQLite as stretches of messages in the order in which they were recorded.

rosbags reads topics and definitions. It gives messages by log time, where a wrong one has lost its
place, and takes 1.6 times as long (0.20 s for 204 795), so those are read here.
"""

import sqlite3
import tempfile
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from shlex import quote
from shutil import copyfile

import numpy as np
from mcap.records import Channel, Schema
from rosbags.interfaces import MessageDefinitionFormat
from rosbags.rosbag2 import Reader
from rosbags.rosbag2.errors import ReaderError

from peg_on_hole_ros.bags.storage.bag_files import bare
from peg_on_hole_ros.bags.storage.first_pass import Block, FileContent, TopicInfo
from peg_on_hole_ros.bags.storage.message_rows import LATEST, MessageRows
from peg_on_hole_ros.bags.storage.unpacking import MOST_CHUNK, NOTHING_IN_IT, ZstdFile
from peg_on_hole_ros.errors import BagError

# Of messages of a stretch [bytes].
_BLOCK_BYTES = 1 << 20
# By log time, as rosbags reads them, one that is wrong would have lost its place.
_SELECT_MESSAGES = (
    "SELECT id, topic_id, timestamp, data FROM messages WHERE id BETWEEN ? AND ? ORDER BY id"
)
_MOST_ID = 2**63 - 1
_DEFINITION_ENCODINGS = {
    MessageDefinitionFormat.MSG: "ros2msg",
    MessageDefinitionFormat.IDL: "ros2idl",
}


class SqliteFile:
    """
    An open file.

    Parameters
    ----------
    path : Path
        `.db3`, or `.db3.zstd`, which is unpacked into a temporary folder first.

    Attributes
    ----------
    count : int
        Number of all messages.

    Raises
    ------
    BagError
        It cannot be read.

    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._empty, self._cut = False, ""
        self._folder: tempfile.TemporaryDirectory | None = None
        with self._errors():
            if path.suffix in (".zstd", ".zst"):
                path = self._unpacked(path)
            self._empty = not path.stat().st_size
            log = path.with_name(path.name + "-wal")
            if log.is_file() and log.stat().st_size:
                path = self._with_log(path, log)
            # It knows the topics of every version.
            reader = Reader(path)
            reader.open()
            self._channels, self.count = list(reader.connections), reader.message_count
            reader.close()
            where = f"{path.absolute().as_uri()}?mode=ro&immutable=1"
            self._messages = sqlite3.connect(where, uri=True)

    def _unpacked(self, path):
        self._folder = tempfile.TemporaryDirectory(prefix="peg_on_hole_")
        target = Path(self._folder.name) / path.stem
        with ZstdFile(path) as packed, target.open("wb") as out:
            while piece := packed.read(_BLOCK_BYTES):
                out.write(piece)
            if packed.tell() < packed.stated():
                self._cut = (
                    f"it is cut off, {packed.tell()} of {packed.stated()} bytes can be unpacked; "
                )
        return target

    def _with_log(self, path, log):
        """Copy a file with what a recorder that was killed had not yet put into it."""
        self._folder = tempfile.TemporaryDirectory(prefix="peg_on_hole_")
        target = Path(self._folder.name) / path.name
        for source in (path, log):
            copyfile(source, target.with_name(source.name))
        with closing(sqlite3.connect(target)) as database:
            database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        return target

    @contextmanager
    def _errors(self):
        """Name the file where SQLite refuses it, in whatever way."""
        try:
            yield
        except (BagError, KeyboardInterrupt, GeneratorExit):
            raise
        except OSError as error:
            raise BagError(f"cannot read {self.path}: {error.strerror or error}") from None
        except ReaderError as error:
            raise BagError(f"{self.path} is no bag in SQLite: {self._told(error)}") from None
        except Exception as error:
            raise BagError(f"cannot read {self.path}: {self._told(error)}") from None

    def _told(self, error):
        """Return an error, of the file that was given and not of its copy, and a remedy."""
        if self._empty:
            return f"{self._cut or 'it is empty (0 bytes); '}{NOTHING_IN_IT}"
        text = str(error)
        if self._folder:
            copy = Path(self._folder.name) / self.path.stem
            text = text.replace(str(copy), str(self.path)).replace(str(copy.parent), "its copy")
        name = quote(str(self.path))
        unpacked = f"zstd -d {name}, then " if self._folder else ""
        return (
            f"{self._cut}{text.rstrip('.')}; copy it again, or if it was cut off take out what is "
            f"whole: {unpacked}sqlite3 {quote(str(bare(self.path)))} .recover | sqlite3 whole.db3"
        )

    def declare(self, found: FileContent) -> None:
        """Tell of topics, types and definitions."""
        for each in self._channels:
            encoding = _DEFINITION_ENCODINGS.get(each.msgdef.format, "")
            data = each.msgdef.data.encode() if encoding else b""
            found.schemas[each.id] = Schema(
                id=each.id, name=each.msgtype, encoding=encoding, data=data
            )
            kind = each.ext.serialization_format  # type: ignore[union-attr]
            found.add_channel(
                Channel(
                    id=each.id,
                    topic=each.topic,
                    message_encoding=kind,
                    metadata={},
                    schema_id=each.id,
                )
            )

    def stretches(self) -> Iterator[tuple[int, int, MessageRows]]:
        """Yield ids of first and last message, and the messages, of each stretch."""
        collected, first = _Collected(), None
        with self._errors():
            for number, *message in self._messages.execute(
                _SELECT_MESSAGES, (-_MOST_ID, _MOST_ID)
            ):
                first = number if first is None else first
                collected.add(*message)
                if collected.size >= _BLOCK_BYTES:
                    yield first, number, collected.rows()
                    collected, first = _Collected(), None
        if first is not None:
            yield first, number, collected.rows()

    def rows(self, block: Block) -> MessageRows:
        """Return the messages of a stretch."""
        collected = _Collected()
        with self._errors():
            for _, *message in self._messages.execute(
                _SELECT_MESSAGES, (block.start, block.length)
            ):
                collected.add(*message)
        return collected.rows()

    def close(self) -> None:
        """Close the file."""
        self._messages.close()
        if self._folder:
            self._folder.cleanup()


class _Collected:
    """Messages one by one, to be arrays."""

    def __init__(self):
        self.size = 0
        self._times: list[int] = []
        self._parts: list[bytes] = []
        self._channels: list[int] = []

    def add(self, channel, log_ns, data):
        self._times.append(log_ns)
        self._channels.append(channel)
        self._parts.append(data)
        self.size += len(data)

    def rows(self):
        length = np.array([len(part) for part in self._parts], np.int64)
        end = np.cumsum(length)
        log_ns = np.clip(np.array(self._times, np.int64), 0, LATEST)
        channel = np.array(self._channels, np.int64)
        return MessageRows(b"".join(self._parts), channel, log_ns, end - length, end)


def scan_file(
    path: Path,
    index: int,
    topics: dict[str, TopicInfo],
    progress: Callable[[float], None] | None = None,
    most: int = MOST_CHUNK,
) -> FileContent:
    """Read a whole file once, as `storages.Storage` states it."""
    found = FileContent(path, topics)
    file = SqliteFile(path)
    try:
        file.declare(found)
        count = 0
        for first, last, rows in file.stretches():
            found.add(rows, Block(index, first, last, False), most)
            count += len(rows.log_ns)
            if progress:
                progress(count / file.count)
    except (BagError, ValueError) as error:
        found.damage = f"damaged: {error}"
    finally:
        found.finish()
        file.close()
    return found


def open_file(path: Path, most: int) -> SqliteFile:
    """Open a file that has been read through."""
    return SqliteFile(path)
