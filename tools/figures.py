"""
Write the tables of docs/chart.md and docs/stability.md, and their pictures, from their CSV files.

`make chart` runs it after the commands that measure; a test holds that tables and pictures are
those of the files. Run it from the root of the checkout.
"""

import csv
import sys
from pathlib import Path
from statistics import median

from peg_on_hole_ros.cli.chart import pieces_of, scores_of
from peg_on_hole_ros.cli.equation_ends import drawn_of
from peg_on_hole_ros.cli.pictures import save
from peg_on_hole_ros.cli.stability import edge_lines, found_in, verdicts_of
from peg_on_hole_ros.plots import chart as chart_plot
from peg_on_hole_ros.plots import equations
from peg_on_hole_ros.plots import stability as stability_plot
from peg_on_hole_ros.study import chart, stability
from peg_on_hole_ros.study.estimators import ESTIMATORS, WRENCH_RATES

BEGIN, END = "<!-- table -->\n\n", "\n\n<!-- end of table -->"


def rows_of(path: Path) -> list[list[str]]:
    """Return the rows of a CSV file below its head."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.reader(file))[1:]


def chart_table(scores) -> str:
    """Return the tables of the chart: over all kinds of scene, and of each by itself."""
    return f"{overall_table(*chart.limits(chart.overall(scores)))}\n\n{kinds_table(scores)}"


def overall_table(found, limits) -> str:
    """Return a row for each method, its rates side by side."""
    rows = {row.name: row for row in found}
    lines = [
        ("method", "error of the reactions [%]", "error of the tilt rate [rad/s]",
         "coverage of 95 % bounds", "step [us]", "whole path [us per ms of motion]"),
    ]  # fmt: skip
    for name in dict.fromkeys(one.name for one in ESTIMATORS):
        own = [rows[str(one)] for one in ESTIMATORS if one.name == name]
        first = own[0]
        lines.append(
            (
                name,
                _each(_digits(100 * row.reactions, 3) for row in own),
                _each(_digits(row.tilt_rate, 2) for row in own),
                f"{100 * first.reactions_inside:.0f} %",
                _step(first),
                _each(f"{row.whole:.0f}" for row in own) if first.whole == first.whole else "",
            )
        )
    lines.append(
        ("bound at 1 kHz", _digits(100 * limits.reactions, 2), _digits(limits.tilt_rate, 2), "",
         "", "")
    )  # fmt: skip
    return markdown(lines)


def kinds_table(scores) -> str:
    """Return a row for each method at 1 kHz, the error of its reactions in each kind of scene."""
    kinds = chart.of_kinds(scores)
    rows = {kind: {row.name: row for row in found} for kind, found in kinds.items()}
    lines = [("error of the reactions at 1 kHz [%]", *kinds)]
    for one in ESTIMATORS:
        if one.rate == WRENCH_RATES[0]:
            lines.append((one.name, *(_error(rows[kind][str(one)]) for kind in kinds)))
    bound = (rows[kind][chart.BOUND].reactions for kind in kinds)
    lines.append(("bound", *(_digits(100 * each, 2) if each == each else "" for each in bound)))
    return markdown(lines)


def _error(row):
    """Return an error with the spread of its seeds; in brackets where the chart has it hollow."""
    if row.reactions != row.reactions:
        return ""
    off, low, high = (
        _digits(100 * each, 2) for each in (row.reactions, row.reactions_low, row.reactions_high)
    )
    text = off if low == high else f"{off} ({low} to {high})"
    return text if chart.keeps(row) else f"[{text}]"


def _step(row):
    if row.step != row.step:
        return ""
    low, high = (_digits(value, 2) for value in (row.step_low, row.step_high))
    return f"{_digits(row.step, 2)} ({low} to {high})"


def _each(texts):
    return ", ".join(texts)


def _digits(value, count):
    if value == float("inf"):
        return "diverged"
    if value >= 10**count:
        return f"{value:.0f}"
    return f"{value:#.{count}g}".rstrip(".")


def markdown(lines) -> str:
    """Return a table of which the first line is the head."""
    texts = ["| " + " | ".join(line) + " |" for line in lines]
    return "\n".join([texts[0], "|---" * len(lines[0]) + "|", *texts[1:]])


def stability_table(found) -> str:
    """Return the tables of the map: where the default stops, and the results of methods."""
    ends = [("quantity", "low side", "high side"), *edge_lines(found)]
    shown = [one for one in stability.Verdict if one is not stability.Verdict.NONE]
    lines = [
        ("number of places", *(one.value for one in shown), "error of the reactions, median [%]")
    ]
    for name, verdicts in verdicts_of(found).items():
        own = [result.reactions for (_, method), result in found.items() if method == name]
        off = median(value for value in own if value == value)
        counts = [str(verdicts.count(verdict)) for verdict in shown]
        lines.append((name, *counts, _digits(100 * off, 2)))
    return f"{markdown(ends)}\n\n{markdown(lines)}"


def made(figures: Path) -> dict[str, tuple[str, dict]]:
    """Return the tables of each page, and its pictures by the end of their names."""
    scores = scores_of(rows_of(figures / "chart.csv"))
    whole = chart.limits(chart.overall(scores))
    kinds = {kind: chart.limits(rows) for kind, rows in chart.of_kinds(scores).items()}
    cycle = pieces_of(rows_of(figures / "chart_cycle.csv"))
    found = found_in(rows_of(figures / "stability.csv"))
    ends = drawn_of(rows_of(figures / "equations.csv"))
    return {
        "chart": (
            chart_table(scores),
            {
                "": chart_plot.figure(*whole),
                "_narrow": chart_plot.figure(*whole, narrow=True),
                "_kinds": chart_plot.kinds_figure(kinds),
                "_kinds_narrow": chart_plot.kinds_figure(kinds, narrow=True),
                "_cycle": chart_plot.cycle_figure(cycle),
                "_cycle_narrow": chart_plot.cycle_figure(cycle, narrow=True),
            },
        ),
        "stability": (
            stability_table(found),
            {end: stability_plot.figure(found, bool(end)) for end in ("", "_narrow")}
            | {f"_equations{end}": equations.figure(*ends, bool(end)) for end in ("", "_narrow")},
        ),
    }


def main(docs: Path = Path("docs")) -> int:
    """Write tables and pictures."""
    for name, (text, pictures) in made(docs / "figures").items():
        page = docs / f"{name}.md"
        old = page.read_text(encoding="utf-8")
        before, begin, rest = old.partition(BEGIN)
        _, end, after = rest.partition(END)
        if not (begin and end):
            raise SystemExit(f"{page} has no table between its two marks")
        page.write_text(before + begin + text + end + after, encoding="utf-8")
        for end, picture in pictures.items():
            save(picture, docs / "figures" / f"{name}{end}", (".png",))
    return 0


if __name__ == "__main__":
    sys.exit(main())
