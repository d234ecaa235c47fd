"""stdout and stderr: printable for any terminal, and tolerant of a reader that has gone."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from peg_on_hole_ros.safe_text import printable


class _Stream:
    """
    A text stream that lets what is left go nowhere once its reader has gone.

    What a terminal would obey is written as an escape, and so is what the stream cannot encode:
    a topic, a frame or a file may have any name.
    """

    def __init__(self, stream):
        self._stream = stream
        self.ended = False

    def write(self, text: str) -> int:
        """Write a text, or drop it; only its ends of lines are obeyed."""
        if self.ended:
            # Of a library that has kept the stream: colorama resets the terminal at its exit.
            self.control(text)
            return len(text)
        self.control("\n".join(map(printable, text.split("\n"))))
        return len(text)

    def control(self, text: str) -> None:
        """Write a text as it is, as for progress on a terminal."""
        try:
            self._stream.write(text)
        except UnicodeEncodeError:
            encoding = self._stream.encoding or "ascii"
            self._stream.write(text.encode(encoding, "backslashreplace").decode(encoding))
        except BrokenPipeError:
            self.forget()

    def flush(self) -> None:
        """Hand on what was written, or drop it."""
        try:
            self._stream.flush()
        except BrokenPipeError:
            self.forget()

    def forget(self) -> None:
        """Let what is left go nowhere: Python would complain again at its end."""
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self._stream.fileno())
        os.close(nowhere)

    def __getattr__(self, name):
        return getattr(self._stream, name)


@contextmanager
def ignore_broken_pipes() -> Iterator[None]:
    """Do what is done within to its end, whether anybody reads or not."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = made = tuple(map(_Stream, before))
    try:
        yield
    finally:
        for stream in made:
            stream.ended = True
            try:
                stream.flush()
            except OSError:
                # A full disk; if it was to be told, it has been.
                stream.forget()
        sys.stdout, sys.stderr = before
