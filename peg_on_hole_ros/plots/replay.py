"""One picture of a run: angles, reactions with bounds, contact mode, flag and risk over time."""

from io import BytesIO

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from peg_on_hole_ros.bags.truth import BOUND_STDDEVS, RecordedTruth
from peg_on_hole_ros.plots.gaps import with_gaps
from peg_on_hole_ros.plots.series import MONITORED, Series
from peg_on_hole_ros.plots.turns import turn_stddev
from peg_on_hole_ros.records import SIX_QUANTITIES

TRACE_COLORS = ("#1b6ca8", "#c2571a", "#2e7d32")
MODE_COLORS = {
    "three_point": "#2e7d32",
    "two_point": "#c2571a",
    "inserted": "#1b6ca8",
    "open": "#9e9e9e",
    "elsewhere": "#b39ddb",
    "unknown": "#e0e0e0",
}
# Broad and pale, below the lines of the estimate.
TRUTH = {"color": "#9aa3ad", "linewidth": 3.0, "alpha": 0.6, "zorder": 1.5}


def figure(
    series: Series, title: str, gamma0: float, truth: RecordedTruth | None = None
) -> Figure:
    """
    Draw a run.

    Parameters
    ----------
    series : Series
        At least one estimate.
    title : str
    gamma0 : float
        Tilt at which three-point contact ends [rad].
    truth : RecordedTruth, optional
        Drawn as a broad line below.

    """
    passed_ns, values, stddev, monitor = series.arrays()
    columns = {"t": passed_ns * 1e-9, "values": values, "stddev": stddev, "monitor": monitor}
    t, values, stddev, monitor = with_gaps(columns).values()
    fig = Figure(figsize=(11, 12), dpi=110, layout="constrained")
    axes = fig.subplots(5, 1, sharex=True, height_ratios=(3, 3, 4, 1.2, 2.4))
    fig.suptitle(title)
    _gamma(axes[0], t, values, stddev, gamma0)
    _turns(axes[1], t, values, stddev)
    _reactions(axes[2], t, values, stddev, monitor)
    if truth is not None:
        _draw_truth(axes, t, series.runs, truth)
    _modes(axes[3], series, truth)
    _risk(axes[4], t, monitor, series)
    axes[4].set_xlabel("time [s]")
    axes[4].set_xlim(0, max(t[-1], 1e-3))
    return fig


def png(fig: Figure) -> bytes:
    """Return the picture as PNG."""
    stream = BytesIO()
    fig.savefig(stream, format="png")
    return stream.getvalue()


def _band(axis, t, values, stddev, i, color, sure=True):
    label = SIX_QUANTITIES[i] if i < 3 else f"N_{SIX_QUANTITIES[i]}"
    value, bound = values[:, i], BOUND_STDDEVS * stddev[:, i]
    axis.fill_between(t, value - bound, value + bound, color=color, alpha=0.25, linewidth=0)
    axis.plot(t, np.where(sure, value, np.nan), color=color, linewidth=1.0, label=label)


def _gamma(axis, t, values, stddev, gamma0):
    _band(axis, t, values, stddev, 0, TRACE_COLORS[0])
    axis.axhline(gamma0, color="grey", linewidth=0.8, label="gamma0")
    axis.set_ylabel("tilt [rad]")
    axis.legend(loc="upper right", ncols=3)


def _turns(axis, t, values, stddev):
    turned = values.copy()
    for i in (1, 2):
        there = np.isfinite(values[:, i])
        turned[there, i] = np.unwrap(values[there, i])
        known = np.isfinite([turn_stddev(spread) for spread in stddev[:, i].tolist()])
        turned[~known, i] = np.nan
        _band(axis, t, turned, stddev, i, TRACE_COLORS[i])
    axis.set_ylabel("turns [rad]\nno line: not determined")
    axis.legend(loc="upper left", ncols=3)


def _reactions(axis, t, values, stddev, monitor):
    # Where forces do not determine them the bounds are all that is said of them.
    undetermined = monitor[:, MONITORED.index("reactions_determined")] == 0.0
    sure = ~(undetermined & (stddev[:, 3:] > 0.0).any(axis=1))
    for i in (3, 4, 5):
        _band(axis, t, values, stddev, i, TRACE_COLORS[i - 3], sure)
    # Near wedging bounds have no limit; the picture is for what is known.
    told = values[np.isfinite(values[:, 3:]).all(axis=1), 3:]
    top = 1.3 * max(float(np.percentile(told, 99.5)) if told.size else 0.0, 1.0)
    axis.set_ylim(-0.1 * top, top)
    axis.set_ylabel("normal reactions [N]\nwith 95 % bounds;\nno line: not determined")
    axis.legend(loc="upper left", ncols=4)


def _draw_truth(axes, t, runs, truth):
    label = "truth"
    for run in runs:
        inside = (run.first_ns <= truth.t_ns) & (truth.t_ns <= run.last_ns)
        if not inside.any():
            continue
        at, values = run.passed(truth.t_ns[inside]) * 1e-9, truth.values[inside]
        shown = slice(None, None, max(1, len(at) // 8000))
        axes[0].plot(at[shown], values[shown, 0], label=label, **TRUTH)
        # The estimate wraps: its first turn may be another than the truth's.
        row = max(0, int(np.searchsorted(t, at[0], side="right")) - 1)
        for i in (1, 2):
            drawn = axes[1].lines[i - 1].get_ydata()
            known = np.flatnonzero(np.isfinite(drawn))
            if not len(known):
                continue
            row = int(known[np.argmin(np.abs(known - row))])
            estimated = drawn[row]
            turns = (
                2 * np.pi * np.round((estimated - np.interp(t[row], at, values[:, i])) / 2 / np.pi)
            )
            named = label if i == 1 else None
            axes[1].plot(at[shown], values[shown, i] + turns, label=named, **TRUTH)
        for i in (3, 4, 5):
            named = label if i == 3 else None
            axes[2].plot(at[shown], values[shown, i], label=named, **TRUTH)
        label = None
    for axis in axes[:3]:
        axis.legend(loc=axis.get_legend()._loc, ncols=4)


def _modes(axis, series, truth):
    rows = [("estimate", series.modes)]
    if truth is not None:
        rows.insert(0, ("truth", truth.mode_changes(series.runs)))
    for y, (_, changes) in enumerate(rows):
        ends = [t for t, _ in changes[1:]] + [series.passed_ns]
        for (begin, mode), end in zip(changes, ends):
            bar = [(begin * 1e-9, (end - begin) * 1e-9)]
            axis.broken_barh(bar, (y - 0.4, 0.8), color=MODE_COLORS.get(mode, "#ffffff"))
    axis.set_yticks(range(len(rows)), [name for name, _ in rows])
    axis.set_ylabel("contact mode")
    patches = [Patch(color=color, label=mode) for mode, color in MODE_COLORS.items()]
    axis.legend(handles=patches, loc="upper left", ncols=4, fontsize="small")
    axis.set_ylim(-0.5, len(rows) + 0.3)


def _risk(axis, t, monitor, series):
    styles = {"jamming_risk": "#b71c1c", "transition_probability": "#1b6ca8"}
    for name, color in styles.items():
        axis.plot(t, monitor[:, MONITORED.index(name)], color=color, linewidth=1.0, label=name)
    flags = [*series.flags, (series.passed_ns, series.flags[-1][1])] if series.flags else []
    if flags:
        steps = [when * 1e-9 for when, _ in flags], [float(flag) for _, flag in flags]
        axis.fill_between(
            *steps, step="post", color="#c2571a", alpha=0.2, linewidth=0, label="transition flag"
        )
    axis.set_ylim(-0.05, 1.05)
    axis.set_ylabel("probability, risk")
    axis.legend(loc="upper left", ncols=3)
