"""The messages of blocks, read again from files that are kept open."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from peg_on_hole_ros.bags.bag_files import in_sqlite
from peg_on_hole_ros.bags.first_pass import Block
from peg_on_hole_ros.bags.message_places import Rows, rows_in
from peg_on_hole_ros.bags.unpacking import chunk_content, open_file
from peg_on_hole_ros.errors import BagError


class Contents:
    """
    The files of a bag that has been read through; use it in a `with` block.

    Parameters
    ----------
    paths : sequence of Path
    most : int
        Bytes that a chunk may take unpacked.

    """

    def __init__(self, paths: Sequence[Path], most: int) -> None:
        self._paths, self._most = paths, most
        self._open: dict[int, Any] = {}

    def __enter__(self) -> "Contents":
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the files."""
        for file in self._open.values():
            file.close()

    def rows(self, block: Block) -> Rows:
        """
        Return the messages of a block.

        Raises
        ------
        BagError
            It cannot be read any more.

        """
        path = self._paths[block.file]
        if in_sqlite(path):
            return self._from_sqlite(block, path)
        if block.file not in self._open:
            self._open[block.file] = open_file(path)
        stream = self._open[block.file]
        try:
            stream.seek(block.start)
            body = stream.read(block.length)
        except OSError as error:
            raise BagError(f"cannot read {stream.name}: {error.strerror}") from None
        try:
            content = chunk_content(body, self._most, validate=False) if block.chunk else body
            return rows_in(content)
        except ValueError as error:
            raise BagError(f"{path} was changed while it was read: {error}") from None

    def _from_sqlite(self, block, path):
        # It takes a while to import, and few need it.
        from peg_on_hole_ros.bags.sqlite import SqliteFile

        if block.file not in self._open:
            self._open[block.file] = SqliteFile(path)
        return self._open[block.file].rows(block.start, block.length)
