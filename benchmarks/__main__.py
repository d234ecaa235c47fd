"""
Run a family of benchmarks, and write its tables.

    python -m benchmarks FAMILY [--out out/FAMILY] [--only TEXT ...] [--page PAGE] [its own]

Figures of each member are kept in the folder as soon as they are there, keyed by their sources and
settings, so that a run which was stopped goes on where it was; `--summary` only tells what is
there. `--page` renews the family's tables in a page of docs/. `FAMILY --help` has the family's own
options.
"""

import argparse
import os
import sys
from pathlib import Path

from benchmarks.families import FAMILIES, family_of, module_of
from benchmarks.harness import runner, tables
from peg_on_hole_ros.numba_cache import PACKAGE_FOLDER


def parser_of(name: str) -> argparse.ArgumentParser:
    """Return the parser of a family's options."""
    family = family_of(name)
    parser = argparse.ArgumentParser(
        prog=f"python -m benchmarks {name}", description=module_of(name).__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    folder = Path("out") / name
    parser.add_argument("--out", type=Path, default=folder, help=f"figures, tables ({folder})")
    parser.add_argument("--page", type=Path, help="page whose tables are renewed")
    parser.add_argument("--workers", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument(
        "--only", nargs="+", metavar="TEXT", default=[""],
        help="members whose name holds one of the texts",
    )  # fmt: skip
    parser.add_argument("--summary", action="store_true", help="only tell what is there")
    if family.seeds:
        parser.add_argument("--seeds", type=int, default=family.seeds, help=f"({family.seeds})")
    if family.against:
        parser.add_argument("--against", type=Path, help="another checkout, for the same members")
    family.options(parser)
    return parser


def main(arguments=None) -> int:
    """Run a family; return 1 where something is not as it has to be."""
    chooser = argparse.ArgumentParser(
        prog="python -m benchmarks", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter, add_help=False,
    )  # fmt: skip
    chooser.add_argument("family", choices=list(FAMILIES))
    given = sys.argv[1:] if arguments is None else list(arguments)
    name = chooser.parse_args(given[:1]).family
    parser, family = parser_of(name), family_of(name)
    options = parser.parse_args(given[1:])
    wrong = family.check(options)
    if wrong:
        parser.error(wrong)
    other = options.against if family.against else None
    if other and not (other / PACKAGE_FOLDER.name).is_dir():
        parser.error(f"--against {other}: no folder {PACKAGE_FOLDER.name} there")
    members = [
        member
        for member in family.members(options)
        if any(text in str(member) for text in options.only)
    ]
    if not members:
        parser.error(f"no member's name holds {' or '.join(options.only)}")
    if other:
        members += [member._replace(checkout=str(other)) for member in members]
    if options.summary:
        found = runner.Kept(name, options.out).there(members)
        _say(f"{len(found)} of {len(members)} members are there")
    else:
        found = runner.run(name, members, options.out, options.workers, _say)
    if not found:
        parser.error(f"no member in {options.out} is of these sources and settings")
    report = family.report(found, options)
    tables.write(report, name, options.out, options.page)
    print(report.text, *report.problems, sep="\n")
    return int(len(report.problems) > 0)


def _say(text):
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
