"""Write a bag as a rosbag2 folder: one MCAP file, and the metadata.yaml that describes it."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import yaml
from mcap.reader import make_reader

from peg_on_hole_ros.errors import PegOnHoleError

# Read by ROS 2 from Humble on.
_VERSION = 5
DESCRIPTION = "metadata.yaml"


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
