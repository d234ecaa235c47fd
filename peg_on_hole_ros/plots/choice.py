"""Error against cost of each method on a cell's own motion, and what is enough."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from peg_on_hole_ros.plots.log_axes import write_plain_numbers
from peg_on_hole_ros.study.choice import Tolerances, Tried

# Okabe and Ito's, the default first.
_METHOD_COLORS = ("#009e73", "#0072b2", "#56b4e9", "#d55e00", "#cc79a7", "#e69f00")
_CHOSEN_COLOR, _LIMIT_COLOR = "black", "#9a9a9a"
_CHOICE_SIZE, _CHOICE_DPI = (9.0, 4.6), 130


def figure(found: Sequence[Tried], chosen: Tried | None, within: Tolerances) -> Figure:
    """
    Draw the error of the reactions and of the tilt's rate against the cost of the whole path.

    Parameters
    ----------
    found : sequence of study.choice.Tried
    chosen : study.choice.Tried or None
    within : study.choice.Tolerances

    """
    fig = Figure(figsize=_CHOICE_SIZE, dpi=_CHOICE_DPI, layout="constrained")
    axes = fig.subplots(1, 2, sharex=True)
    for axis, name, limit, title in zip(
        axes, ("reactions", "tilt_rate"), (within.reactions, within.tilt_rate),
        ("Error of the reactions [%]", "Error of the tilt's rate [%]"),
    ):  # fmt: skip
        _panel(axis, found, name)
        axis.axhline(100 * limit, color=_LIMIT_COLOR, linestyle="--", linewidth=1)
        axis.text(
            0.99, 100 * limit, "asked for", transform=axis.get_yaxis_transform(), ha="right",
            va="bottom", fontsize=8,
        )  # fmt: skip
        if chosen is not None:
            axis.plot(
                chosen.whole, 100 * getattr(chosen, name), "o", markersize=15,
                markerfacecolor="none", color=_CHOSEN_COLOR, label="chosen",
            )  # fmt: skip
        axis.set_title(title, loc="left", fontsize=10, weight="bold")
        axis.set_xlabel("computing time for a millisecond of motion, whole path [µs]", fontsize=9)
    handles, labels = axes[0].get_legend_handles_labels()
    fig.legend(
        handles, [*labels[:-1], labels[-1]], loc="outside lower center", ncols=4, fontsize=8,
        frameon=False,
        title="lower rates to the left; hollow: bounds too narrow, or rarely determined",
        title_fontsize=8,
    )  # fmt: skip
    return fig


def _panel(axis, found, name):
    methods = list(dict.fromkeys(one.method for one in found))
    axis.set(xscale="log", yscale="log")
    for method, color in zip(methods, _METHOD_COLORS):
        own = [one for one in found if one.method == method and getattr(one, name) < 10.0]
        axis.plot(
            [one.whole for one in own], [100 * getattr(one, name) for one in own], color=color,
            linewidth=1, label=method,
        )  # fmt: skip
        for one in own:
            axis.plot(
                one.whole, 100 * getattr(one, name), "o", color=color, markersize=6,
                markerfacecolor=color if one.holds else "white",
            )  # fmt: skip
            if method == methods[0]:
                axis.annotate(
                    f"{one.rate:g} Hz", (one.whole, 100 * getattr(one, name)), fontsize=7,
                    xytext=(0, -11), textcoords="offset points", ha="center",
                )  # fmt: skip
    write_plain_numbers(axis)
