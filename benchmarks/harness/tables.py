"""Tables in Markdown and CSV, and the part of a page that a benchmark renews."""

import csv
import shutil
from collections.abc import Iterable, Sequence
from pathlib import Path

from benchmarks.harness.family import Report


def table(head: Sequence, rows: Iterable[Sequence]) -> str:
    """Return a table in Markdown."""
    lines = [_line(head), "|---" * len(head) + "|", *map(_line, rows)]
    return "\n".join(lines)


def _line(cells):
    return "|" + "".join(f" {cell} |" if cell != "" else " |" for cell in cells)


def three(values, digits: int) -> str:
    """Return numbers with so many digits, one after another."""
    return ", ".join(f"{value:.{digits}f}" for value in values)


def percent(share, digits: int = 0) -> str:
    """Return a share in per cent; empty where there is none."""
    return "" if share is None else f"{100 * share:.{digits}f} %"


def put_between(page: Path, name: str, text: str) -> None:
    """Put a text between the marks of a name in a page, in place of what is there."""
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    before, _, rest = page.read_text(encoding="utf-8").partition(begin)
    _, found, after = rest.partition(end)
    if not found:
        raise ValueError(f"{page}: no {begin} ... {end} in it; put both where the text shall be")
    page.write_text(f"{before}{begin}\n\n{text}\n\n{end}{after}", encoding="utf-8")


def write(report: Report, name: str, folder: Path, page: Path | None) -> None:
    """Write a family's report into its folder, and into a page."""
    (folder / f"{name}.md").write_text(f"{report.text}\n", encoding="utf-8")
    for kind, rows in report.csv.items():
        with (folder / f"{kind}.csv").open("w", newline="") as file:
            csv.writer(file).writerows(rows)
    if page is None:
        return
    put_between(page, name, report.page or report.text)
    for path in report.figures:
        (page.parent / "figures").mkdir(exist_ok=True)
        shutil.copyfile(path, page.parent / "figures" / f"{name}_{path.name}")
