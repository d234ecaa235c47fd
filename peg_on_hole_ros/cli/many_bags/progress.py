"""A bar on a terminal over many bags, with a line for each that is done."""

import sys
from contextlib import suppress
from typing import Any

from peg_on_hole_ros.safe_text import printable


class Bar:
    """
    Prints a line for each bag on stdout; below them, on a terminal, a bar on stderr.

    Parameters
    ----------
    total : int
        Bags.

    """

    def __init__(self, total: int) -> None:
        self._total = total
        self._progress: Any = None
        self._bar: Any = None

    def __enter__(self) -> "Bar":
        """Show the bar."""
        # Without rich there is none; the lines come all the same.
        if sys.stderr.isatty():
            with suppress(ModuleNotFoundError):
                self._show()
        return self

    def _show(self):
        from rich import progress
        from rich.console import Console

        self._progress = progress.Progress(
            progress.TextColumn("replaying"),
            progress.BarColumn(),
            progress.MofNCompleteColumn(),
            progress.TimeElapsedColumn(),
            progress.TimeRemainingColumn(),
            console=Console(file=_Terminal(sys.stderr)),  # type: ignore[arg-type]
            redirect_stdout=False,
            redirect_stderr=False,
        )
        self._bar = self._progress.add_task("", total=self._total)
        self._progress.start()

    def done(self, line: str) -> None:
        """Tell what became of a bag."""
        if self._progress and sys.stdout.isatty():
            # Above the bar.
            self._progress.console.print(printable(line), markup=False, highlight=False)
        else:
            print(line, flush=True)
        if self._progress:
            self._progress.advance(self._bar)

    def __exit__(self, *_: object) -> None:
        """Leave the bar as it is."""
        if self._progress:
            self._progress.stop()


class _Terminal:
    """The command line's own stream escapes what a terminal would obey, but here it is meant."""

    def __init__(self, stream):
        self._stream = stream

    def write(self, text: str) -> int:
        getattr(self._stream, "control", self._stream.write)(text)
        return len(text)

    def __getattr__(self, name):
        return getattr(self._stream, name)
