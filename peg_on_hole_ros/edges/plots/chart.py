"""Errors against what a wrench costs, as one picture: the reactions, and the tilt's rate."""

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

from peg_on_hole_ros.edges.plots.labels import place_labels
from peg_on_hole_ros.study.chart import DEFAULT, LEAST_COVERAGE, LEAST_DETERMINED, front
from peg_on_hole_ros.study.scenes import Least

# Okabe and Ito's, with a marker for each rate.
_DEFAULT, _OTHER, _FRONT = "#009e73", "#0072b2", "#999999"
_MARKERS = (("1 kHz", "o"), ("500 Hz", "s"), ("100 Hz", "^"))


def figure(rows, bound: Least) -> Figure:
    """
    Draw the chart.

    Parameters
    ----------
    rows : list of study.chart.Overall
    bound : study.scenes.Least
        On both errors, of any estimator at 1 kHz; NaN: none is drawn.

    """
    fig = Figure(figsize=(12.5, 5.6), dpi=110)
    FigureCanvasAgg(fig)
    left = fig.add_axes((0.06, 0.2, 0.42, 0.7))
    right = fig.add_axes((0.555, 0.2, 0.42, 0.7))
    _panel(fig, left, rows, [100 * row.reactions for row in rows], 100 * bound.reactions)
    left.set_title("error of the reactions, % of their mean", loc="left", fontsize=11)
    _panel(fig, right, rows, [row.tilt_rate for row in rows], bound.tilt_rate)
    right.set_title("error of the tilt's rate [rad/s]", loc="left", fontsize=11)
    marks = [
        Line2D([], [], color="black", marker=marker, linestyle="", markersize=6, label=rate)
        for rate, marker in _MARKERS
    ]
    marks += [
        Line2D([], [], color=_DEFAULT, marker="o", linestyle="", markersize=9, label="default"),
        Line2D(
            [], [], color=_OTHER, marker="o", linestyle="", markerfacecolor="white",
            label=f"hollow: under {100 * LEAST_COVERAGE:.0f} % within bounds of 95 %, or untold",
        ),
        Line2D([], [], color=_FRONT, linewidth=2, label="front: none is cheaper and better"),
    ]  # fmt: skip
    marks.append(
        Line2D([], [], color="black", linestyle="--", linewidth=1, label="bound at 1 kHz")
    )
    fig.legend(handles=marks, loc="lower center", ncols=len(marks), fontsize=9, frameon=False)
    return fig


def _panel(fig, axis, rows, errors, bound):
    shown = [(row, error) for row, error in zip(rows, errors) if np.isfinite(error)]
    cost = np.array([row.microseconds for row, _ in shown])
    error = np.array([error for _, error in shown])
    sure = [k for k, (row, _) in enumerate(shown) if _keeps(row)]
    axis.set(xscale="log", yscale="log", xlim=(cost.min() / 1.7, cost.max() * 2.4))
    axis.set_ylim(np.nanmin([error.min(), bound]) / 1.6, error.max() * 1.8)
    kept = [sure[k] for k in front(cost[sure], error[sure])]
    axis.step(cost[kept], error[kept], where="post", color=_FRONT, linewidth=2, zorder=1)
    if np.isfinite(bound):
        axis.axhline(bound, color="black", linewidth=1, linestyle="--", zorder=1)
    names = [row.name for row, _ in shown]
    for k, name in enumerate(names):
        color = _DEFAULT if name.startswith(DEFAULT.name) else _OTHER
        marker = next(m for rate, m in _MARKERS if name.endswith(rate))
        axis.plot(
            cost[k], error[k], marker, color=color, zorder=3,
            markersize=12 if name == str(DEFAULT) else 7,
            markerfacecolor=color if k in sure else "white",
        )  # fmt: skip
    for part in (axis.xaxis, axis.yaxis):
        part.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=12))
        part.set_major_formatter(FormatStrFormatter("%g"))
        part.set_minor_formatter(NullFormatter())
    axis.grid(alpha=0.25)
    axis.set_xlabel("computing time for a millisecond of motion [µs], messages to outputs")
    fig.canvas.draw()
    place_labels(
        fig, axis, list(zip(cost, error)), names, [9] * len(names),
        ["bold" if name == str(DEFAULT) else "normal" for name in names],
        radii=[7.0 if name == str(DEFAULT) else 4.0 for name in names],
    )  # fmt: skip


def _keeps(row):
    """Return whether an estimator's word on its reactions counts; a smoother gives none."""
    if np.isnan(row.reactions):
        return not row.lost
    sure = row.determined >= LEAST_DETERMINED and row.reactions_inside >= LEAST_COVERAGE
    return bool(sure) and not row.lost
