"""Errors against computing time, as one picture: the reactions, and the tilt rate."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from peg_on_hole_ros.plots.labels import place_labels
from peg_on_hole_ros.plots.log_axes import write_plain_numbers
from peg_on_hole_ros.study.chart import (
    CYCLE_METHODS,
    CyclePiece,
    Limits,
    Overall,
    front,
    keeps,
)
from peg_on_hole_ros.study.estimators import DEFAULT, ESTIMATORS

# Okabe and Ito's, with a marker for each rate.
_DEFAULT_COLOR, _OTHER_COLOR, _FRONT_COLOR = "#009e73", "#0072b2", "#9a9a9a"
_PART_COLOR = "#cc79a7"
_MARKERS = {1000: "o", 500: "s", 100: "^"}
# Of the whole picture [in], and the panels' places in it.
_WIDE = (9.0, 4.7), ((0.052, 0.21, 0.44, 0.68), (0.55, 0.21, 0.44, 0.68))
_NARROW = (3.9, 8.4), ((0.115, 0.62, 0.86, 0.335), (0.115, 0.19, 0.86, 0.335))
_CHART_DPI = 160
# Panels of kinds beside each other, of each width and height, and below all the legend [in].
_KINDS_WIDE, _KINDS_NARROW = (2, 4.5, 3.1, 0.75), (1, 3.9, 3.3, 1.35)


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
    rows = [row for row in rows if not _drawn(row).part] if narrow else rows
    for place, title, panel in (
        (places[0], "Error of the reactions [% of their mean]", _reactions(rows, limits)),
        (places[1], "Error of the tilt rate [rad/s]", _rates(rows, limits)),
    ):
        axis = fig.add_axes(place)
        axis.set_title(title, loc="left", fontsize=10, weight="bold")
        _draw_panel(axis, panel, _around([panel]))
    _legend(fig, narrow, parts=not narrow)
    return fig


def kinds_figure(found: dict[str, tuple[list[Overall], Limits]], narrow: bool = False) -> Figure:
    """
    Draw the error of the reactions in each kind of scene, on the same axes.

    Parameters
    ----------
    found : dict of str to (list of study.chart.Overall, study.chart.Limits)
        By kind; as for `figure`.
    narrow : bool
        Panels stand above each other.

    """
    columns, width, height, legend = _KINDS_NARROW if narrow else _KINDS_WIDE
    count = -(-len(found) // columns)
    size = (columns * width, count * height + legend)
    fig = Figure(figsize=size, dpi=_CHART_DPI)
    FigureCanvasAgg(fig)
    panels = {kind: _reactions(*one) for kind, one in found.items()}
    around = _around(list(panels.values()))
    for k, (kind, panel) in enumerate(panels.items()):
        row, column = divmod(k, columns)
        axis = fig.add_axes(
            (
                (column * width + 0.42) / size[0],
                1.0 - ((row + 1) * height - 0.45) / size[1],
                (width - 0.5) / size[0],
                (height - 0.8) / size[1],
            )
        )
        axis.set_title(
            f"{kind}: error of the reactions [%]", loc="left", fontsize=9, weight="bold"
        )
        _draw_panel(axis, panel, around)
    _legend(fig, narrow)
    return fig


def cycle_figure(pieces: Sequence[CyclePiece], narrow: bool = False) -> Figure:
    """
    Draw what a step costs along a working cycle.

    Parameters
    ----------
    pieces : sequence of study.chart.CyclePiece
    narrow : bool

    """
    fig = Figure(
        figsize=(3.9, 3.2) if narrow else (9.0, 2.9), dpi=_CHART_DPI, layout="constrained"
    )
    FigureCanvasAgg(fig)
    axis = fig.subplots()
    colors = {CYCLE_METHODS[0]: _DEFAULT_COLOR, CYCLE_METHODS[1]: _OTHER_COLOR}
    own = {name: [piece for piece in pieces if piece.method == name] for name in colors}
    for name, color in colors.items():
        axis.plot(
            [piece.t for piece in own[name]], [piece.step for piece in own[name]], color=color,
            drawstyle="steps-post", label=name, linewidth=1.5,
        )  # fmt: skip
    axis.set_ylim(0.0, 1.6 * max(piece.step for piece in pieces))
    first = own[CYCLE_METHODS[0]]
    changes = [k for k in range(len(first)) if k == 0 or first[k].phase != first[k - 1].phase]
    for k, after in zip(changes, [*changes[1:], len(first)]):
        axis.axvline(first[k].t, color=_FRONT_COLOR, linewidth=0.7, linestyle=":")
        if not narrow:
            axis.text(
                (first[k].t + first[after - 1].t) / 2, 0.99, first[k].phase.replace("_", "\n"),
                transform=axis.get_xaxis_transform(), fontsize=7, ha="center", va="top",
            )  # fmt: skip
    axis.set_xlabel("time [s]", fontsize=8.5)
    axis.set_ylabel("step of a wrench [µs]", fontsize=8.5)
    axis.tick_params(labelsize=8)
    axis.legend(loc="upper right", bbox_to_anchor=(1.0, 0.8), fontsize=8, frameon=False)
    return fig


class _Panel(NamedTuple):
    # Rows that are drawn, their errors and what these are between over the seeds; the bound on
    # errors, and the cost of the whole path.
    rows: list[Overall]
    errors: list[float]
    spread: list[tuple[float, float]]
    bound: float
    whole: float


def _reactions(rows, limits):
    shown = [row for row in rows if _drawn(row).shown and np.isfinite(row.reactions)]
    spread = [(100 * row.reactions_low, 100 * row.reactions_high) for row in shown]
    return _Panel(
        shown, [100 * row.reactions for row in shown], spread, 100 * limits.reactions, limits.whole
    )


def _rates(rows, limits):
    shown = [row for row in rows if _drawn(row).shown and np.isfinite(row.tilt_rate)]
    errors = [row.tilt_rate for row in shown]
    return _Panel(shown, errors, [(e, e) for e in errors], limits.tilt_rate, limits.whole)


_BY_NAME = {str(one): one for one in ESTIMATORS}


def _drawn(row):
    return _BY_NAME[row.name]


def _around(panels):
    """Return the limits of axes that hold all panels: of x, of y."""
    cost = [row.per_ms() for panel in panels for row in panel.rows]
    cost += [panel.whole for panel in panels]
    error = [one for panel in panels for one in (*panel.errors, panel.bound)]
    return (
        (np.nanmin(cost) / 1.5, np.nanmax(cost) * 2.6),
        (np.nanmin(error) / 1.5, np.nanmax(error) * 1.8),
    )


def _legend(fig, narrow, parts=True):
    part = Line2D(
        [], [], color=_PART_COLOR, marker="D", markersize=4, linestyle="",
        label="default with a part left out",
    )  # fmt: skip
    marks = [
        Line2D(
            [], [], color=_DEFAULT_COLOR, marker="o", linestyle="", markersize=8, label="default"
        ),
        Line2D(
            [], [], color=_OTHER_COLOR, marker="o", linestyle="", label="other methods, at 1 kHz"
        ),
        Line2D(
            [], [], color=_OTHER_COLOR, marker="o", linestyle="", markerfacecolor="white",
            label="hollow: bounds too narrow, or little is determined",
        ),
        *([part] if parts else []),
        Line2D([], [], color=_FRONT_COLOR, linewidth=2, label="front: none is cheaper and better"),
        Line2D([], [], color="black", linewidth=1, linestyle="--", label="bound at 1 kHz"),
        Line2D([], [], color="black", linewidth=1, linestyle=":", label="whole path at 1 kHz"),
    ]  # fmt: skip
    fig.legend(
        handles=marks, loc="lower center", ncols=1 if narrow else 3, fontsize=8,
        frameon=False, handletextpad=0.4, columnspacing=1.2, borderpad=0.0,
    )  # fmt: skip


def _draw_panel(axis, panel, around):
    marks = [_drawn(row) for row in panel.rows]
    cost, error = np.array([row.per_ms() for row in panel.rows]), np.array(panel.errors)
    sure = [k for k, row in enumerate(panel.rows) if keeps(row)]
    axis.set(xscale="log", yscale="log", xlim=around[0], ylim=around[1])
    kept = [sure[k] for k in front(cost[sure], error[sure])]
    axis.step(cost[kept], error[kept], where="post", color=_FRONT_COLOR, linewidth=2, zorder=1)
    steps = list(zip(kept, kept[1:]))
    for k, one in enumerate(marks):
        default = one.name == DEFAULT.name
        color = _DEFAULT_COLOR if default else _PART_COLOR if one.part else _OTHER_COLOR
        axis.vlines(cost[k], *panel.spread[k], color=color, linewidth=1, alpha=0.5, zorder=2)
        axis.plot(
            cost[k], error[k], "D" if one.part else _MARKERS[one.rate], color=color, zorder=3,
            markersize=10 if one == DEFAULT else 7 if default else 4 if one.part else 6,
            markerfacecolor=color if k in sure else "white",
        )  # fmt: skip
    write_plain_numbers(axis)
    axis.set_xlabel("computing time of the steps in a millisecond of motion [µs]", fontsize=8.5)
    _lines(axis, panel.bound, panel.whole)
    axis.get_figure().canvas.draw()
    place_labels(
        axis, list(zip(cost, error)), [_label(one) for one in marks],
        [6.5 if one.part else 8 for one in marks],
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
    if np.isfinite(limit):
        axis.axvline(limit, color="black", linewidth=1, linestyle=":", zorder=1)
