"""Long work that goes on where it was stopped: figures kept in files, keyed by their sources."""

import argparse
import hashlib
import json
import multiprocessing
import os
import random
import time
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

from peg_on_hole_ros.numba_cache import PACKAGE

# Of the package, what figures of the whole estimate come from.
ESTIMATE = (
    "records.py", "config/options.py", "mechanics", "measurements", "estimator", "monitor",
    "engine", "sim",
)  # fmt: skip


def parsed(text: str, parts: Iterable[str], seeds: int, folder: Path, arguments=None):
    """
    Return the options of a script of several parts; its folder is there then.

    Parameters
    ----------
    text : str
        The script's docstring.
    parts : iterable of str
    seeds, folder
        Defaults.
    arguments : list of str, optional
        None: the command line's.

    """
    parser = argparse.ArgumentParser(description=text.splitlines()[1])
    parser.add_argument("--part", nargs="+", choices=list(parts), default=list(parts))
    parser.add_argument("--seeds", type=int, default=seeds, help=f"noise seeds ({seeds})")
    parser.add_argument("--folder", type=Path, default=folder)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args(arguments)
    options.folder.mkdir(parents=True, exist_ok=True)
    return options


def sources_key(parts: Iterable[str], files: Iterable[Path], package: Path = PACKAGE) -> str:
    """
    Return a name for the state of everything that figures come from.

    Parameters
    ----------
    parts : iterable of str
        Folders or modules of the package.
    files : iterable of Path
        Further sources.
    package : Path
        The package; of another checkout it may lack some of the parts.

    """
    digest = hashlib.sha256()
    found = list(files)
    for part in parts:
        path = package / part
        found += sorted(path.rglob("*.py")) if path.is_dir() else [path] * path.exists()
    for path in found:
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def keep(path: Path, tree: dict) -> None:
    """Write a tree as JSON; a run that is stopped meanwhile leaves the file as it was."""
    partial = path.with_suffix(f".{os.getpid()}.tmp")
    partial.write_text(json.dumps(tree, indent=1))
    partial.replace(path)


def kept(path: Path, asked: dict):
    """Return a file's tree if it holds what is asked for, else None."""
    try:
        tree = json.loads(path.read_text())
    except (OSError, ValueError):
        return None
    return tree if all(tree.get(name) == value for name, value in asked.items()) else None


def work_through(function: Callable, tasks: list, workers: int, report: Callable) -> None:
    """
    Call a function with every task, on several processes, and report the progress.

    Parameters
    ----------
    function : callable
        Of a module; returns (name, what became of it).
    tasks : list
    workers : int
    report : callable

    """
    tasks, begin = list(tasks), time.monotonic()
    # Of a run that is stopped, what is there shall be of every kind.
    random.Random(0).shuffle(tasks)
    if workers > 1 and len(tasks) > 1:
        with multiprocessing.get_context("spawn").Pool(workers) as pool:
            _watch(pool.imap_unordered(function, tasks), len(tasks), begin, report)
    else:
        _watch(map(function, tasks), len(tasks), begin, report)


def figures_of(function: Callable, tasks: list[tuple], workers: int) -> list:
    """
    Return the figures of all tasks, of which those are worked through that are not kept.

    Parameters
    ----------
    function : callable
        As for `work_through`; keeps the "figures" of its task.
    tasks : list of tuple
        Each ends with the path of its file and with what is asked of that, as for `kept`.
    workers : int

    """
    missing = [task for task in tasks if kept(*task[-2:]) is None]
    work_through(function, missing, workers, partial(print, flush=True))
    return [kept(*task[-2:])["figures"] for task in tasks]


def put_between(page: Path, begin: str, end: str, text: str) -> None:
    """Put a text between two marks of a page, in place of what is there."""
    before, _, rest = page.read_text(encoding="utf-8").partition(begin)
    _, found, after = rest.partition(end)
    if not found:
        raise ValueError(f"{page}: no {begin} ... {end} in it; put both where the text shall be")
    page.write_text(f"{before}{begin}\n\n{text}\n\n{end}{after}", encoding="utf-8")


def _watch(done, count, begin, report):
    for i, (name, end) in enumerate(done, 1):
        spent = time.monotonic() - begin
        left = spent / i * (count - i)
        report(f"  {i}/{count} {name}: {end}; {spent:.0f} s, about {left:.0f} s to go")
