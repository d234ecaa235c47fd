"""What libraries print past Python's streams, held back until it is known what became of it."""

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager


class HeldBack:
    """
    What was printed.

    Attributes
    ----------
    text : str
        All of it, once the block has ended.

    """

    text = ""


@contextmanager
def held_back(written_after: bool = True) -> Iterator[HeldBack]:
    """
    Hold back what is written to the file of stderr by C and C++ code within a block.

    Where the block raises, its error tells what went wrong, and what was held back is dropped:
    whoever catches it has `text`. Else it is written after the block, or dropped too.
    """
    held = HeldBack()
    try:
        stderr = os.dup(2)
    except OSError:  # a process without one
        yield held
        return
    sys.stderr.flush()
    with tempfile.TemporaryFile() as kept:
        os.dup2(kept.fileno(), 2)
        try:
            try:
                yield held
            finally:
                sys.stderr.flush()
                os.dup2(stderr, 2)
                os.close(stderr)
                kept.seek(0)
                data = kept.read()
                held.text = data.decode(errors="replace")
            if written_after:
                _write(data)
        except BrokenPipeError:
            pass


def _write(data):
    with open(2, "wb", closefd=False, buffering=0) as out:
        out.write(data)
