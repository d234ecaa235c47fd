"""The map of estimators as one picture: a panel for each quantity, and for two at a time."""

import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from peg_on_hole_ros.study import edges, map_places
from peg_on_hole_ros.study import stability as study
from peg_on_hole_ros.study.stability import Verdict

# Distinguishable for those who see fewer colours, and in print: Okabe and Ito's.
VERDICT_COLORS = {
    Verdict.HOLDS: "#009e73",
    Verdict.UNDETERMINED: "#8fd0f0",
    Verdict.ERRS: "#f0e442",
    Verdict.DIVERGED: "#d55e00",
    Verdict.NONE: "#e4e4e4",
}
_CODES = {verdict: i for i, verdict in enumerate(Verdict)}
_VERDICT_MAP = ListedColormap([VERDICT_COLORS[verdict] for verdict in Verdict])
_NORM = BoundaryNorm(np.arange(len(Verdict) + 1) - 0.5, len(Verdict))
_MAP_DPI = 160


def figure(found: edges.Found, narrow: bool = False) -> Figure:
    """
    Draw the map.

    Parameters
    ----------
    found : mapping
        As of `cli.stability.found_in`.
    narrow : bool
        Panels stand in one column, as a phone has room for.

    """
    columns = 1 if narrow else 3
    panels = [*map_places.MAP_AXES, *map_places.PAIRS]
    rows = -(-len(panels) // columns)
    fig = Figure(figsize=(3.9, 22.0) if narrow else (9.6, 9.0), dpi=_MAP_DPI)
    grid = fig.subplots(rows, columns, squeeze=False)
    sides = (0.28, 0.066, 0.97, 0.988) if narrow else (0.105, 0.072, 0.99, 0.97)
    fig.subplots_adjust(*sides, wspace=0.12 if narrow else 0.3, hspace=0.5)
    for n, (axis, panel) in enumerate(zip(grid.flat, panels)):
        if isinstance(panel, map_places.Axis):
            _along(axis, found, panel, named=n % columns == 0)
        else:
            _across(axis, found, panel)
    for axis in grid.flat[len(panels) :]:
        axis.set_axis_off()
    patches = [Patch(color=VERDICT_COLORS[verdict], label=verdict.value) for verdict in Verdict]
    fig.legend(
        handles=patches, loc="lower center", ncols=1 if narrow else len(patches), fontsize=8,
        frameon=False, columnspacing=1.2, borderpad=0.0,
    )  # fmt: skip
    return fig


def _along(axis, found, quantity, named):
    """Draw methods over the values of one quantity, and the edges of the default."""
    methods = list(study.COMPARED_METHODS)
    values = [v for v in quantity.values if all((quantity.place(v), m) in found for m in methods)]
    codes = [[_CODES[found[quantity.place(v), m].verdict] for v in values] for m in methods]
    _cells(axis, codes)
    for side in edges.SIDES:
        edge = edges.edge_of(found, quantity, side)
        if edge.last is not None and edge.first is not None:
            at = _place_of((edge.last, edge.first), values)
            axis.plot([at, at], [-0.15, 1.0], color="black", linewidth=1.6, clip_on=False)
    axis.set_yticks(np.arange(len(methods)) + 0.5, methods if named else [], fontsize=7)
    _ticks(axis, quantity, values)


def _across(axis, found, pair):
    """Draw the default over two quantities."""
    name = study.DEFAULT
    across = [v for v in pair.across.values
              if any((pair.place(v, u), name) in found for u in pair.up.values)]  # fmt: skip
    up = [u for u in pair.up.values if (pair.place(across[0], u), name) in found]
    up = up[::-1]
    _cells(axis, [[_CODES[found[pair.place(v, u), name].verdict] for v in across] for u in up])
    axis.set_yticks(np.arange(len(up)) + 0.5, [_bare(pair.up, u) for u in up], fontsize=7)
    _ticks(axis, pair.across, across)
    axis.set_title(f"{name}: {pair.up.label} over", loc="left", fontsize=8, weight="bold", pad=14)
    axis.text(0.0, 1.025, _titled(pair.across), transform=axis.transAxes, fontsize=8,
              weight="bold")  # fmt: skip


def _cells(axis, codes):
    axis.pcolormesh(
        np.array(codes), cmap=_VERDICT_MAP, norm=_NORM, edgecolors="white", linewidth=1.0
    )
    axis.invert_yaxis()
    axis.tick_params(length=0, pad=2)
    for spine in axis.spines.values():
        spine.set_visible(False)


def _ticks(axis, quantity, values):
    texts = [_bare(quantity, value) for value in values]
    axis.set_xticks(np.arange(len(values)) + 0.5, texts, fontsize=6)
    for text, value in zip(axis.get_xticklabels(), values):
        text.set_weight("bold" if value == quantity.usual else "normal")
    axis.set_title(_titled(quantity), loc="left", fontsize=8, weight="bold", pad=4)


def _titled(quantity):
    return f"{quantity.label} [{quantity.unit}]" if quantity.unit else quantity.label


def _bare(quantity, value):
    return quantity.text(value).removesuffix(quantity.unit).strip()


def _place_of(between, values):
    """Return where an edge is among columns: in the logarithm between their middles."""
    low, high = sorted(between)
    x = np.arange(len(values)) + 0.5
    if low <= 0.0 or not np.isfinite(high):
        return float(np.mean([x[values.index(low)], x[values.index(high)]]))
    known = [(float(np.log(v)), at) for v, at in zip(values, x) if v > 0.0 and np.isfinite(v)]
    at_values, columns = np.array(known).T
    return float(np.interp(np.log(np.sqrt(low * high)), at_values, columns))
