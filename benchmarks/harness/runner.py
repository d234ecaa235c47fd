"""Members on several processes; a run that was stopped goes on, by figures kept in files."""

import hashlib
import json
import multiprocessing
import os
import random
import re
import time
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path

from benchmarks.families import family_of, module_of
from peg_on_hole_ros.numba_cache import PACKAGE_FOLDER

# What figures come from; tables and runs may change beside them.
HARNESS = [
    Path(__file__).with_name(f"{name}.py")
    for name in ("player", "errors", "events", "truths", "draw", "exact")
]


@cache
def sources_key(
    parts: tuple[str, ...], files: tuple[Path, ...], package: Path = PACKAGE_FOLDER
) -> str:
    """
    Return a name for the state of everything that figures come from.

    Parameters
    ----------
    parts : tuple of str
        Folders or modules of the package.
    files : tuple of Path
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


class Kept:
    """The figures of a family's members in a folder."""

    def __init__(self, name: str, folder: Path):
        self.folder, self.family = folder, family_of(name)
        self.sources = (module_of(name), *self.family.sources)

    def file(self, member) -> Path:
        """Return where a member's figures are kept."""
        plain = re.sub(r"[^\w.+-]+", "_", str(member))
        return self.folder / "runs" / f"{plain}.json"

    def asked(self, member) -> dict:
        """Return what the file has to say of itself: sources, and all that the member states."""
        checkout = getattr(member, "checkout", "")
        package = Path(checkout) / PACKAGE_FOLDER.name if checkout else PACKAGE_FOLDER
        files = (each if isinstance(each, Path) else Path(each.__file__) for each in self.sources)
        key = sources_key(self.family.parts, (*HARNESS, *files), package)
        return {"key": key, "member": json.loads(json.dumps(member, default=str))}

    def figures(self, member):
        """Return a member's figures if they are those asked for, else None."""
        tree = kept(self.file(member), self.asked(member))
        return None if tree is None else tree["figures"]

    def there(self, members: Iterable) -> list[tuple]:
        """Return (member, figures) of those members that have them."""
        rows = [(member, self.figures(member)) for member in members]
        return [row for row in rows if row[1] is not None]

    def compute(self, member) -> None:
        """Score a member and keep its figures."""
        figures = self.family.score(member, self.folder)
        keep(self.file(member), {**self.asked(member), "figures": figures})


def _compute_group(task) -> str:
    name, folder, members = task
    store = Kept(name, folder)
    for member in members:
        store.compute(member)
    more = f" and {len(members) - 1} more" if len(members) > 1 else ""
    return f"{members[0]}{more}"


def run(
    name: str, members: list, folder: Path, workers: int = 1, report: Callable = print
) -> list[tuple]:
    """
    Compute what is missing of a family's members; return (member, figures) of all.

    Parameters
    ----------
    name : str
        Of the family.
    members : list
    folder : Path
        Where figures are kept, and what is simulated.
    workers : int
        Processes.
    report : callable
        Takes lines on the progress.

    """
    store = Kept(name, folder)
    (folder / "runs").mkdir(parents=True, exist_ok=True)
    groups: dict = {}
    for member in members:
        if store.figures(member) is None:
            groups.setdefault(store.family.group(member), []).append(member)
    missing = sum(map(len, groups.values()))
    report(f"{name}: {len(members)} members, {missing} to compute")
    work_through(_compute_group, [(name, folder, g) for g in groups.values()], workers, report)
    return store.there(members)


def work_through(function: Callable, tasks: list, workers: int, report: Callable) -> None:
    """
    Call a function with every task, on several processes, and report the progress.

    Parameters
    ----------
    function : callable
        Of a module; returns the task's name.
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


def _watch(done, count, begin, report):
    for i, name in enumerate(done, 1):
        spent = time.monotonic() - begin
        left = spent / i * (count - i)
        report(f"  {i}/{count} {name}; {spent:.0f} s, about {left:.0f} s to go")
