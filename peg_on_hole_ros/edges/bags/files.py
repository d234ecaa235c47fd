"""Which files a bag consists of: one `.mcap` file, or those of a rosbag2 folder."""

import re
from pathlib import Path
from typing import NamedTuple

import yaml

from peg_on_hole_ros.errors import BagError, PegOnHoleError

# As a recorder names the parts of a recording in the folder rec: rec_0.mcap, rec_1.mcap, ...
_PART = re.compile(r"(.+)_(\d+)\.mcap")
_MOST_LISTED = 10
_OF_BAGS = ("metadata.yaml", "*.mcap")
_WHOLE = (".zstd", ".zst", ".lz4", ".gz", ".xz")
# Up to the version before, the recorder put the folder's own name before each file's.
_WITHOUT_FOLDER = 4


class BagFiles(NamedTuple):
    """
    A bag on disk.

    Attributes
    ----------
    path : Path
        As it was given.
    files : tuple of Path
        MCAP files in their order.
    description : Path or None
        metadata.yaml of a folder; None: a single file, or a folder without.
    unnamed : tuple of Path
        MCAP files in the folder that metadata.yaml does not name: for ROS 2 no part of it.

    """

    path: Path
    files: tuple[Path, ...]
    description: Path | None = None
    unnamed: tuple[Path, ...] = ()

    def read(self) -> list[Path]:
        """Return every file that reading the bag rests on, and a folder that nothing describes."""
        if self.description:
            return [*self.files, self.description]
        return [*self.files, *([self.path] if self.path.is_dir() else [])]

    def named_by_recorder(self) -> bool:
        """Return whether the files are called after the folder and counted on from 0."""
        expected = [f"{self.path.resolve().name}_{i}.mcap" for i in range(len(self.files))]
        return [file.name for file in self.files] == expected

    def remedy(self) -> str:
        """Return what to do with files that do not belong together, for an error message."""
        return (
            "name one file, or, if they are one recording, have its metadata.yaml written: "
            f"ros2 bag reindex -s mcap {self.path}"
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
        raise BagError(f"there is no bag {path}")
    if not path.is_dir():
        if path.suffix == ".db3":
            raise BagError(f"{path} is a bag in SQLite; {_convert(path)}")
        if path.suffix in _WHOLE:
            raise BagError(f"{path} is compressed as a whole; decompress it first")
        return BagFiles(path, (path,))
    description = path / "metadata.yaml"
    if description.is_file():
        files = _described_files(description)
        names = {file.name for file in files}
        unnamed = [file for file in sorted(path.glob("*.mcap")) if file.name not in names]
        return BagFiles(path, tuple(files), description, tuple(unnamed))
    files = sorted(path.glob("*.mcap"), key=_natural)
    if files:
        return _one_recording(BagFiles(path, tuple(files)))
    if list(path.glob("*.db3")):
        raise BagError(f"{path} is a bag in SQLite; {_convert(path)}")
    inner = (file.parent.name for kind in _OF_BAGS for file in path.glob(f"*/{kind}"))
    bags = sorted(set(inner), key=lambda name: _natural(Path(name)))
    held = f"; the bags in it are {listed(bags)}: name one of them" if bags else ""
    raise BagError(
        f"{path} is a folder without metadata.yaml and without .mcap files: no bag{held}"
    )


def _one_recording(found):
    parts = [_PART.fullmatch(file.name) for file in found.files]
    if len(parts) > 1 and (not all(parts) or len({part[1] for part in parts}) > 1):
        raise BagError(
            f"{found.path} is a folder without metadata.yaml, and its .mcap files are not named "
            f"as the parts of one recording (NAME_0.mcap, NAME_1.mcap, ...): "
            f"{listed([file.name for file in found.files])}; {found.remedy()}"
        )
    return found


def listed(names: list[str]) -> str:
    """Return names for an error message, as far as they can be read in one."""
    more = f" and {len(names) - _MOST_LISTED} more" if len(names) > _MOST_LISTED else ""
    return ", ".join(names[:_MOST_LISTED]) + more


def _described_files(description):
    path = description.parent
    try:
        info = yaml.safe_load(description.read_text(encoding="utf-8"))[
            "rosbag2_bagfile_information"
        ]
        names = info["relative_file_paths"]
        storage = info.get("storage_identifier", "mcap")
        mode = str(info.get("compression_mode") or "")
        old = int(info.get("version", _WITHOUT_FOLDER)) < _WITHOUT_FOLDER
        if not isinstance(names, list):
            raise TypeError
    except (
        yaml.YAMLError,
        UnicodeDecodeError,
        LookupError,
        TypeError,
        ValueError,
        AttributeError,
    ):
        raise BagError(
            f"{description} is not a description of a bag (rosbag2_bagfile_information with "
            f"relative_file_paths); remove it to read the .mcap files of {path}"
        ) from None
    files = [_named(path, str(name), old) for name in names]
    if storage != "mcap":
        raise BagError(f"{path} is a bag in {storage}; {_convert(path)}")
    if not files:
        raise BagError(
            f"{description} names no files; remove it to read the .mcap files of {path}"
        )
    if mode.upper() == "MESSAGE":
        raise BagError(
            f"{path} has every message compressed by itself (compression_mode: {mode}); convert "
            f"it: ros2 bag convert -i {path} with storage_id mcap and without compression_mode "
            "for the output"
        )
    for file in files:
        if files.count(file) > 1:
            raise BagError(
                f"{description} names {file.name} {files.count(file)} times, and its messages "
                "would be read as often; leave it there once"
            )
        if not file.is_file():
            raise BagError(f"{description} names {file.name}, which is not in {path}")
        if file.suffix != ".mcap":
            raise BagError(f"{file} is compressed as a whole; decompress it first")
    return files


def _named(path, name, old):
    beside = path.resolve().parent / name
    return beside if old and not (path / name).is_file() and beside.is_file() else path / name


def _convert(path):
    return f"convert it: ros2 bag convert -i {path} with storage_id mcap for the output"


def _natural(file):
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", file.name)]
