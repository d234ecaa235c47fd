"""A line of progress on a terminal; nothing of it when piped."""

import sys
import time

from peg_on_hole_ros.safe_text import printable

_PERIOD = 0.2  # [s] between two updates


class ProgressBar:
    """
    Shows a share on stderr if that is a terminal; use it in a `with` block.

    Parameters
    ----------
    text : str
        What is done.

    """

    def __init__(self, text: str) -> None:
        self._text = printable(text)
        self._shown = sys.stderr.isatty()
        self._last = 0.0

    def __call__(self, share: float) -> None:
        """Show a share of 0 to 1."""
        now = time.monotonic()
        if self._shown and now - self._last >= _PERIOD:
            self._last = now
            _control(f"\r{self._text} {100 * share:3.0f} %\x1b[K")

    def __enter__(self) -> "ProgressBar":
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Remove the line."""
        if self._shown and self._last:
            _control("\r\x1b[K")


def _control(text):
    # The command line's own stream escapes what a terminal would obey, but here it is meant.
    getattr(sys.stderr, "control", sys.stderr.write)(text)
    sys.stderr.flush()
