"""Where every error of command line and node ends: one line on stderr, and an exit code."""

import os
import sys
import traceback
import warnings
from collections.abc import Callable

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.safe_text import cut, printable

PROGRAM = "peg-on-hole"
INTERRUPTED = 130
# As EX_SOFTWARE of sysexits.h: the fault is the program's.
INTERNAL = 70
# Set to anything, it has the traceback of such a fault printed too.
TRACEBACK = "PEG_ON_HOLE_TRACEBACK"
_LONGEST_TEXT = 400
# Names that a file makes up may be longer than any screen.
_LONGEST_LINE = 4000


def exit_code(act: Callable[[], int | None]) -> int:
    """
    Do something and return its exit code; what it raises is printed in one line.

    Parameters
    ----------
    act : callable
        Returns an exit code; None is 0.

    """
    try:
        with warnings.catch_warnings():
            if not sys.warnoptions:
                # Those of libraries are for whoever develops with them.
                warnings.simplefilter("ignore")
            return act() or 0
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception as error:
        if isinstance(error, SystemError) and isinstance(error.__cause__, KeyboardInterrupt):
            # C that went on with it, and whose caller noticed.
            return INTERRUPTED
        code, text = exit_code_and_text(error)
        if code == INTERNAL and os.environ.get(TRACEBACK):
            traceback.print_exc()
        print_error(text)
        return code


def exit_code_and_text(error: Exception) -> tuple[int, str]:
    """Return the exit code that an error stands for, and its text."""
    if isinstance(error, PegOnHoleError):
        return error.exit_code, str(error)
    if isinstance(error, OSError):
        place = (
            f"{os.fsdecode(error.filename)}: " if isinstance(error.filename, (str, bytes)) else ""
        )
        return PegOnHoleError.exit_code, f"{place}{error.strerror or error}"
    if isinstance(error, MemoryError):
        return PegOnHoleError.exit_code, "there is not enough memory for this"
    return INTERNAL, (
        f"a fault of the program, please report it: {described(error)}; with {TRACEBACK}=1 "
        "its traceback is printed"
    )


def print_error(text: str) -> None:
    """Print the line of an error."""
    line = cut(printable(text), _LONGEST_LINE)
    print(f"{PROGRAM}: error: {line}", file=sys.stderr, flush=True)


def described(error: BaseException) -> str:
    """Return an unforeseen error as a short text, with the place where it was raised."""
    text = cut(printable(error), _LONGEST_TEXT)
    frames = traceback.extract_tb(error.__traceback__, limit=-1)
    place = f" at {os.path.basename(frames[-1].filename)}:{frames[-1].lineno}" if frames else ""
    return f"{type(error).__name__}{': ' if text else ''}{text}{place}"
