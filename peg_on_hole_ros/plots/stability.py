"""The map of estimators as one picture: a panel for each estimator, a row for each quantity."""

import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from peg_on_hole_ros.study import stability as study
from peg_on_hole_ros.study.stability import Verdict

# Told apart by those who see fewer colours, and in print: Okabe and Ito's.
VERDICT_COLORS = {
    Verdict.HOLDS: "#009e73",
    Verdict.UNTOLD: "#8fd0f0",
    Verdict.ERRS: "#f0e442",
    Verdict.DIVERGED: "#d55e00",
    Verdict.NONE: "#e4e4e4",
}
_CODES = {verdict: i for i, verdict in enumerate(Verdict)}
_VERDICT_MAP = ListedColormap([VERDICT_COLORS[verdict] for verdict in Verdict])
_NORM = BoundaryNorm(np.arange(len(Verdict) + 1) - 0.5, len(Verdict))
_MAP_DPI = 160


def figure(found: dict, narrow: bool = False) -> Figure:
    """
    Draw the map.

    Parameters
    ----------
    found : dict
        Name of an axis to its places, each a list of study.stability.Result.
    narrow : bool
        Panels stand in one column, as a phone has room for.

    """
    columns = 1 if narrow else 3
    rows = -(-len(study.COMPARED_METHODS) // columns)
    fig = Figure(figsize=(3.9, 9.6) if narrow else (9.0, 4.6), dpi=_MAP_DPI)
    axes = fig.subplots(rows, columns, squeeze=False)
    edges = (0.42, 0.125, 0.98, 0.965) if narrow else (0.18, 0.16, 0.99, 0.92)
    fig.subplots_adjust(*edges, wspace=0.06, hspace=0.28 if narrow else 0.3)
    quantities = [quantity for quantity in study.MAP_AXES if quantity.name in found]
    for n, (axis, name) in enumerate(zip(axes.flat, study.COMPARED_METHODS)):
        verdicts = [[place[n].verdict for place in found[q.name]] for q in quantities]
        _panel(axis, verdicts, [q.label for q in quantities] if n % columns == 0 else [])
        axis.set_title(name, loc="left", fontsize=8.5, weight="bold", pad=4)
        axis.set_title(_held_count(verdicts), loc="right", fontsize=8, pad=4)
        if n >= len(study.COMPARED_METHODS) - columns:
            axis.set_xlabel("low  →  high", fontsize=8)
    for axis in axes.flat[len(study.COMPARED_METHODS) :]:
        axis.set_axis_off()
    patches = [Patch(color=VERDICT_COLORS[verdict], label=verdict.value) for verdict in Verdict]
    fig.legend(
        handles=patches, loc="lower center", ncols=1 if narrow else len(patches), fontsize=8,
        frameon=False, columnspacing=1.2, borderpad=0.0,
    )  # fmt: skip
    return fig


def _panel(axis, verdicts, labels):
    codes = np.array([[_CODES[verdict] for verdict in row] for row in verdicts])
    axis.pcolormesh(codes, cmap=_VERDICT_MAP, norm=_NORM, edgecolors="white", linewidth=1.0)
    axis.invert_yaxis()
    axis.set_xticks([])
    axis.set_yticks(np.arange(len(labels)) + 0.5, labels, fontsize=8)
    axis.tick_params(axis="y", length=0)


def _held_count(verdicts):
    known = [verdict for row in verdicts for verdict in row if verdict is not Verdict.NONE]
    return f"{known.count(Verdict.HOLDS)} of {len(known)}"
