"""
Write the tables of outputs in docs/topics.md anew, from peg_on_hole_ros/outputs.py.

    python tools/output_tables.py
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from peg_on_hole_ros.monitor.output_row import MONITOR, OUTPUTS  # noqa: E402

PAGE = ROOT / "docs" / "topics.md"


def monitor() -> list[tuple[str, ...]]:
    """Return heading and rows of the numbers of the monitor."""
    rows = [("in `~/monitor`", "unit", "what it means", "when it is NaN")]
    for field, output in MONITOR.items():
        names = ", ".join(f"`{name}`" for name in output.names or (field,))
        rows.append((names, output.unit, output.meaning, output.missing))
    return rows


def others() -> list[tuple[str, ...]]:
    """Return heading and rows of what the other topics have of an estimate."""
    rows = [("topic", "field", "unit", "what it means", "when it is NaN")]
    for output in OUTPUTS.values():
        if output.topic and output.topic != "monitor":
            topics = ", ".join(f"`~/{topic}`" for topic in output.topic.split())
            fields = ", ".join(f"`{each.split('.')[-1]}`" for each in output.field.split())
            rows.append((topics, fields, output.unit, output.meaning, output.missing))
    return rows


def written(text: str) -> str:
    """Return a page with its tables as they have to be."""
    for name, rows in (("monitor", monitor()), ("others", others())):
        lines = ["| " + " | ".join(row) + " |" for row in rows]
        lines.insert(1, "|" + "---|" * len(rows[0]))
        begin, end = f"<!-- outputs: {name} -->", "<!-- outputs: end -->"
        table = "\n".join([begin, "", *lines, "", end])
        text, count = re.subn(f"{begin}.*?{end}", lambda _, t=table: t, text, flags=re.DOTALL)
        if count != 1:
            raise SystemExit(f"{PAGE}: {begin} is there {count} times")
    return text


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
