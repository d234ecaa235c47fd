"""The report of a comparison: two outputs drawn over each other, and how far they are apart."""

from math import isfinite, nan, pi

import numpy as np

from peg_on_hole_ros.bags.estimates import Estimate
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.number_text import number, quantity
from peg_on_hole_ros.records import SIX_QUANTITIES
from peg_on_hole_ros.report.markup import html, points, section, table
from peg_on_hole_ros.report.model import model
from peg_on_hole_ros.report.page import document
from peg_on_hole_ros.report.panels import (
    Source,
    difference_panels,
    estimate_panels,
    with_data,
)
from peg_on_hole_ros.report.provenance import made_at, versions
from peg_on_hole_ros.report.thinning import ThinnedRows
from peg_on_hole_ros.report.tracks import MOST_DRAWN, Tracks, named
from peg_on_hole_ros.report.words import Remark

# Of the values of an estimate: angles and reactions.
_DRAWN = (0, 1, 2, 6, 7, 8)
_ANGLES = 3
_IN_STDDEV = "max_in_stddev", "rms_in_stddev"


class Overlay:
    """Collects pairs of estimates of one stamp."""

    def __init__(self) -> None:
        self.a, self.b = Tracks(), Tracks()
        self._difference = ThinnedRows(len(SIX_QUANTITIES))

    def add(self, a: Estimate, b: Estimate) -> None:
        """Take the estimates of one stamp."""
        self.a.add_recorded(a)
        self.b.add_recorded(b)
        apart = []
        for k, i in enumerate(_DRAWN):
            difference, stddev = b.values[i] - a.values[i], min(a.stddev[i], b.stddev[i])
            if 0 < k < _ANGLES and isfinite(difference):
                difference -= 2 * pi * round(difference / (2 * pi))
            known = stddev > 0.0 and (k < _ANGLES or _determined(a) and _determined(b))
            apart.append(difference / stddev if known else nan)
        self._difference.add(self.a.passed_ns, apart)

    def tables(self) -> dict[str, dict[str, np.ndarray]]:
        """Return the columns of `a`, `b` and `difference` [stddev]."""
        a, b = self.a.columns(), self.b.columns()
        for name in SIX_QUANTITIES[1:_ANGLES]:
            if name not in a or name not in b:
                continue
            # Both begin within half a turn of zero, not always on the same side.
            first_a, first_b = (column[np.isfinite(column)][0] for column in (a[name], b[name]))
            turns = 2 * pi * np.round((first_a - first_b) / (2 * pi))
            for end in ("", "_low", "_high"):
                b[name + end] = b[name + end] + turns
        apart = named(*self._difference.arrays(MOST_DRAWN), SIX_QUANTITIES)
        # What is the same has no line.
        differs = {
            name: column for name, column in apart.items() if name == "t" or np.nansum(column**2)
        }
        return {"a": a, "b": b, "difference": differs}


def _determined(estimate):
    return estimate.monitor.get("reactions_determined", 1.0) != 0.0


def comparison_page(
    a: str, b: str, result: dict, overlay: Overlay, configuration: Configuration
) -> str:
    """
    Return the report as one HTML page.

    Parameters
    ----------
    a, b : str
        What is compared, as it was given.
    result : dict
        What `compare --json` prints.
    overlay : Overlay
    configuration : Configuration
        Its limits are drawn.

    """
    tables = overlay.tables()
    sources = [Source("a", "A"), Source("b", "B", "second")]
    panels = [*estimate_panels(sources, configuration), *difference_panels()]
    modes = {"A": overlay.a.modes, "B": overlay.b.modes}
    drawn = model(
        with_data(panels, tables, 2),
        tables,
        overlay.a.passed_ns,
        modes,
        silence=configuration.filter.max_gap,
    )
    before = [
        "<header>\n<h1>Comparison of two outputs</h1>",
        f'<p class="lead">{html(_headline(result))}</p>',
        f'<p class="note">A: {html(a)}<br>B: {html(b)}</p>\n</header>',
        _configuration(result),
        section("summary", "In short", points(_summary(result))),
        _quantities(result),
    ]
    return document("Comparison of two outputs", before, drawn, [_origin()])


def _headline(result):
    if result["identical"]:
        return "Both outputs are the same, bit for bit."
    if not result["differs"]:
        return "Both outputs are the same in all that both have."
    rows = [row for row in result["quantities"] if row["max_in_stddev"] is not None]
    if not rows:
        return "The outputs differ."
    most = max(rows, key=lambda row: row["max_in_stddev"])
    if not most["max_in_stddev"]:
        return "The outputs differ, though not in angles, rates or reactions."
    return (
        f"The outputs differ, most in {most['name']}: by up to "
        f"{quantity(most['max'], most['unit'])}, {number(most['max_in_stddev'])} standard "
        "deviations."
    )


def _summary(result):
    stamps = result["stamps"]
    yield Remark(
        f"{stamps['common']} stamps are in both, {stamps['only_a']} in A alone, "
        f"{stamps['only_b']} in B alone."
    )
    yield Remark(
        f"The contact mode agrees at {result['contact_mode_agrees']:.2%} of them, the transition "
        f"at {result['transition_agrees']:.2%}."
    )


def apart(rows: list[dict]) -> tuple[list[dict], list[str]]:
    """Return the rows of what differs, and the names of what is the same in both."""
    return (
        [row for row in rows if row["max"] != 0.0],
        [row["name"] for row in rows if row["max"] == 0.0],
    )


def _quantities(result):
    differing, same = apart(result["quantities"])
    rows = [
        (
            row["name"],
            *(quantity(row[k], row["unit"]) for k in ("max", "rms")),
            *("-" if row[k] is None else number(row[k]) for k in _IN_STDDEV),
        )
        for row in differing
    ]
    head = "B - A", "max", "RMS", "max/stddev", "RMS/stddev"
    parts = [table(head, rows)] if rows else []
    if same:
        parts.append(f"<p>The same in both: {html(', '.join(same))}.</p>")
    return section("quantities", "Differences", *parts)


def _configuration(result):
    differences = result["configuration"]
    if differences is None:
        text = "<p>Not both outputs carry their configuration.</p>"
    elif differences:
        rows = [(name, str(x), str(y)) for name, (x, y) in differences.items()]
        text = table(("parameter", "A", "B"), rows)
    else:
        text = "<p>All settings are the same.</p>"
    return section("changed", "Settings that differ", text)


def _origin():
    rows = [("made", made_at()), *versions()]
    return section("origin", "Where this comes from", table(("", ""), rows))
