"""Output and errors whose reader may go before the work is done, as `head` goes."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


class _Stream:
    """A text stream that lets what is left go nowhere once its reader has gone."""

    def __init__(self, stream):
        self._stream = stream

    def write(self, text: str) -> int:
        """Write a text, or drop it."""
        try:
            return self._stream.write(text)
        except BrokenPipeError:
            self.forget()
            return len(text)

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
def readers_may_go() -> Iterator[None]:
    """Do what is done within to its end, with its exit code, whether anybody reads or not."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = map(_Stream, before)
    try:
        yield
    finally:
        for stream in (sys.stdout, sys.stderr):
            try:
                stream.flush()
            except OSError:
                # A full disk; if it was to be told, it has been.
                stream.forget()
        sys.stdout, sys.stderr = before
