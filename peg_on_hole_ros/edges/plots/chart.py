"""Speed against accuracy as pictures: integrators, filters, implementations."""

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

from peg_on_hole_ros.edges.plots.labels import place_labels
from peg_on_hole_ros.study import filtering, implementations
from peg_on_hole_ros.study.front import front

# Okabe and Ito's colours, with markers of their own.
STYLES = {
    "explicit Euler": ("#e69f00", "^"),
    "semi-implicit Euler": ("#a6761d", "v"),
    "RK4": ("#d55e00", "D"),
    "linearly implicit Euler": ("#cc79a7", "s"),
    "ROS2": ("#56b4e9", "p"),
    "ROS3P": ("#0072b2", "h"),
    "implicit Euler": ("#7fceb9", "o"),
    "implicit Euler, halved": ("#009e73", "o"),
    "Radau": ("#000000", "x"),
    "LSODA": ("#666666", "+"),
    "DOP853": ("#999999", "1"),
}
DEFAULT_INTEGRATOR = ("implicit Euler, halved", 1e-3)


def _figure(size):
    fig = Figure(figsize=size, dpi=110)
    FigureCanvasAgg(fig)
    return fig


def integrators(predictions, bound: float | None, c_microseconds: float | None) -> Figure:
    """
    Draw error against cost of predictions of 20 ms.

    Parameters
    ----------
    predictions : list of study.integration.Prediction
    bound : float or None
        On the size of the rotation error of any estimator [rad]; None: not known.
    c_microseconds : float or None
        A whole filter step as C.

    """
    fig = _figure((13, 9))
    axis = fig.add_axes((0.075, 0.075, 0.86, 0.86))
    shown = [p for p in predictions if np.isfinite(p.error)]
    cost = np.array([p.microseconds for p in shown])
    error = np.array([p.error for p in shown])
    sure = [k for k, p in enumerate(shown) if p.lost == 0]
    on_front = [sure[k] for k in front(cost[sure], error[sure])]
    axis.set(xscale="log", yscale="log", xlim=(cost.min() / 1.6, cost.max() * 2.2))
    axis.set_ylim(min(error.min() / 2, bound / 3 if bound else np.inf), error.max() * 3)
    for name, (color, marker) in STYLES.items():
        own = [k for k, p in enumerate(shown) if p.method == name]
        if not own:
            continue
        axis.plot(cost[own], error[own], color=color, linewidth=0.8, alpha=0.5)
        for k in own:
            face = color if shown[k].lost == 0 or marker in "x+1" else "white"
            axis.plot(cost[k], error[k], marker, color=color, markerfacecolor=face, markersize=7)
        axis.plot([], [], marker, color=color, label=name)
    axis.plot(
        [],
        [],
        "o",
        color="grey",
        markerfacecolor="white",
        label="some predictions lost (count as 0.1 rad)",
    )
    axis.step(
        cost[on_front], error[on_front], where="post", color="black", linewidth=2.2, alpha=0.35,
        label="Pareto front, nothing lost",
    )  # fmt: skip
    if bound:
        _line(axis, "h", bound, "Cramér–Rao bound on the orientation of any estimator")
        right = axis.secondary_yaxis("right", functions=(lambda e: e / bound, lambda r: r * bound))
        right.set_ylabel("over the bound")
    if c_microseconds:
        _line(axis, "v", c_microseconds, "a whole filter step as C, at 1 kHz")
    axis.set_xlabel("computing time for a millisecond of motion [µs] (at steps of 1 ms: per step)")
    axis.set_ylabel("rotation error after 20 ms, r.m.s. [rad]")
    axis.set_title(
        "Integrators; numbers are steps in ms, or relative tolerances of the yardsticks"
    )
    axis.grid(alpha=0.25)
    axis.legend(loc="lower left", ncols=2, fontsize=9, framealpha=1)
    texts, weights = [], []
    for k, p in enumerate(shown):
        default = (p.method, p.setting) == DEFAULT_INTEGRATOR
        number = f"{p.setting:g}" if p.method in ("Radau", "LSODA", "DOP853") else None
        number = number or f"{1e3 * p.setting:g}"
        texts.append(f"default: {number}" if default else number)
        weights.append("bold" if k in on_front or default else "normal")
        if default:
            axis.plot(cost[k], error[k], "o", color="black", markerfacecolor="none", markersize=15)
    colors = [STYLES[p.method][0] for p in shown]
    fig.canvas.draw()
    radii = [8.0 if text.startswith("default") else 3.0 for text in texts]
    points = list(zip(cost, error))
    place_labels(fig, axis, points, texts, [7.5] * len(texts), weights, colors, radii)
    return fig


def _cost_axes(axis):
    axis.grid(alpha=0.25)
    for side in (axis.xaxis, axis.yaxis):
        side.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        side.set_major_formatter(FormatStrFormatter("%g"))
        side.set_minor_formatter(NullFormatter())


def filters(overall, c_microseconds: float | None) -> Figure:
    """
    Draw the errors of filter variants over the bound against their cost.

    Parameters
    ----------
    overall : list of study.front.Overall
    c_microseconds : float or None
        A whole filter step as C.

    """
    fig = _figure((14, 7))
    panels = (
        (fig.add_axes((0.065, 0.09, 0.42, 0.84)), "state", "angles and rates"),
        (fig.add_axes((0.565, 0.09, 0.42, 0.84)), "reaction", "normal reactions"),
    )
    for axis, name, title in panels:
        shown = [s for s in overall if np.isfinite(getattr(s, f"{name}_ratio"))]
        cost = np.array([s.microseconds for s in shown])
        ratio, low, high = (
            np.array([getattr(s, f"{name}_{part}") for s in shown])
            for part in ("ratio", "low", "high")
        )
        axis.set(xscale="log", yscale="log")
        axis.set_xlim(min(cost.min(), c_microseconds or np.inf) / 1.7, cost.max() * 2.4)
        axis.set_ylim(min(0.6, low.min() / 1.4), high.max() * 1.6)
        away = [ratio - low, high - ratio]
        axis.errorbar(cost, ratio, away, fmt="none", ecolor="#888888", capsize=3)
        on_front = front(cost, ratio)
        axis.step(cost[on_front], ratio[on_front], where="post", color="black", linewidth=2.2,
                  alpha=0.35, label="Pareto front")  # fmt: skip
        for k, s in enumerate(shown):
            default = s.name == filtering.DEFAULT
            axis.plot(cost[k], ratio[k], "o", color="#009e73" if default else "#0072b2",
                      markersize=13 if default else 7,
                      markerfacecolor="white" if s.lost else None)  # fmt: skip
        _line(axis, "h", 1.0, "Cramér–Rao bound")
        if c_microseconds:
            _line(axis, "v", c_microseconds, "a step as C")
        axis.set_xlabel("computing time for a millisecond of motion, called from Python [µs]")
        axis.set_ylabel("error over the bound, r.m.s.: median of the motions; bars: half of them")
        axis.set_title(title)
        axis.legend(loc="upper right", fontsize=9)
        _cost_axes(axis)
        fig.canvas.draw()
        defaults = [s.name == filtering.DEFAULT for s in shown]
        place_labels(
            fig, axis, list(zip(cost, ratio)), [_named(s) for s in shown], [9] * len(shown),
            ["bold" if default else "normal" for default in defaults],
            radii=[7.0 if default else 4.0 for default in defaults],
            bars=list(zip(cost, low, high)),
        )  # fmt: skip
    return fig


# Of the variants of a filter, in turn: colour-blind safe, and each with a marker of its own.
_COLORS = ("#0072b2", "#d55e00", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#a6761d")
_MARKERS = ("s", "^", "v", "D", "P", "X", "<", ">", "p", "h", "*", "d")


def _styles(names):
    styles = {filtering.DEFAULT: ("#009e73", "o")}
    others = [name for name in names if name != filtering.DEFAULT]
    for k, name in enumerate(others):
        styles[name] = _COLORS[k % len(_COLORS)], _MARKERS[k % len(_MARKERS)]
    return styles


def fronts(scores, found) -> Figure:
    """
    Draw the reactions' error against cost in each motion, the front, and where the default is.

    Parameters
    ----------
    scores : list of study.filtering.Score
    found : list of study.front.Standing

    """
    columns = 4
    rows = -(-len(found) // columns)
    fig = _figure((16, 3.7 * rows + 1.6))
    names = dict.fromkeys(s.name for s in scores if np.isfinite(s.reaction_error))
    styles = _styles(names)
    for n, standing in enumerate(found):
        axis = fig.add_subplot(rows, columns, n + 1)
        shown = [s for s in scores if s.case == standing.case and np.isfinite(s.reaction_error)]
        cost = np.array([s.microseconds for s in shown])
        error, low, high = (
            100 * np.array([getattr(s, f"reaction_error{part}") for s in shown])
            for part in ("", "_low", "_high")
        )
        axis.set(xscale="log", yscale="log")
        axis.set_title(
            standing.case if standing.on_front else f"{standing.case}: beaten by {standing.by}",
            fontsize=10,
        )
        axis.set_xlim(cost.min() / 1.6, cost.max() * 1.6)
        axis.set_ylim(low.min() / 1.6, high.max() * 1.6)
        axis.errorbar(cost, error, [error - low, high - error], fmt="none", ecolor="#bbbbbb")
        competing = [k for k, s in enumerate(shown) if s.name in standing.competing]
        kept = [competing[k] for k in front(cost[competing], error[competing])]
        axis.step(cost[kept], error[kept], where="post", color="black", linewidth=2.2, alpha=0.35)
        for k, s in enumerate(shown):
            default = s.name == filtering.DEFAULT
            color, marker = styles[s.name]
            axis.plot(
                cost[k], error[k], marker, color=color, markersize=13 if default else 6,
                zorder=2 if default else 3,
                markerfacecolor=color if k in competing else "white",
            )  # fmt: skip
        _cost_axes(axis)
        axis.xaxis.set_major_locator(LogLocator(subs=(1.0,)))
        if n % columns == 0:
            axis.set_ylabel("reactions' r.m.s. error [% of mean]")
        if n >= len(found) - columns:
            axis.set_xlabel("µs for a millisecond of motion")
    marks = [
        Line2D([], [], color=color, marker=marker, linestyle="", label=name)
        for name, (color, marker) in styles.items()
    ]
    fig.suptitle("Filters in each motion; hollow: does not compete; line: Pareto front", y=0.995)
    fig.tight_layout(rect=(0, 0.9 / fig.get_figheight(), 1, 1))
    fig.legend(handles=marks, loc="lower center", ncols=6, fontsize=9)
    return fig


def _named(score):
    lost = f" ({100 * score.lost:.0f} % lost)" if score.lost else ""
    return score.name + lost


def costs(found, why_no_c: str) -> Figure:
    """Draw what a step costs in each implementation."""
    fig = _figure((11, 0.6 * len(found) + 1.6))
    axis = fig.add_axes((0.25, 0.2, 0.72, 0.66))
    values = [cost.microseconds for cost in found]
    names = [cost.name for cost in found]
    colors = ["#009e73" if name == implementations.DEFAULT else "#0072b2" for name in names]
    axis.barh(range(len(found)), values, color=colors, height=0.6)
    axis.set(xscale="log", xlim=(min(values) / 2, max(values) * 40))
    axis.set_yticks(range(len(found)), names)
    axis.invert_yaxis()
    for k, cost in enumerate(found):
        times = f", {_short(cost.over_c)} times C" if np.isfinite(cost.over_c) else ""
        text, place = f"{_short(cost.microseconds)} µs{times}", (cost.microseconds, k)
        axis.annotate(text, place, xytext=(5, 0), textcoords="offset points", va="center")
    limit = next((c.microseconds for c in found if c.name == implementations.C), None)
    if limit:
        axis.axvline(limit, color="black", linewidth=1, linestyle="--")
    axis.set_title("One step: wrench, prediction, correction, reactions" + why_no_c)
    axis.set_xlabel("computing time [µs]")
    return fig


def _short(value):
    """Return three digits, or all before the point."""
    return f"{value:.3g}" if value < 1000 else f"{value:,.0f}"


def _line(axis, way, value, text):
    draw = axis.axhline if way == "h" else axis.axvline
    draw(value, color="black", linewidth=1, linestyle="--" if way == "h" else ":", label=text)
