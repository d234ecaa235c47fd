"""A line while functions are compiled, and progress on a terminal."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from peg_on_hole_ros.cli.progress import ProgressBar


@contextmanager
def compiling_shown() -> Iterator[None]:
    """Show what is compiled within, if anything is."""
    # A command that does not import numba compiles nothing; to import it takes a while.
    if "numba" not in sys.modules:
        yield
        return
    from peg_on_hole_ros.startup.compiling import COMPILING, watched

    with ProgressBar("compiling") as progress:

        def tell(share):
            if not share:
                print(COMPILING, file=sys.stderr, flush=True)
            progress(share)

        with watched(tell):
            yield
