"""Which bags files, folders and patterns name, and what the folder of each one's results is."""

import glob
import hashlib
import os
import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from peg_on_hole_ros.bags.storage.bag_files import bag_files, bags_in, bare
from peg_on_hole_ros.errors import BagError, PegOnHoleError

RESULT = "result.json"
_BAG_METADATA = "metadata.yaml"


class Named(NamedTuple):
    """
    A bag among many.

    Attributes
    ----------
    path : Path
        As the arguments lead to it.
    name : str
        Of the folder for its results: the same whatever other bags there are.

    """

    path: Path
    name: str


def named_bags(arguments: Iterable[str], out: Path) -> list[Named]:
    """
    Return the bags that arguments name, each once, in their order.

    Parameters
    ----------
    arguments : iterable of str
        Bags, folders that hold bags at any depth, and patterns.
    out : Path
        Folder of the results: what lies in it is no input.

    Raises
    ------
    PegOnHoleError
        An empty argument, as an unset variable of a shell gives.
    BagError
        An argument that names nothing.

    """
    found: dict[str, Path] = {}
    for argument in arguments:
        for path in _matches(argument):
            bags = list(_bags(path, os.path.realpath(out)))
            if not bags:
                raise BagError(f"{path} is a folder that holds no bag")
            for bag in bags:
                # Not by Path.resolve, which raises where links lead in a circle.
                found.setdefault(os.path.realpath(bag), bag)
    return [Named(path, _name(Path(where))) for where, path in found.items()]


def _matches(argument):
    if not argument:
        raise PegOnHoleError("the path of the bag is empty; name a bag, a folder or a pattern")
    if os.path.lexists(argument):
        return [Path(argument)]
    matches = sorted(glob.glob(argument, recursive=True), key=len, reverse=True)
    if not matches:
        raise BagError(f"there is no bag {argument}")
    # `**` follows links, in circles too: the shortest way to each is its name.
    return sorted({os.path.realpath(match): Path(match) for match in matches}.values())


def _bags(path, out):
    """Yield a bag, or those below a folder that is none."""
    if not path.is_dir():
        yield path
        return
    if os.path.realpath(path) == out or (path / RESULT).is_file():
        return
    if (path / _BAG_METADATA).is_file() or _parts_of_one(path):
        yield path
        return
    yield from bags_in(path)
    for inner in sorted(path.iterdir()):
        if inner.is_dir() and not inner.is_symlink():
            yield from _bags(inner, out)


def _parts_of_one(folder):
    """Return whether a folder is that of a recorder which was killed."""
    try:
        return bag_files(folder).named_by_recorder()
    except BagError:
        return False


def _name(path):
    stem = bare(path).stem if path.is_file() else path.name
    digest = hashlib.sha256(os.fsencode(path)).hexdigest()
    return f"{re.sub(r'[^A-Za-z0-9._-]', '_', stem)[:60]}-{digest[:8]}"
