"""Where the equations of three contacts end, and where integrators lose them, as one picture."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from peg_on_hole_ros.study.equation_ends import MOST_FRICTION, Wedging
from peg_on_hole_ros.study.fixed_steps import INTEGRATORS, Steps

_DPI = 160
_COLORS = ("#d55e00", "#0072b2", "#009e73", "#cc79a7")
_HATCHES = ("", "////", "....", "\\\\\\\\")
# From this error on, as a share of an angle's way, the law counts as too smooth.
_TOO_SMOOTH = 0.05


def figure(found: Sequence[Wedging], steps: Sequence[Steps], narrow: bool = False) -> Figure:
    """
    Draw both panels.

    Parameters
    ----------
    found : sequence of Wedging
    steps : sequence of Steps
        Slip scales rising.
    narrow : bool
        Panels stand in one column, as a phone has room for.

    """
    fig = Figure(figsize=(3.9, 6.8) if narrow else (9.6, 3.7), dpi=_DPI, layout="constrained")
    left, right = fig.subplots(2, 1) if narrow else fig.subplots(1, 2)
    _wedging(left, found)
    _steps(right, steps)
    return fig


def _wedging(axis, found):
    for one, color, hatch in zip(found, _COLORS, _HATCHES):
        degrees = np.degrees(one.tilt)
        least = np.where(np.isnan(one.friction), MOST_FRICTION, one.friction)
        if np.isnan(one.friction).all():
            axis.plot([], [], color=color, label=f"{one.motion}: does not wedge")
            continue
        axis.fill_between(
            degrees, least, MOST_FRICTION, facecolor=color, alpha=0.45, hatch=hatch,
            edgecolor=color, linewidth=1.0, label=one.motion,
        )  # fmt: skip
    first, last = np.degrees(found[0].tilt[[0, -1]])
    axis.set_xscale("log")
    axis.set_xlim(first * 0.93, last * 1.07)
    axis.set_ylim(0.0, MOST_FRICTION)
    for at, text, side in ((first, "gamma0", "left"), (last, "horizontal", "right")):
        axis.axvline(at, color="black", linewidth=1.2)
        axis.text(at, 0.02, f" {text} ", ha=side, fontsize=7)
    ticks = [4, 6, 10, 20, 40, 90]
    axis.set_xticks(ticks, [str(tick) for tick in ticks])
    axis.minorticks_off()
    axis.set_title(
        "Where a rigid peg wedges: friction over tilt", loc="left", fontsize=8, weight="bold"
    )
    _labelled(axis, "tilt [degrees]", "friction")
    axis.legend(fontsize=6.5, loc="center right", frameon=False)


def _steps(axis, steps):
    scales = np.array([one.slip_scale for one in steps])
    for name, color, marker in zip(INTEGRATORS, _COLORS, "osD"):
        longest = [one.longest[name] * 1e6 for one in steps]
        axis.plot(scales, longest, color=color, marker=marker, markersize=4, label=name)
    smooth = scales[[one.law_off > _TOO_SMOOTH for one in steps]]
    if len(smooth):
        axis.axvspan(smooth[0], scales[-1] * 1.3, color="#e4e4e4", zorder=0)
        axis.text(
            0.98, 0.03, "grey: friction law too smooth,\nerror of an angle above 5 %",
            transform=axis.transAxes, ha="right", fontsize=6.5,
        )  # fmt: skip
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_xlim(scales[0] / 1.3, scales[-1] * 1.3)
    axis.set_ylim(8.0, 2500.0)
    axis.set_title(
        "Longest step with less than 1 % error", loc="left", fontsize=8, weight="bold"
    )  # fmt: skip
    _labelled(axis, "slip scale of the friction law [m/s]", "step [us]")
    axis.legend(fontsize=6.5, loc="upper left", frameon=False)


def _labelled(axis, across, up):
    axis.set_xlabel(across, fontsize=7)
    axis.set_ylabel(up, fontsize=7)
    axis.tick_params(labelsize=7)
    axis.grid(color="#dddddd", linewidth=0.6)
    axis.set_axisbelow(True)
