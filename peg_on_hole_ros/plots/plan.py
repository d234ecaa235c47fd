"""Loads and margin against tilt, of plain closing and of a plan."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from peg_on_hole_ros.mechanics.planning.load_profile import LoadProfile

# Okabe and Ito's: K, and the more loaded of B1 and B2.
_COLORS = {"K": "#0072b2", "B1, B2": "#d55e00"}


def figure(
    plain: LoadProfile, planned: LoadProfile, gamma0: float, max_normal: Sequence[float]
) -> Figure:
    """
    Draw loads above and the determinant below; plain closing on the left, the plan on the right.

    Parameters
    ----------
    plain, planned : mechanics.planning.load_profile.LoadProfile
    gamma0 : float
        [rad]
    max_normal : sequence of 3 float
        [N]

    """
    fig = Figure(figsize=(11, 7), dpi=110, layout="constrained")
    axes = fig.subplots(2, 2, sharex=True, sharey="row", height_ratios=(2, 1))
    for (loads, margin), profile, title in zip(
        axes.T, (plain, planned), ("closing without turning", "the plan")
    ):
        _loads(loads, profile, max_normal)
        loads.set_title(title)
        _margin(margin, profile)
        margin.set_xlabel("tilt gamma [rad]; the peg closes to the right")
        for axis in (loads, margin):
            axis.axvline(gamma0, color="grey", linewidth=1, linestyle=":")
            axis.grid(alpha=0.25)
    widest = max(plain.gamma.max(), planned.gamma.max())
    axes[0, 0].set_xlim(widest, gamma0 - 0.03 * (widest - gamma0))
    axes[0, 0].set_ylim(0, 1.6 * max(max_normal))
    axes[0, 0].set_ylabel("normal reaction [N]")
    axes[1, 0].set_ylabel("determinant; 0: wedged")
    least, most = (
        min(plain.least.min(), 0),
        max(plain.determinant.max(), planned.determinant.max()),
    )
    axes[1, 0].set_ylim(max(least, -0.5 * most) - 0.1, 1.1 * most)
    axes[0, 1].legend(loc="upper left", fontsize=9)
    axes[1, 1].legend(loc="lower left", fontsize=9)
    return fig


def _loads(axis, profile, max_normal):
    rows = {"K": [0], "B1, B2": [1, 2]}
    # Beyond a wedge no load is known.
    known = np.logical_and.accumulate(profile.normal[0] > 0)
    for name, row in rows.items():
        color = _COLORS[name]
        normal, low, high = (
            values[row].max(axis=0)[known]
            for values in (profile.normal, profile.low, profile.high)
        )
        gamma = profile.gamma[known]
        shown = np.where(normal > 0, normal, np.nan)
        axis.plot(gamma, shown, color=color, label=f"{name}, friction as stated")
        axis.fill_between(
            gamma, low, high, where=low > 0, color=color, alpha=0.2, linewidth=0,
            label=f"{name}, 5 to 95 % of friction",
        )  # fmt: skip
        limit = min(max_normal[k] for k in row)
        axis.axhline(limit, color=color, linestyle="--", linewidth=1, label=f"limit at {name}")
    if not known.all():
        at = profile.gamma[known][-1]
        axis.axvline(at, color="black", linestyle="-.", linewidth=1.5)
        axis.annotate(
            "wedges", (at, 0.97), xycoords=("data", "axes fraction"), xytext=(-5, 0),
            textcoords="offset points", ha="right", va="top",
        )  # fmt: skip


def _margin(axis, profile):
    axis.plot(profile.gamma, profile.determinant, color="black", label="friction as stated")
    axis.plot(
        profile.gamma, profile.least, color="black", linestyle="--", linewidth=1,
        label="95 % of friction coefficients stay above",
    )  # fmt: skip
    axis.axhspan(-1e3, 0, color="#d55e00", alpha=0.15)
