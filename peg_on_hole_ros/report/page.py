"""Put a page together: words and tables as HTML, plots as data, the library once, all packed."""

import base64
import gzip
import json
from importlib.resources import files
from importlib.util import find_spec
from math import floor, log10
from pathlib import Path

import numpy as np

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.report.markup import html

_REPORT_SCRIPTS = ("packed.js", "theme.js", "plots.js", "drawing.js", "readings.js", "page.js")
# Of a column's range: finer than a pixel, far into a zoom.
_DIGITS = 6
_READINGS = (
    *(("t", "time", ""), ("mode", "mode", ""), ("gamma", "tilt", "")),
    *(("K", "N_K", ""), ("B1", "N_B1", ""), ("B2", "N_B2", "")),
    *(("psi", "psi", "slow"), ("phi", "phi", "slow")),
    *(
        ("friction", "friction", "slow"),
        ("risk", "risk", "slow"),
        ("alarms", "alarms", "wide slow"),
    ),
)
_VIEWS = (
    ("side", "From the side, in the plane of the tilt", "peg, rim and forces from the side"),
    ("top", "From above, in the hole's axes", "peg, rim and forces from above"),
)


def library() -> Path:
    """
    Return the script that draws the plots, of the installed package.

    Raises
    ------
    PegOnHoleError
        Plotly is not installed.

    """
    found = find_spec("plotly")
    for folder in (found.submodule_search_locations or []) if found else []:
        path = Path(folder) / "package_data" / "plotly.min.js"
        if path.is_file():
            return path
    raise PegOnHoleError("--report needs plotly: pip install plotly")


def document(title: str, before: list[str], model: dict, after: list[str]) -> str:
    """
    Return a page that loads nothing from elsewhere.

    Parameters
    ----------
    title : str
    before, after : list of str
        HTML above and below the plots.
    model : dict
        What the scripts draw: `panels`, `tables`, `modes`, `alarms`, `end`, `begin`, and `moving`
        with `scene` and `greatest_force` where there is a drawing.

    """
    desk = _desk(model["panels"], "moving" in model)
    return standing_alone(title, [*before, desk, *after], model, _REPORT_SCRIPTS)


def standing_alone(title: str, body: list[str], model: dict, scripts: tuple[str, ...]) -> str:
    """
    Return a page with style, scripts, library, its licences and data within it.

    Parameters
    ----------
    title : str
    body : list of str
        HTML.
    model : dict
        What the scripts draw.
    scripts : tuple of str
        Names in the folder `page`, in their order.

    """
    packed = [
        # As they are: whoever opens the file as text can read them.
        f'<script type="text/plain" id="licences">\n{_read("licences.txt")}</script>',
        f'<script type="text/plain" id="library">{_packed(library().read_bytes())}</script>',
        f'<script type="text/plain" id="data">{_packed(_json(model).encode())}</script>',
    ]
    return bare_page(title, [*body, *packed], scripts)


def bare_page(title: str, body: list[str], scripts: tuple[str, ...]) -> str:
    """Return a page with style and scripts within it; see `standing_alone`."""
    style, *parts = map(_read, ("style.css", *scripts))
    return "\n".join(
        [
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            # Browsers ask for one otherwise.
            '<link rel="icon" href="data:,">',
            f"<title>{html(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>",
            *body,
            # In one scope of their own, apart from the library's names.
            "<script>\n(() => {\n" + "\n".join(parts) + "})();\n</script>\n</body>\n</html>\n",
        ]
    )


def _read(name):
    return (files("peg_on_hole_ros.report") / "page" / name).read_text(encoding="utf-8")


def _desk(panels, moves):
    plots = "\n".join(map(_panel, panels))
    return (
        '<section id="plots">\n<h2>Over time</h2>\n'
        '<p class="waiting">Plots and drawing need JavaScript.</p>\n'
        f'<div class="desk{"" if moves else " plain"}">\n{_stage(moves)}\n'
        f'<div class="plots">\n{plots}\n</div>\n</div>\n</section>'
    )


def _panel(panel):
    kind = " modes" if "bands" in panel else ""
    if kind and panel.get("rows", 1) > 1:
        kind += " two"
    return (
        f'<div class="panel"><h3>{html(panel["title"])}</h3>{_downloads(panel)}\n'
        f'<p class="note">{html(panel["note"])}</p>\n'
        f'<div class="plot{kind}" data-panel="{html(panel["name"])}"></div></div>'
    )


def _downloads(panel):
    buttons = "".join(
        f'<button type="button" data-get="{kind}" data-panel="{html(panel["name"])}" '
        f'aria-label="{html(panel["title"])} as {text}">{text}</button>'
        for kind, text in (("png", "PNG"), ("csv", "CSV"))
    )
    return f'<span class="get">{buttons}</span>'


def views_and_readings() -> str:
    """Return the places of the drawing, and of the numbers beside it."""
    figures = "".join(
        f'<figure><svg id="{name}" role="img" aria-label="{label}"></svg>'
        f"<figcaption>{caption}</figcaption></figure>"
        for name, caption, label in _VIEWS
    )
    rows = "".join(
        f'<div class="{kind}"><dt>{label}</dt><dd data-reading="{name}"></dd></div>'
        for name, label, kind in _READINGS
    )
    return f'<div class="views">{figures}</div><dl class="readings">{rows}</dl>'


def _stage(moves):
    shown = views_and_readings() if moves else ""
    views, _, readings = shown.partition("<dl ")
    readings = f"<dl {readings}" if readings else ""
    speeds = "".join(
        f'<option value="{value}"{" selected" if value == 1 else ""}>{value:g} x</option>'
        for value in (0.05, 0.25, 1, 4, 16)
    )
    return (
        f'<aside class="stage">{views}<div class="controls">'
        '<input id="time" type="range" aria-label="time">'
        '<button type="button" id="play">Play</button>'
        f'<select id="speed" aria-label="pace">{speeds}</select>'
        '<button type="button" id="closer" aria-label="zoom in">+</button>'
        '<button type="button" id="wider" aria-label="zoom out">−</button>'
        f'<button type="button" id="all">All</button></div>{readings}</aside>'
    )


def _packed(data):
    return base64.b64encode(gzip.compress(data, 9, mtime=0)).decode("ascii")


def _json(model):
    return json.dumps(model, default=_column, allow_nan=False, separators=(",", ":"))


def _column(values):
    """Return a column as a list; NaN, which JSON has not, as null."""
    values = np.asarray(values, float)
    known = values[np.isfinite(values)]
    span = float(np.ptp(known)) if len(known) else 0.0
    size = span or float(np.abs(known).max(initial=0.0)) or 1.0
    rounded = np.round(values, min(_DIGITS - floor(log10(size)), 15))
    return [x if x == x and abs(x) != np.inf else None for x in rounded.tolist()]
