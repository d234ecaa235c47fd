"""
The metadata.yaml of a rosbag2 folder: read within bounds, and written beside a bag's file.

The reader of rosbags opens no folder of which one file was cut off ("File end magic is invalid"),
and reads messages at a tenth of the speed (`benchmarks.cost.reading`).
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from mcap.reader import make_reader

from peg_on_hole_ros.errors import BagError, PegOnHoleError

# Of a bag of thousands of topics it has some hundred kB.
_MOST_METADATA_BYTES = 4 << 20
_MOST_DEPTH = 64
# Up to the version before, the recorder put the folder's own name before each file's.
_WITHOUT_FOLDER = 4
# Compiled, where PyYAML was built so.
_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_OPENING = (yaml.SequenceStartEvent, yaml.MappingStartEvent)
_CLOSING = (yaml.SequenceEndEvent, yaml.MappingEndEvent)
# Read by ROS 2 from Humble on.
_VERSION = 5
DESCRIPTION = "metadata.yaml"


class Description(NamedTuple):
    """
    What is needed of a metadata.yaml; of all else, as of how it is compressed, files tell.

    Attributes
    ----------
    names : list of str
        Of files, as they stand there.
    storage : str
        Such as `mcap` and `sqlite3`; empty where it is not said.
    with_folder : bool
        Whether names begin with that of the folder.

    """

    names: list[str]
    storage: str
    with_folder: bool


def read_description(path: Path) -> Description:
    """
    Read a metadata.yaml of any version.

    Raises
    ------
    BagError
        It is none, or names no files.

    """
    folder = path.parent
    if path.stat().st_size > _MOST_METADATA_BYTES:
        raise BagError(
            f"{path} has {path.stat().st_size} bytes, a description at most "
            f"{_MOST_METADATA_BYTES}; remove it to read the files of {folder}"
        )
    try:
        text = path.read_text(encoding="utf-8")
        _check_depth(text)
        info = yaml.load(text, Loader=_Loader)["rosbag2_bagfile_information"]
        names, storage = info["relative_file_paths"], info.get("storage_identifier", "")
        version = int(info.get("version", _WITHOUT_FOLDER))
        # What aliases make of a few bytes is never walked through.
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise TypeError
    # Scalars with a tag that they do not fit make PyYAML raise what the conversion does.
    except (yaml.YAMLError, ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
        raise BagError(
            f"{path} is not a description of a bag (rosbag2_bagfile_information with "
            f"relative_file_paths); remove it to read the files of {folder}"
        ) from None
    if not names:
        raise BagError(f"{path} names no files; remove it to read the files of {folder}")
    return Description(names, str(storage)[:80], version < _WITHOUT_FOLDER)


def _check_depth(text):
    depth = 0
    for event in yaml.parse(text, Loader=_Loader):
        depth += isinstance(event, _OPENING) - isinstance(event, _CLOSING)
        if depth > _MOST_DEPTH:
            raise ValueError(f"nested deeper than {_MOST_DEPTH}")


def is_folder_name(name: str) -> bool:
    """Return whether a folder is asked for: a name with a slash at its end, or no suffix."""
    path = Path(name)
    return name.endswith((os.sep, "/")) or not (path.suffix or path.exists())


@contextmanager
def rosbag2_folder(path: Path) -> Iterator[Path]:
    """
    Make a folder; give the file to be written, and describe it at the end of the block.

    Where the block raises, or writes nothing, the folder is taken away again.

    Raises
    ------
    PegOnHoleError
        The folder has something in it already, or cannot be made.

    """
    file = path / f"{path.resolve().name}_0.mcap"
    if not path.parent.is_dir():
        raise PegOnHoleError(f"cannot write {path}: there is no folder {path.parent}")
    try:
        _make(path)
        yield file
        if file.exists():
            described = yaml.safe_dump(_description(file), sort_keys=False)
            (path / DESCRIPTION).write_text(described, encoding="utf-8")
    finally:
        with suppress(OSError):
            path.rmdir()


def _make(path):
    try:
        path.mkdir(exist_ok=True)
        if any(path.iterdir()):
            raise PegOnHoleError(
                f"cannot write {path}: the folder has something in it; name another"
            )
    except OSError as error:
        raise PegOnHoleError(f"cannot write {path}: {error.strerror}") from None


def _description(file: Path) -> dict[str, Any]:
    """Return what rosbag2 writes of a bag of one file."""
    with file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None and summary.statistics is not None  # ours has both
    statistics = summary.statistics
    topics = [
        {
            "topic_metadata": {
                "name": channel.topic,
                "type": summary.schemas[channel.schema_id].name,
                "serialization_format": channel.message_encoding,
                "offered_qos_profiles": channel.metadata.get("offered_qos_profiles", ""),
            },
            "message_count": statistics.channel_message_counts.get(number, 0),
        }
        for number, channel in summary.channels.items()
    ]
    return {
        "rosbag2_bagfile_information": {
            "version": _VERSION,
            "storage_identifier": "mcap",
            **_span(statistics),
            "topics_with_message_count": topics,
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [file.name],
            "files": [{"path": file.name, **_span(statistics)}],
        }
    }


def _span(statistics):
    begin_ns = statistics.message_start_time
    return {
        "starting_time": {"nanoseconds_since_epoch": begin_ns},
        "duration": {"nanoseconds": statistics.message_end_time - begin_ns},
        "message_count": statistics.message_count,
    }
