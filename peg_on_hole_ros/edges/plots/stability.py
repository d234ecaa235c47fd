"""The map of failure as pictures: a row of panels for each plane, a column for each method."""

import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from peg_on_hole_ros.study.stability import DEFAULT, SOLVED, Map, Verdict

# Told apart by those who see fewer colours, and in print: Okabe and Ito's.
COLORS = {
    Verdict.STABLE: "#0072b2",
    Verdict.STATED: "#8fd0f0",
    Verdict.INACCURATE: "#f0e442",
    Verdict.DIVERGED: "#d55e00",
    Verdict.REFUSED: "#c8c8c8",
}
_CODES = {verdict: i for i, verdict in enumerate(Verdict)}
_SHOWN = ListedColormap([COLORS[verdict] for verdict in Verdict])
_NORM = BoundaryNorm(np.arange(len(Verdict) + 1) - 0.5, len(Verdict))


def figure(maps, methods, found) -> Figure:
    """
    Draw the maps.

    Parameters
    ----------
    maps : sequence of Map
    methods : sequence of str
    found : dict
        (map's name, method) to a table of Verdict by [y, x]; (map's name, "truth") to one of
        Truth.

    """
    fig = Figure(figsize=(1.75 * len(methods) + 1.6, 1.95 * len(maps) + 1.3), dpi=110)
    axes = fig.subplots(len(maps), len(methods), squeeze=False)
    fig.subplots_adjust(0.085, 0.075, 0.99, 0.875, wspace=0.16, hspace=0.62)
    for row, map_ in zip(axes, maps):
        _row(row, map_, methods, found)
    for axis, method in zip(axes[0], methods):
        weight = "bold" if method == DEFAULT else "normal"
        text = method.replace("implicit Euler", "implicit\nEuler").replace("r's p", "r's\np")
        axis.annotate(
            text, (0.5, 1.32), xycoords="axes fraction", ha="center", va="bottom", weight=weight
        )
    patches = [Patch(color=COLORS[verdict], label=verdict.value) for verdict in Verdict]
    nothing = "no motion to follow: gamma0 reached or wedged"
    patches.append(Patch(facecolor="white", edgecolor="black", hatch="////", label=nothing))
    fig.legend(handles=patches, loc="upper center", ncols=len(patches), frameon=False)
    return fig


def _row(axes, map_: Map, methods, found):
    truth = found[map_.name, "truth"]
    shape = truth.shape
    x, y = _edges(map_.x.values(shape[1])), _edges(map_.y.values(shape[0]))
    without = np.array([[t not in SOLVED for t in line] for line in truth])
    for axis, method in zip(axes, methods):
        codes = np.array([[_CODES[v] for v in line] for line in found[map_.name, method]])
        axis.pcolormesh(x, y, codes, cmap=_SHOWN, norm=_NORM, rasterized=True)
        if without.any():
            masked = np.ma.masked_where(~without, without.astype(float))
            axis.pcolor(x, y, masked, cmap=ListedColormap(["none"]), hatch="////", linewidth=0)
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.tick_params(labelsize=7)
        axis.minorticks_off()
        if axis is not axes[0]:
            axis.set_yticklabels([])
    axes[0].set_ylabel(map_.y.label, fontsize=8.5)
    axes[0].set_title(
        f"{map_.title}: {map_.x.label} across, {map_.y.label} up", loc="left", fontsize=9.5
    )


def _edges(centres):
    ratio = np.sqrt(centres[1] / centres[0])
    return np.append(centres / ratio, centres[-1] * ratio)
