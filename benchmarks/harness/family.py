"""What a family of members states of itself, for the one runner and the one command."""

from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

# Of the package, what figures of the whole estimate come from; the last line as older checkouts
# call it.
ESTIMATE = (
    "config/options.py", "records.py", "mechanics", "measurements", "estimator", "monitor",
    "diagnosis", "engine", "sim",
    "pipeline.py", "processing.py", "options.py", "estimation", "monitoring", "simulation",
)  # fmt: skip


class Report(NamedTuple):
    """
    What is written of a family's figures.

    Attributes
    ----------
    text : str
        Printed, and kept as `FAMILY.md` in the folder.
    csv : dict of str to list of rows
        By name of the file, each with its head.
    page : str
        What is put between the marks of a page; empty: the text.
    figures : list of Path
        Pictures that go to the `figures` of the page's folder.
    problems : list of str
        What is not as it has to be: printed, and the command ends with 1.

    """

    text: str
    csv: dict[str, list[list]] = {}
    page: str = ""
    figures: Sequence[Path] = ()
    problems: Sequence[str] = ()


class Member(NamedTuple):
    """
    One thing that a family scores. A family may have a record of its own in its place.

    Attributes
    ----------
    name : str
        For files and tables; no other of the family has it.
    of : any
        What it is: a plain tree, or named tuples.
    seeds : int
        Noise seeds that it is measured with.
    checkout : str
        Folder of another checkout that plays it; empty: this one.

    """

    name: str
    of: Any
    seeds: int = 0
    checkout: str = ""

    def __str__(self):
        """Return a name for files and tables."""
        return f"{self.name}{'_other' if self.checkout else ''}"


@dataclass(frozen=True)
class Family:
    """
    Members with their seeds and settings, how each is scored, and what is written.

    Attributes
    ----------
    members : callable
        Returns the members asked for by options: named tuples that say all that their figures
        hang on, with a name for files and tables as their text.
    score : callable
        Returns the figures of a member, a plain tree; gets the folder for what is simulated.
    report : callable
        Returns the Report of a list of (member, figures), and options.
    options : callable
        Adds the family's options to a parser.
    check : callable
        Returns what is wrong with options, or nothing.
    group : callable
        Members of one group run in one process, one after the other: they share a truth.
    sources : tuple of modules and Path
        What figures come from, beside the harness and the family's own module.
    parts : tuple of str
        Folders and modules of the package that they come from.
    seeds : int
        Default of `--seeds`; 0: there is no such option.
    against : bool
        Whether another checkout may play the same members beside (`--against`).

    """

    members: Callable[[Namespace], list]
    score: Callable[[Any, Path], Any]
    report: Callable[[list[tuple[Any, Any]], Namespace], Report]
    options: Callable[[ArgumentParser], None] = lambda parser: None
    check: Callable[[Namespace], str] = lambda options: ""
    group: Callable[[Any], Hashable] = str
    sources: tuple[ModuleType | Path, ...] = ()
    parts: tuple[str, ...] = ESTIMATE
    seeds: int = 0
    against: bool = False
