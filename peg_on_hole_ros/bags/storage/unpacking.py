"""Unpack what recorders compress, within bounds: chunks, messages, whole files."""

import struct
import zlib
from pathlib import Path
from typing import BinaryIO

import lz4.frame
import zstandard

from peg_on_hole_ros.errors import BagError

# What a chunk, or the messages of one, may take unpacked [bytes]; recorders write 0.8 to 10 MB.
MOST_CHUNK = 64 << 20
ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
# Of an empty file.
NOTHING_IN_IT = (
    "its recorder was stopped before it wrote, or its copy ended: copy it again, or name another "
    "bag"
)
# Start, end, size and checksum of the records within; length of the compression's name.
CHUNK_HEAD = struct.Struct("<QQQII")
_U64 = struct.Struct("<Q")
# A file that swells more than a bag does, once it has given more than any chunk may.
_MOST_SWELLING = 1000
_SKIP = 1 << 20
_LONGEST_FRAME_HEAD = 18


class ChecksumError(ValueError):
    """Content that does not fit its checksum."""


class TooLarge(ValueError):
    """Content that takes more than it may."""


def chunk_content(body: bytes, most: int = MOST_CHUNK, validate: bool = True) -> bytes:
    """
    Return the records within a chunk, unpacked.

    Parameters
    ----------
    body : bytes
        Of the chunk's record.
    most : int
        Bytes that the content may state and have.
    validate : bool
        Whether to compare the checksum.

    Raises
    ------
    ChecksumError
        The content is not what was written.
    TooLarge
        The chunk states more than `most`.
    ValueError
        It holds more or less than it states.

    """
    _, _, size, crc, length = CHUNK_HEAD.unpack_from(body)
    at = CHUNK_HEAD.size + length
    compression = bytes(body[CHUNK_HEAD.size : at]).decode()
    packed = memoryview(body)[at + _U64.size :]
    if _U64.unpack_from(body, at)[0] != len(packed):
        raise ValueError(f"a chunk of {len(packed)} bytes states another length")
    check_size(size, most)
    content = _unpacked(packed, compression, size)
    if len(content) != size:
        raise ValueError(f"a chunk holds {len(content)} bytes and states {size}")
    if validate and crc and zlib.crc32(content) != crc:
        raise ChecksumError
    return content


def check_size(size: int, most: int) -> None:
    """Refuse what states or takes more than it may."""
    if size > most:
        raise TooLarge(
            f"what is there takes {size_text(size)}, more than the {size_text(most)} that "
            "--max-chunk allows"
        )


def size_text(size: int) -> str:
    """Return a size in words."""
    return f"{size / 2**20:.6g} MiB"


def _unpacked(packed, compression, size):
    if not compression:
        return bytes(packed)
    if not size:
        return b""
    if compression == "zstd":
        return _zstd(packed, size)
    if compression == "lz4":
        unpacker = lz4.frame.LZ4FrameDecompressor()
        content = unpacker.decompress(packed, max_length=size)
        if not unpacker.eof and (unpacker.decompress(b"", max_length=1) or not unpacker.eof):
            raise ValueError(f"a chunk does not end after the {size} bytes that it states")
        return content
    raise ValueError(f"a chunk is compressed as {compression!r}; zstd, lz4 or none can be read")


def _zstd(packed, most):
    # A frame that states its size is given that much memory, whatever the limit.
    stated = zstandard.frame_content_size(packed)
    if stated > most:
        raise ValueError(f"a zstd frame states {stated} bytes where {most} are stated or allowed")
    return zstandard.ZstdDecompressor().decompress(packed, max_output_size=most)


def message_content(payload: bytes, most: int = MOST_CHUNK) -> bytes:
    """
    Return a message that a recorder packed by itself (`compression_mode: MESSAGE`), unpacked.

    Raises
    ------
    ValueError
        No zstd frame, or one of more than `most` bytes.

    """
    try:
        return _zstd(payload, most)
    except zstandard.ZstdError as error:
        raise ValueError(str(error)) from None


class ZstdFile:
    """
    A file packed as a whole, read as a stream: to go back it is unpacked again from its begin.

    Parameters
    ----------
    path : Path

    Attributes
    ----------
    name : str

    """

    def __init__(self, path: Path) -> None:
        self.name = str(path)
        self._file = path.open("rb")
        self._begin()

    def _begin(self):
        self._file.seek(0)
        unpacker = zstandard.ZstdDecompressor()
        self._stream = unpacker.stream_reader(self._file, closefd=False, read_across_frames=True)
        self._at = 0

    def read(self, size: int) -> bytes:
        """Return up to so many bytes, fewer only at the end; OSError where it is damaged."""
        parts, left = [], size
        while left > 0:
            try:
                part = self._stream.read(min(left, _SKIP))
            except zstandard.ZstdError as error:
                raise OSError(5, f"its compression is damaged: {error}", self.name) from None
            if not part:
                break
            parts.append(part)
            left -= len(part)
            self._at += len(part)
            if self._at > MOST_CHUNK and self._at > _MOST_SWELLING * self._file.tell():
                raise OSError(
                    27, f"it unpacks to more than {_MOST_SWELLING} times its size", self.name
                )
        return b"".join(parts)

    def stated(self) -> int:
        """Return how long its first frame says that it is unpacked [bytes]; 0: it does not."""
        with Path(self.name).open("rb") as file:
            head = file.read(_LONGEST_FRAME_HEAD)
        try:
            return max(zstandard.frame_content_size(head), 0)
        except zstandard.ZstdError:
            return 0

    def seek(self, position: int) -> None:
        """Go to a byte of what is unpacked."""
        if position < self._at:
            self._begin()
        while self._at < position and self.read(min(position - self._at, _SKIP)):
            pass

    def tell(self) -> int:
        """Return how much was unpacked."""
        return self._at

    def share(self) -> float:
        """Return the share of the packed file that was read, 0 to 1."""
        return self._file.tell() / max(Path(self.name).stat().st_size, 1)

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> "ZstdFile":
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file."""
        self.close()


def open_packed(path: Path) -> BinaryIO | ZstdFile:
    """Open for reading, with an error that tells what is there instead."""
    try:
        return ZstdFile(path) if path.suffix in (".zstd", ".zst") else path.open("rb")
    except FileNotFoundError:
        raise BagError(f"there is no bag {path}") from None
    except OSError as error:
        raise BagError(f"cannot read {path}: {error.strerror}") from None
