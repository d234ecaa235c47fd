"""A page that stands alone: figures of a replay, plots, and the configuration it was made with."""

import base64
from collections.abc import Iterable, Sequence
from html import escape

_STYLE = """\
body { font: 15px/1.45 system-ui, sans-serif; max-width: 70em; margin: 2em auto; padding: 0 1em; }
table { border-collapse: collapse; margin: 1em 0; }
th, td { padding: .2em .8em; border-bottom: 1px solid #ccc; text-align: left; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
img { max-width: 100%; }
.damage { background: #fde0dc; padding: .5em 1em; }"""


def page(title: str, damage: str, parts: Iterable[str]) -> str:
    """
    Return an HTML page that loads nothing from elsewhere.

    Parameters
    ----------
    title : str
    damage : str
        Why the bag ended early; empty for a whole bag.
    parts : iterable of str
        HTML, from the functions below.

    """
    warning = f'<p class="damage">{escape(damage)}: what lies before has been used.</p>'
    body = "\n".join([f"<h1>{escape(title)}</h1>", *([warning] if damage else []), *parts])
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"<title>{escape(title)}</title>\n<style>\n{_STYLE}\n</style>\n</head>\n"
        f"<body>\n{body}\n</body>\n</html>\n"
    )


def heading(text: str) -> str:
    """Return a heading of the second level."""
    return f"<h2>{escape(text)}</h2>"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table; cells that are numbers are flush right."""
    lines = ["<table>", "<tr>" + "".join(f"<th>{escape(cell)}</th>" for cell in head) + "</tr>"]
    lines += ["<tr>" + "".join(map(_cell, row)) + "</tr>" for row in rows]
    return "\n".join([*lines, "</table>"])


def _cell(text):
    number = text.removesuffix("%").replace(".", "").replace("-", "").replace("e", "").isdigit()
    return f'<td class="number">{escape(text)}</td>' if number else f"<td>{escape(text)}</td>"


def picture(png: bytes, text: str) -> str:
    """Return a PNG within the page, and its description."""
    data = base64.b64encode(png).decode("ascii")
    return f'<img alt="{escape(text)}" src="data:image/png;base64,{data}">'
