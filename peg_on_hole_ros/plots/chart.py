"""Errors against what a wrench costs, as one picture: the reactions, and the tilt's rate."""

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

from peg_on_hole_ros.plots.labels import place_labels
from peg_on_hole_ros.study.chart import (
    DEFAULT,
    ESTIMATORS,
    LEAST_DETERMINED,
    OVERCONFIDENT_COVERAGE,
    Limits,
    Overall,
    front,
)

# Okabe and Ito's, with a marker for each rate.
_DEFAULT_COLOR, _OTHER_COLOR, _FRONT_COLOR = "#009e73", "#0072b2", "#9a9a9a"
_MARKERS = {1000: "o", 500: "s", 100: "^"}
# Of the whole picture [in], and the panels' places in it.
_WIDE = (9.0, 4.7), ((0.052, 0.21, 0.44, 0.68), (0.55, 0.21, 0.44, 0.68))
_NARROW = (3.9, 8.2), ((0.115, 0.605, 0.86, 0.345), (0.115, 0.165, 0.86, 0.345))
_CHART_DPI = 160


def figure(rows: list[Overall], limits: Limits, narrow: bool = False) -> Figure:
    """
    Draw the chart.

    Parameters
    ----------
    rows : list of study.chart.Overall
        Those that are no point of the picture are left out.
    limits : study.chart.Limits
        NaN: none is drawn.
    narrow : bool
        Panels stand above each other, as a phone has room for.

    """
    size, places = _NARROW if narrow else _WIDE
    fig = Figure(figsize=size, dpi=_CHART_DPI)
    FigureCanvasAgg(fig)
    drawn = {str(one): one for one in ESTIMATORS if one.shown}
    rows = [row for row in rows if row.name in drawn]
    marks = [drawn[row.name] for row in rows]
    reactions, rates = (
        [getattr(row, name) for row in rows] for name in ("reactions", "tilt_rate")
    )
    for place, title, errors, bound in (
        (places[0], "Error of the reactions [% of their mean]",
         [100 * error for error in reactions], 100 * limits.reactions),
        (places[1], "Error of the tilt's rate [rad/s]", rates, limits.tilt_rate),
    ):  # fmt: skip
        axis = fig.add_axes(place)
        axis.set_title(title, loc="left", fontsize=10, weight="bold")
        _panel(fig, axis, rows, marks, errors, bound, limits.whole)
    _legend(fig, narrow)
    return fig


def _legend(fig, narrow):
    marks = [
        Line2D(
            [], [], color=_DEFAULT_COLOR, marker="o", linestyle="", markersize=8, label="default"
        ),
        Line2D(
            [], [], color=_OTHER_COLOR, marker="o", linestyle="", label="other methods, at 1 kHz"
        ),
        Line2D(
            [], [], color=_OTHER_COLOR, marker="o", linestyle="", markerfacecolor="white",
            label="hollow: its bounds do not hold, or it tells little",
        ),
        Line2D([], [], color=_FRONT_COLOR, linewidth=2, label="front: none is cheaper and better"),
    ]  # fmt: skip
    fig.legend(
        handles=marks, loc="lower center", ncols=1 if narrow else len(marks), fontsize=8,
        frameon=False, handletextpad=0.4, columnspacing=1.2, borderpad=0.0,
    )  # fmt: skip


def _panel(fig, axis, rows, marks, errors, bound, limit):
    known = [k for k, error in enumerate(errors) if np.isfinite(error)]
    rows, marks = [rows[k] for k in known], [marks[k] for k in known]
    cost, error = np.array([row.per_ms() for row in rows]), np.array(errors)[known]
    sure = [k for k, row in enumerate(rows) if _keeps(row)]
    most = np.nanmax([cost.max(), limit])
    axis.set(xscale="log", yscale="log", xlim=(cost.min() / 1.5, most * 2.6))
    axis.set_ylim(np.nanmin([error.min(), bound]) / 1.5, error.max() * 1.8)
    kept = [sure[k] for k in front(cost[sure], error[sure])]
    axis.step(cost[kept], error[kept], where="post", color=_FRONT_COLOR, linewidth=2, zorder=1)
    steps = list(zip(kept, kept[1:]))
    for k, one in enumerate(marks):
        default = one.name == DEFAULT.name
        color = _DEFAULT_COLOR if default else _OTHER_COLOR
        axis.plot(
            cost[k], error[k], _MARKERS[one.rate], color=color, zorder=3,
            markersize=10 if one == DEFAULT else 7 if default else 6,
            markerfacecolor=color if k in sure else "white",
        )  # fmt: skip
    for part in (axis.xaxis, axis.yaxis):
        part.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=12))
        part.set_major_formatter(FormatStrFormatter("%g"))
        part.set_minor_formatter(NullFormatter())
    axis.tick_params(labelsize=8)
    axis.grid(alpha=0.2)
    axis.set_xlabel("computing time of the steps in a millisecond of motion [µs]", fontsize=8.5)
    _lines(axis, bound, limit)
    fig.canvas.draw()
    place_labels(
        axis, list(zip(cost, error)), [_label(one) for one in marks], [8] * len(marks),
        ["bold" if one == DEFAULT else "normal" for one in marks],
        radii=[6.0 if one == DEFAULT else 4.0 for one in marks],
        bars=[(cost[b], error[b], error[a]) for a, b in steps],
        levels=[(error[a], cost[a], cost[b]) for a, b in steps],
    )  # fmt: skip


def _label(one):
    if one.name != DEFAULT.name:
        return one.name
    return str(one) if one == DEFAULT else f"{one.rate} Hz"


def _lines(axis, bound, limit):
    if np.isfinite(bound):
        axis.axhline(bound, color="black", linewidth=1, linestyle="--", zorder=1)
        axis.text(
            0.99, bound, "bound at 1 kHz", transform=axis.get_yaxis_transform(), fontsize=8,
            ha="right", va="bottom",
        )  # fmt: skip
    if np.isfinite(limit):
        axis.axvline(limit, color="black", linewidth=1, linestyle=":", zorder=1)
        axis.text(
            limit, 0.99, " whole path, 1 kHz", transform=axis.get_xaxis_transform(), fontsize=8,
            ha="left", va="top",
        )  # fmt: skip


def _keeps(row):
    """Return whether an estimator's word on its reactions counts."""
    if np.isnan(row.reactions):
        return not row.lost
    sure = row.determined >= LEAST_DETERMINED and row.reactions_inside >= OVERCONFIDENT_COVERAGE
    return bool(sure) and not row.lost
