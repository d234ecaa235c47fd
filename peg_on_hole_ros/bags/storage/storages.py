"""The storages that the files of a bag may have, each read by a module of its own."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Protocol

from peg_on_hole_ros.bags.storage import mcap_file
from peg_on_hole_ros.bags.storage.bag_files import in_sqlite
from peg_on_hole_ros.bags.storage.first_pass import Block, FileContent, TopicInfo
from peg_on_hole_ros.bags.storage.message_rows import MessageRows
from peg_on_hole_ros.errors import BagError


class OpenFile(Protocol):
    """A file that has been read through, kept open."""

    def rows(self, block: Block) -> MessageRows:
        """Return the messages of a block; BagError: it cannot be read any more."""
        ...

    def close(self) -> None:
        """Close the file."""
        ...


class Storage(Protocol):
    """What the module of a storage has."""

    def scan_file(
        self,
        path: Path,
        index: int,
        topics: dict[str, TopicInfo],
        progress: Callable[[float], None] | None,
        most: int,
    ) -> FileContent:
        """
        Read a whole file once, in bounded memory, and add what it holds to `topics`.

        Parameters
        ----------
        path : Path
        index : int
            Of the file within its bag.
        topics : dict of str to TopicInfo
            Filled.
        progress : callable or None
            Called with the share that was read.
        most : int
            Bytes that a chunk, or the messages of a block, may take unpacked.

        Raises
        ------
        BagError
            The file cannot be opened, or is the first of its bag and of another storage.

        """
        ...

    def open_file(self, path: Path, most: int) -> OpenFile:
        """Open a file that has been read through; `most` as above."""
        ...


def storage_of(path: Path) -> Storage:
    """
    Return what reads a file, by its name.

    Raises
    ------
    BagError
        What is needed for it is not installed.

    """
    if not in_sqlite(path):
        return mcap_file
    # It takes a while to import, and few need it.
    try:
        from peg_on_hole_ros.bags.storage import sqlite_file
    except ModuleNotFoundError as error:
        raise BagError(
            f"{path} is a bag in SQLite, which needs {error.name}: pip install rosbags"
        ) from None
    return sqlite_file


class OpenFiles:
    """
    The files of a bag that has been read through, opened as they are needed; for a `with` block.

    Parameters
    ----------
    paths : sequence of Path
    most : int
        Bytes that a chunk may take unpacked.

    """

    def __init__(self, paths: Sequence[Path], most: int) -> None:
        self._paths, self._most = paths, most
        self._open: dict[int, OpenFile] = {}

    def __enter__(self) -> "OpenFiles":
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the files."""
        for file in self._open.values():
            file.close()

    def rows(self, block: Block) -> MessageRows:
        """
        Return the messages of a block.

        Raises
        ------
        BagError
            It cannot be read any more.

        """
        if block.file not in self._open:
            path = self._paths[block.file]
            self._open[block.file] = storage_of(path).open_file(path, self._most)
        return self._open[block.file].rows(block)
