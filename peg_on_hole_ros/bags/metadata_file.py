"""The metadata.yaml of a rosbag2 folder: which files are the bag's, read within bounds."""

from pathlib import Path
from typing import NamedTuple

import yaml

from peg_on_hole_ros.errors import BagError

# Of a bag of thousands of topics it has some hundred kB.
_MOST_BYTES = 4 << 20
_MOST_DEPTH = 64
# Up to the version before, the recorder put the folder's own name before each file's.
_WITHOUT_FOLDER = 4
# Compiled, where PyYAML was built so.
_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_OPENING = (yaml.SequenceStartEvent, yaml.MappingStartEvent)
_CLOSING = (yaml.SequenceEndEvent, yaml.MappingEndEvent)


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
    if path.stat().st_size > _MOST_BYTES:
        raise BagError(
            f"{path} has {path.stat().st_size} bytes, a description at most {_MOST_BYTES}; "
            f"remove it to read the files of {folder}"
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
