"""The map of estimators as one picture: a panel for each quantity, a row for each estimator."""

import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from peg_on_hole_ros.study.stability import AXES, METHODS, Verdict

# Told apart by those who see fewer colours, and in print: Okabe and Ito's.
COLORS = {
    Verdict.HOLDS: "#009e73",
    Verdict.UNTOLD: "#8fd0f0",
    Verdict.ERRS: "#f0e442",
    Verdict.DIVERGED: "#d55e00",
    Verdict.NONE: "#e4e4e4",
}
_CODES = {verdict: i for i, verdict in enumerate(Verdict)}
_SHOWN = ListedColormap([COLORS[verdict] for verdict in Verdict])
_NORM = BoundaryNorm(np.arange(len(Verdict) + 1) - 0.5, len(Verdict))


def figure(found: dict) -> Figure:
    """
    Draw the map.

    Parameters
    ----------
    found : dict
        Name of an axis to (values along it, list of list of study.stability.Result by place).

    """
    fig = Figure(figsize=(12.5, 5.4), dpi=110)
    axes = fig.subplots(2, 3, squeeze=False)
    fig.subplots_adjust(0.115, 0.19, 0.99, 0.95, wspace=0.06, hspace=0.5)
    for n, (axis, quantity) in enumerate(zip(axes.flat, AXES)):
        values, results = found[quantity.name]
        codes = np.array([[_CODES[r.verdict] for r in place] for place in results]).T
        axis.pcolormesh(
            np.arange(len(values) + 1), np.arange(len(METHODS) + 1), codes, cmap=_SHOWN,
            norm=_NORM, edgecolors="white", linewidth=1.0,
        )  # fmt: skip
        for column, place in enumerate(results):
            for row, result in enumerate(place):
                if np.isfinite(result.reactions) and result.reactions < 10:
                    axis.text(
                        column + 0.5, row + 0.5, _percent(result.reactions),
                        ha="center", va="center", fontsize=7.5,
                    )  # fmt: skip
        axis.invert_yaxis()
        names = list(METHODS) if n % 3 == 0 else [""] * len(METHODS)
        axis.set_yticks(np.arange(len(METHODS)) + 0.5, names)
        axis.tick_params(axis="y", length=0)
        axis.set_xticks(
            np.arange(len(values)) + 0.5,
            [f"{float(f'{value:.2g}'):g}" for value in values],
            fontsize=8,
        )
        axis.set_xlabel(quantity.label, fontsize=9.5)
    patches = [Patch(color=COLORS[verdict], label=verdict.value) for verdict in Verdict]
    fig.legend(handles=patches, loc="lower center", ncols=len(patches), frameon=False)
    fig.text(0.5, 0.065, "numbers: error of the reactions, % of their mean", ha="center")
    return fig


def _percent(share):
    return f"{100 * share:.2g}" if share < 0.1 else f"{100 * share:.0f}"
