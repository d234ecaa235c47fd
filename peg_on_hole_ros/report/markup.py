"""HTML of a report: whatever comes from a bag is escaped here, and nowhere else."""

from collections.abc import Iterable, Sequence
from html import escape

from peg_on_hole_ros.report.words import Remark


def shown(text: str) -> str:
    """Return a text that can be shown: bytes that are no UTF-8 and control characters escaped."""
    whole = text.encode("utf-8", "surrogateescape").decode("utf-8", "backslashreplace")
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in whole)


def html(text: str) -> str:
    """Return a text as HTML."""
    return escape(shown(text))


def section(name: str, title: str, *parts: str, open_: bool | None = None) -> str:
    """Return a section; `open_`: it can be folded, and is open or not at first."""
    body = "\n".join(part for part in parts if part)
    if open_ is None:
        return f'<section id="{name}">\n<h2>{html(title)}</h2>\n{body}\n</section>'
    state = " open" if open_ else ""
    return (
        f'<section id="{name}"><details{state}>\n<summary><h2>{html(title)}</h2></summary>\n'
        f"{body}\n</details></section>"
    )


def banner(level: str, headline: str, lines: Iterable[str]) -> str:
    """Return what stands above all else; `level`: `error` or `warn`."""
    more = "\n".join(f"<p>{html(line)}</p>" for line in lines)
    return f'<div class="banner {level}">\n<p class="lead">{html(headline)}</p>\n{more}\n</div>'


def jump(text: str, start: float, end: float | None = None, kind: str = "jump") -> str:
    """Return a link that brings the plots and the drawing to a time, or a span of time [s]."""
    until = "" if end is None else f",{end:.4f}"
    return f'<a class="{kind}" href="#t={start:.4f}{until}">{html(text)}</a>'


def sentence(place: Remark) -> str:
    """Return a sentence, with a link that brings to its time."""
    link = "" if place.t is None else " " + jump("show", place.t, kind="jump show")
    return html(place.text) + link


def points(places: Iterable[Remark]) -> str:
    """Return a list of sentences."""
    items = "\n".join(f"<li>{sentence(place)}</li>" for place in places)
    return f"<ul>\n{items}\n</ul>"


def table(
    head: Sequence[str],
    rows: Iterable[Sequence[str]],
    raw: Sequence[int] = (),
    stacked: bool = False,
) -> str:
    """
    Return a table that scrolls by itself where it is wide; numbers are flush right.

    Parameters
    ----------
    head : sequence of str
        All empty: there is none.
    rows : iterable of sequence of str
        At least one.
    raw : sequence of int
        Columns that are HTML already.
    stacked : bool
        On a narrow screen the cells of a row stand below each other, each with its heading.

    """
    rows = list(rows)
    kinds = [_kind(cell) if i not in raw else "" for i, cell in enumerate(rows[0])]
    heads = (
        f'<th scope="col"{kind if "number" in kind else ""}>{html(cell)}</th>'
        for cell, kind in zip(head, kinds)
    )
    lines = ["<tr>" + "".join(heads) + "</tr>"] if any(head) else []
    for row in rows:
        headings = head if stacked else [""] * len(row)
        cells = (_cell(cell, i in raw, headings[i]) for i, cell in enumerate(row))
        lines.append("<tr>" + "".join(cells) + "</tr>")
    body = "\n".join(lines)
    # A region that scrolls can be reached by keyboard.
    kind = "table stacked" if stacked else "table"
    return f'<div class="{kind}" tabindex="0"><table>\n{body}\n</table></div>'


def _cell(text, raw, heading):
    of = f' data-head="{html(heading)}"' if heading else ""
    return f"<td{of}>{text}</td>" if raw else f"<td{_kind(text)}{of}>{html(text)}</td>"


def _kind(text):
    """Return how a cell is set: numbers flush right, long words broken, sentences wide."""
    try:
        float(text.removesuffix("%"))
    except ValueError:
        longest = max(map(len, text.split()), default=0)
        return ' class="long"' if longest > 30 else ' class="words"' if len(text) > 40 else ""
    return ' class="number"'
