"""
The command `peg-on-hole`; imports nothing heavy, a subcommand's module loads when it runs.

Exit codes: 0 done; 2 bad arguments or configuration; 3 bag unreadable or without the needed
topics; 4 ended early on a cut-off or damaged bag, with what was read kept; 70 a fault of the
program.
"""

import gc
import importlib
import sys

from peg_on_hole_ros.cli.arguments import parsed
from peg_on_hole_ros.cli.compiling import compiling_shown
from peg_on_hole_ros.cli.terminal_output import ignore_broken_pipes
from peg_on_hole_ros.startup.exit_codes import exit_code
from peg_on_hole_ros.startup.interrupt import ended_by_signals

# New objects between two looks for garbage; Python's own is 700.
_GARBAGE = 50_000


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code; an error is one line on stderr."""
    with ignore_broken_pipes():
        return exit_code(lambda: _run(sys.argv[1:] if arguments is None else arguments))


def _run(arguments):
    asked = parsed(arguments)
    # The hundreds of thousands of objects of numba and numpy come to stay: to look through them
    # again and again for garbage is a tenth of a second of each start.
    gc.set_threshold(_GARBAGE)
    with ended_by_signals():
        module = importlib.import_module(f"peg_on_hole_ros.cli.{asked.command}")
        with compiling_shown():
            code = module.run(asked)
        sys.stdout.flush()
        return code


if __name__ == "__main__":
    sys.exit(main())
