"""The page of many bags: outcomes, peaks and transition times over all tries, and each bag."""

from collections import Counter
from urllib.parse import quote

from peg_on_hole_ros.number_text import quantity
from peg_on_hole_ros.records import CONTACTS
from peg_on_hole_ros.report.markup import banner, html, section, table
from peg_on_hole_ros.report.page import standing_alone
from peg_on_hole_ros.report.provenance import made_at, versions
from peg_on_hole_ros.report.words import parts_of

_SHIFT_SCRIPTS = ("packed.js", "theme.js", "shift.js")
# Of the commonest causes of doubt so many are listed.
_CAUSES = 3
_PLOTS = (
    (
        "outcomes",
        "Outcomes",
        "",
        "Each bar is a try, in the order of the bags; a click leads to its report.",
        (),
    ),
    (
        *("transition", "Transition", "s"),
        "From first contact to two-point contact.",
        (("transition_time", "after first contact", 0),),
    ),
    (
        *("peaks", "Peak reactions", "N"),
        "Largest reaction at each contact while it was determined.",
        tuple((f"peak_{name}", f"N_{name}", i) for i, name in enumerate(CONTACTS)),
    ),
)
_TABLE_HEAD = "bag", "what is wrong", "outcome of its tries", "transition", "peak", "alarms"


def shift_page(results: list[dict], rows: list[dict]) -> str:
    """
    Return the page.

    Parameters
    ----------
    results : list of dict
        Of each bag, in order: `path`, `name`, `exit_code`, `error`, `files`, `doubts`.
    rows : list of dict
        The table: of each try, or of a bag without any.

    """
    tries = [row for row in rows if row["try"] is not None]
    reports = {result["name"]: _report(result) for result in results}
    plots = [
        {
            "name": name,
            "unit": unit,
            "lines": [
                {"column": column, "name": label, "color": color} for column, label, color in lines
            ],
        }
        for name, _, unit, _, lines in _PLOTS
    ]
    model = {"plots": plots if tries else [], "tries": _columns(tries, reports)}
    body = [
        "<header>\n<h1>Many bags</h1>",
        *_verdict(results, tries),
        '<p class="note">The same, a row for each try: <a href="bags.csv">bags.csv</a>.</p>',
        "</header>",
        section("bags", "Bags", _bags(results, rows)),
        section("plots", "Over all tries", *_panels(tries)),
        section(
            "origin", "Where this comes from", table(("", ""), [("made", made_at()), *versions()])
        ),
    ]
    return standing_alone("Many bags", body, model, _SHIFT_SCRIPTS)


def _report(result):
    """Return where a bag's report is, from the page; empty where it has none."""
    return f"{quote(result['name'])}/report.html" if "report.html" in result["files"] else ""


def _columns(tries, reports):
    columns = ("outcome", "transition_time", *(f"peak_{name}" for name in CONTACTS))
    return {
        "number": list(range(1, len(tries) + 1)),
        # Plotly takes markup in what it shows.
        "said": [html(f"{row['bag']}, try {row['try']}: {row['outcome']}") for row in tries],
        "link": [reports[row["folder"]] for row in tries],
        **{name: [row[name] for row in tries] for name in columns},
    }


def _verdict(results, tries):
    """Return what is wrong with how many bags, and the commonest cause, before what happened."""
    happened = html(_headline(results, tries))
    unread = [result for result in results if result["error"]]
    doubtful = [result for result in results if not result["error"] and result["doubts"]]
    if not unread and not doubtful:
        return [f'<p class="lead">{happened}</p>']
    parts = [
        f"{len(of)} of {len(results)} bags {what}"
        for of, what in ((unread, "could not be read whole"), (doubtful, "are doubtful"))
        if of
    ]
    kinds = Counter(parts_of(result["doubts"][0]).what for result in doubtful)
    lines = [
        f"{what[:1].upper()}{what[1:]}: {count} bag{'s'[: count > 1]}."
        for what, count in kinds.most_common(_CAUSES)
    ]
    return [
        banner("error" if unread else "warn", f"{', '.join(parts)}.", lines),
        f'<p class="verdict">{happened}</p>',
    ]


def _headline(results, tries):
    whole = sum(result["exit_code"] == 0 for result in results)
    inserted = sum(row["outcome"] == "inserted" for row in tries)
    return (
        f"{inserted} of {len(tries)} tries went in; {whole} of {len(results)} bags could be read "
        "whole."
    )


def _panels(tries):
    waiting = '<p class="waiting">Plots need JavaScript.</p>'
    if not tries:
        return [waiting, "<p>No bag holds a try.</p>"]
    panels = (
        f'<div class="panel"><h3>{html(title)}</h3>\n<p class="note">{html(note)}</p>\n'
        f'<div class="plot{" modes two" if name == "outcomes" else ""}" data-panel="{name}"></div>'
        "</div>"
        for name, title, _, note, _ in _PLOTS
    )
    return [waiting, *panels]


def _bags(results, rows):
    of = {}
    for row in rows:
        of.setdefault(row["folder"], []).append(row)
    # What needs a look comes first; among these the order is that of the arguments.
    ordered = sorted(results, key=lambda result: (not result["error"], not result["doubts"]))
    return table(
        _TABLE_HEAD,
        [_bag(result, of[result["name"]]) for result in ordered],
        raw=(0, 1),
        stacked=True,
    )


def _bag(result, rows):
    report = _report(result)
    name = html(result["path"])
    if report:
        name = f'<a href="{html(report)}">{name}</a>'
    tries = Counter(row["outcome"] for row in rows if row["outcome"])
    times = [row["transition_time"] for row in rows if row["transition_time"] is not None]
    peaks = [row[f"peak_{c}"] for row in rows for c in CONTACTS if row[f"peak_{c}"] is not None]
    return (
        name,
        _wrong(result),
        ", ".join(f"{count} {outcome}" for outcome, count in tries.items()) or "-",
        ", ".join(f"{t:.3f} s" for t in times[:3]) or "-",
        quantity(max(peaks), "N") if peaks else "not determined" if tries else "-",
        str(rows[0]["bag_alarms"]) if rows[0]["bag_alarms"] is not None else "-",
    )


def _wrong(result):
    """Return what is wrong with a bag, and what to set first, as HTML."""
    if result["error"]:
        return html(result["error"])
    if not result["doubts"]:
        return "nothing found"
    cause, more = parts_of(result["doubts"][0]), len(result["doubts"]) - 1
    text = f"<strong>{html(cause.what)}.</strong>"
    if cause.remedy:
        text += f" {html(cause.remedy.rstrip('.'))}."
    return f"{text} {more} more in its report." if more else text
