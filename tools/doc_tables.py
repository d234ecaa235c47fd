"""
Write the tables of the documents that follow from the package anew.

    python tools/doc_tables.py

docs/topics.md has the outputs (peg_on_hole_ros/outputs.py), docs/integration.md the suspected
settings (peg_on_hole_ros/diagnosis/suspected/registry.py).
"""

import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tools")]

from marked_page import replaced  # noqa: E402

from peg_on_hole_ros.diagnosis.suspected.registry import SUSPECTED  # noqa: E402
from peg_on_hole_ros.monitor.output_row import MONITOR, OUTPUTS  # noqa: E402

Rows = list[tuple[str, ...]]


def monitor() -> Rows:
    """Return heading and rows of the numbers of the monitor."""
    rows = [("in `~/monitor`", "unit", "what it means", "when it is NaN")]
    for field, output in MONITOR.items():
        names = ", ".join(f"`{name}`" for name in output.names or (field,))
        rows.append((names, output.unit, output.meaning, output.missing))
    return rows


def others() -> Rows:
    """Return heading and rows of what the other topics have of an estimate."""
    rows = [("topic", "field", "unit", "what it means", "when it is NaN")]
    for output in OUTPUTS.values():
        if output.topic and output.topic != "monitor":
            topics = ", ".join(f"`~/{topic}`" for topic in output.topic.split())
            fields = ", ".join(f"`{each.split('.')[-1]}`" for each in output.field.split())
            rows.append((topics, fields, output.unit, output.meaning, output.missing))
    return rows


def suspected(adopted: bool) -> Rows:
    """Return rows of what is found of suspected settings, and used in place of what is stated."""
    return [row for each in SUSPECTED if adopted == each.ADOPTS for row in each.FINDS]


# By page: the tables, by the mark that each stands behind.
PAGES: dict[Path, dict[str, Rows]] = {
    ROOT / "docs" / "topics.md": {"outputs: monitor": monitor(), "outputs: others": others()},
    ROOT / "docs" / "integration.md": {
        "suspected: adopted": [("tried", "settings, or where"), *suspected(True)],
        "suspected: reported": [("reported", "where"), *suspected(False)],
    },
}


def written(page: Path) -> str:
    """Return a page with its tables as they have to be."""
    text = page.read_text(encoding="utf-8")
    for name, rows in PAGES[page].items():
        lines = ["| " + " | ".join(row) + " |" for row in rows]
        lines.insert(1, "|" + "---|" * len(rows[0]))
        end = f"<!-- {name.partition(':')[0]}: end -->"
        text = replaced(text, f"<!-- {name} -->", end, "\n".join(lines))
    return text


if __name__ == "__main__":
    for each in PAGES:
        each.write_text(written(each), encoding="utf-8")
