"""Which files a bag consists of: one `.mcap` or `.db3` file, or those of a rosbag2 folder."""

import os
import re
from collections.abc import Sequence
from pathlib import Path
from shlex import quote
from typing import NamedTuple

from peg_on_hole_ros.bags.storage.rosbag2_folder import Description, read_description
from peg_on_hole_ros.errors import BagError, PegOnHoleError
from peg_on_hole_ros.safe_text import listed

# As a recorder names the parts of a recording in the folder rec: rec_0.mcap, rec_1.mcap, ...
_PART_NAME = re.compile(r"(.+)_(\d+)\.(mcap|db3)(\.zstd|\.zst)?")
_STORED = (".mcap", ".db3")
_PACKED = (".zstd", ".zst")
# Packed as a whole by what nobody records with, and the command that unpacks it.
_UNREAD_PACKINGS = {".lz4": "lz4 -d", ".gz": "gunzip -k", ".xz": "unxz -k", ".bz2": "bunzip2 -k"}
# A recorder that splits may put messages that came together into either file, and leaves no gap
# but that between two messages [ns].
_APART_NS = 1_000_000_000


class BagFiles(NamedTuple):
    """
    A bag on disk.

    Attributes
    ----------
    path : Path
        As it was given.
    files : tuple of Path
        In their order; each `.mcap` or `.db3`, or one of them packed as a whole.
    description : Path or None
        metadata.yaml of a folder; None: a single file, or a folder without.
    unnamed : tuple of Path
        Files of bags in the folder that metadata.yaml does not name: for ROS 2 no part of it.
    stands_for : dict of str to Path
        By the name in metadata.yaml: a file that somebody unpacked, and that is read for it.

    """

    path: Path
    files: tuple[Path, ...]
    description: Path | None = None
    unnamed: tuple[Path, ...] = ()
    stands_for: dict[str, Path] = {}

    def read(self) -> list[Path]:
        """Return all files that are read, and the folder itself if nothing describes it."""
        if self.description:
            return [*self.files, self.description]
        return [*self.files, *([self.path] if self.path.is_dir() else [])]

    def named_by_recorder(self) -> bool:
        """Return whether the files are called after the folder and counted on from 0."""
        name = os.path.basename(os.path.realpath(self.path))
        expected = [f"{name}_{i}" for i in range(len(self.files))]
        return [file.name.partition(".")[0] for file in self.files] == expected

    def remedy(self) -> str:
        """Return what to do with files that do not belong together, for an error message."""
        return (
            "name one file; or have each replayed by itself: replay with --jobs 1; or, if they "
            f"are one recording, have its metadata.yaml written: ros2 bag reindex -s mcap "
            f"{self.path}"
        )


def bag_files(path: str | Path) -> BagFiles:
    """
    Return what a bag consists of.

    A folder without metadata.yaml (its recorder was killed) is taken as its .mcap files, if they
    are named as the parts of one recording.

    Raises
    ------
    PegOnHoleError
        An empty path, as an unset variable of a shell gives: it would be the current folder.
    BagError
        Nothing there, another storage format, a file that metadata.yaml names is missing, or
        files of several recordings.

    """
    if not str(path):
        raise PegOnHoleError("the path of the bag is empty; name an .mcap file or a bag's folder")
    path = Path(path)
    try:
        return _files(path)
    except OSError as error:
        raise BagError(f"cannot read {path}: {error.strerror}") from None


def _files(path):
    if not path.exists():
        points = f": it is a link to {os.readlink(path)}" if path.is_symlink() else ""
        raise BagError(f"there is no bag {path}{points}")
    if not path.is_dir():
        _check_regular(path)
        if path.suffix in _UNREAD_PACKINGS:
            raise BagError(
                f"{path} is packed as a whole, in a way that is not read; unpack it: "
                f"{_UNREAD_PACKINGS[path.suffix]} {quote(str(path))}"
            )
        return BagFiles(path, (path,))
    description = path / "metadata.yaml"
    if description.is_file():
        return _described(path, description)
    files = bags_in(path)
    if files:
        return _one_recording(BagFiles(path, tuple(files)))
    inner = (file.parent.name for kind in _in_bags() for file in path.glob(f"*/{kind}"))
    bags = sorted(set(inner), key=lambda name: _natural(Path(name)))
    held = f"; the bags in it are {listed(bags)}: name one of them" if bags else ""
    raise BagError(
        f"{path} is a folder without metadata.yaml and without .mcap files: no bag{held}"
    )


def _check_regular(path):
    """Refuse what would be waited for, or has no end: pipes, sockets and devices."""
    if not path.is_file():
        raise BagError(f"{path} is no regular file, so it is not opened")


def in_sqlite(path: Path) -> bool:
    """Return whether a file holds a bag in SQLite, by its name."""
    return bare(path).suffix == ".db3"


def bare(path: Path) -> Path:
    """Return the name of a file without that of its compression."""
    return path.with_suffix("") if path.suffix in _PACKED else path


def bags_in(path: Path) -> list[Path]:
    """Return the files of bags in a folder, each once: unpacked, where it is there both ways."""
    found = {}
    for packed in ("", *_PACKED):
        for kind in _STORED:
            for file in path.glob(f"*{kind}{packed}"):
                if not file.is_dir():
                    found.setdefault(bare(file), file)
    return sorted(found.values(), key=_natural)


def _in_bags():
    return (
        "metadata.yaml",
        *(f"*{kind}{packed}" for kind in _STORED for packed in ("", *_PACKED)),
    )


def _one_recording(found):
    for file in found.files:
        _check_regular(file)
    parts = [_PART_NAME.fullmatch(file.name) for file in found.files]
    if len(parts) > 1 and (not all(parts) or len({part[1] for part in parts}) > 1):  # type: ignore[index]
        raise BagError(
            f"{found.path} is a folder without metadata.yaml, and its files are not named "
            f"as the parts of one recording (NAME_0.mcap, NAME_1.mcap, ...): "
            f"{listed([file.name for file in found.files])}; {found.remedy()}"
        )
    return found


def _described(path, description):
    told = read_description(description)
    files, stands_for = [], {}
    for name in told.names:
        file = _named(path, name, told)
        if told.names.count(name) > 1:
            raise BagError(
                f"{description} names {file.name} {told.names.count(name)} times, and its "
                "messages would be read as often; leave it there once"
            )
        if not file.is_file() and bare(file).is_file():
            stands_for[file.name] = file = bare(file)
        if not file.is_file():
            raise BagError(f"{description} names {file.name}, which is not in {path}")
        if bare(file).suffix not in _STORED:
            raise BagError(
                f"{file} is neither .mcap nor .db3, nor one of them with .zstd: "
                f"{told.storage or 'its storage'} is not read; convert it: ros2 bag convert -i "
                f"{path} with storage_id mcap for the output"
            )
        files.append(file)
    known = {bare(file).name for file in files}
    unnamed = [file for file in bags_in(path) if bare(file).name not in known]
    return BagFiles(path, tuple(files), description, tuple(unnamed), stands_for)


def _named(path: Path, name: str, told: Description) -> Path:
    beside = path.resolve().parent / name
    old = told.with_folder and not (path / name).is_file() and beside.is_file()
    return beside if old else path / name


def _natural(file):
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", file.name)]


def check_one_recording(files: BagFiles, spans: Sequence[tuple[int, int, str]]) -> None:
    """
    Refuse files that no description holds together and that do not follow one another in time.

    A recorder goes on in the next part with the next message. It may have been paused there, so
    a gap is believed where the files are called as it calls them.

    Parameters
    ----------
    files : BagFiles
    spans : sequence of (int, int, str)
        Of each file that has messages: least and greatest log time [ns], and its name.

    """
    if files.description is not None:
        return
    for (begun, end, before), (begin, last, after) in zip(spans, spans[1:]):
        what = ""
        if begin - end > _APART_NS and not files.named_by_recorder():
            what = f"{after} begins {(begin - end) * 1e-9:.3f} s after {before} has ended"
        elif begun >= last:
            what = f"{after} was recorded before {before}"
        elif end - begin > min(_APART_NS, (last - begin) // 2, (end - begun) // 2):
            what = f"{before} and {after} overlap by {(min(end, last) - begin) * 1e-9:.3f} s"
        if what:
            raise BagError(
                f"{files.path} has no metadata.yaml, and {what}, so they are not parts of one "
                f"recording; {files.remedy()}"
            )
