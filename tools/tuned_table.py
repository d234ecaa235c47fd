"""
Write the tables of docs/tuned_numbers.md anew, from peg_on_hole_ros/tuned_numbers.py.

    python tools/tuned_table.py
"""

import sys
from itertools import groupby
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tools")]

from marked_page import replaced  # noqa: E402

from peg_on_hole_ros.tuned_numbers import listed, subject_text, tuned_numbers  # noqa: E402

PAGE = ROOT / "docs" / "tuned_numbers.md"
BEGIN, END = "<!-- tuned numbers -->", "<!-- end of tuned numbers -->"


def table() -> str:
    """Return a table for each subject, below its name and what all its numbers have in common."""
    numbers, lines = tuned_numbers(), []
    for subject, group in groupby(listed(numbers), lambda each: each.name.rpartition(".")[0]):
        members = list(group)
        lines += [f"## {subject}", "", subject_text(members[0], numbers), ""]
        lines += ["| number | value | unit | what it does, and why |", "|---|---|---|---|"]
        for each in members:
            field = each.name.rpartition(".")[2]
            lines.append(f"| `{field}` | {value(each.value)} | {each.unit} | {each.reason} |")
        lines.append("")
    return "\n".join(lines[:-1])


def value(number) -> str:
    """Return a value as a reader has it."""
    if isinstance(number, tuple):
        return ", ".join(map(value, number))
    return str(number) if isinstance(number, int) else f"{number:g}"


def written(text: str) -> str:
    """Return the page with its tables as they have to be."""
    return replaced(text, BEGIN, END, table())


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
