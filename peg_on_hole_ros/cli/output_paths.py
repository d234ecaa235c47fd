"""Paths of what is written: checked before any work, and none of what is read."""

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from fcntl import LOCK_EX, LOCK_NB, flock
from pathlib import Path

from peg_on_hole_ros.bags.writer import part_of
from peg_on_hole_ros.errors import PegOnHoleError

# What `chart` and `stability` write into their folder.
_RESULTS = (".csv", ".partial", ".png", ".svg")


def check_output_paths(
    inputs: Iterable[str | Path],
    bags: Iterable[str | None] = (),
    texts: Iterable[str | None] = (),
) -> None:
    """
    Refuse places that cannot be written before the work, not after it.

    Parameters
    ----------
    inputs : iterable of str or Path
        Files that are read, and must not be overwritten; a folder stands for all .mcap files in
        it.
    bags, texts : iterable of str or None
        MCAP files and other files to write; None: not asked for.

    Raises
    ------
    PegOnHoleError
        No folder for it, no permission, a file that is read, or two outputs with one place.

    """
    inputs = [Path(path) for path in inputs]
    seen: list[Path] = []
    for paths, bag in ((bags, True), (texts, False)):
        for name in paths:
            if name is None:
                continue
            if not name:
                raise PegOnHoleError("the path of an output is empty; name a file")
            path = Path(name)
            try:
                _check_place(path, bag, inputs, seen)
            except OSError as error:
                raise PegOnHoleError(f"cannot write {path}: {error.strerror}") from None
            seen.append(path)


def _check_place(path, bag, inputs, seen):
    if not path.parent.is_dir():
        raise PegOnHoleError(f"cannot write {path}: there is no folder {path.parent}")
    if path.is_dir():
        raise PegOnHoleError(f"cannot write {path}: it is a folder")
    if path.exists() and not path.is_file():  # a pipe or a device
        if bag:
            raise PegOnHoleError(f"cannot write {path}: a bag is written to a regular file only")
        if not path.is_fifo():  # a pipe's reader would take a first close for the end
            path.open("ab").close()
        return
    written = [path, part_of(path)] if bag or _by_part(path) else [path]
    for source in inputs:
        if source.is_dir():
            if path.suffix == ".mcap" and _same(path.parent, source):
                raise PegOnHoleError(
                    f"cannot write {path}: it would be read as a part of the bag {source}, "
                    "which has no metadata.yaml"
                )
        elif any(_same(place, source) for place in written):
            raise PegOnHoleError(f"cannot write {path}: it is the file that is read")
    if any(_same(path, other) for other in seen):
        raise PegOnHoleError(f"cannot write {path}: two outputs have this place")
    _try(written[-1])


def _same(a, b):
    # Two names of one file, too: links and detours.
    one_place = os.path.realpath(a) == os.path.realpath(b)
    return one_place or (a.exists() and b.exists() and a.samefile(b))


def _try(path):
    """Open for writing, and leave all as it was."""
    if path.exists():
        path.open("ab").close()
    else:
        try:
            path.open("xb").close()
        finally:
            # A signal may come between the two.
            with suppress(OSError):
                path.unlink()


def write_text(path: str | Path, text: str) -> None:
    """
    Write a whole file, which has its name only then: as NAME.part, renamed at the end.

    Pipes, devices and links are written to as they are.

    Raises
    ------
    PegOnHoleError
        It cannot be written, as on a full disk; what was there before is kept.

    """
    path = Path(path)
    part = part_of(path) if _by_part(path) else None
    try:
        (part or path).write_text(text, encoding="utf-8")
        if part:
            part.replace(path)
    except BaseException as error:
        if part:
            with suppress(OSError):
                part.unlink()
        if not isinstance(error, OSError):
            raise
        raise PegOnHoleError(f"cannot write {path}: {error.strerror}") from None


def _by_part(path):
    # A link may be that of a process to its own output, /dev/stdout, whatever that is.
    return not path.is_symlink() and (path.is_file() or not path.exists())


def out_folder(path: str, config: str | None = None) -> Path:
    """
    Return a folder for results, made where it is missing.

    Parameters
    ----------
    path : str
    config : str, optional
        File that is read, and must not be taken for a result.

    Raises
    ------
    PegOnHoleError
        The path is empty, is a file, or cannot be made; or the configuration is named as a result
        in it.

    """
    if not path:
        raise PegOnHoleError("the path of the folder is empty; name one, such as --out results")
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if config and Path(config).suffix in _RESULTS and _same(Path(config).parent, folder):
            raise PegOnHoleError(
                f"{config} is named as the results that go into {folder}; rename it to .yaml"
            )
    except OSError as error:
        raise PegOnHoleError(f"cannot make the folder {folder}: {error.strerror}") from None
    return folder


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """
    Keep others of this program from writing results into a folder.

    Raises
    ------
    PegOnHoleError
        Another one does.

    """
    held = os.open(folder, os.O_RDONLY)
    try:
        _lock(held, folder)
        yield
    finally:
        os.close(held)


def _lock(held, folder):
    """Lock a folder for as long as this process, or its file descriptor, lives."""
    try:
        flock(held, LOCK_EX | LOCK_NB)
    except BlockingIOError:
        raise PegOnHoleError(
            f"another replay writes into {folder}: wait for it, or name another folder"
        ) from None
    except OSError:
        # A file system without locks.
        pass
