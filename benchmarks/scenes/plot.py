"""Pictures of the scenes' scores; colours that the colour-blind tell apart (Okabe and Ito)."""

from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from benchmarks.harness.events import LEVELS  # noqa: E402
from benchmarks.harness.player import ALARMS  # noqa: E402
from benchmarks.harness.pooled import ALARM_OF  # noqa: E402
from benchmarks.scenes.tables import WITH_ALARMS  # noqa: E402

COLOURS = {"matched": "#0072B2", "mismatch": "#D55E00", "second_try": "#009E73"}
MARKERS = {"matched": "o", "mismatch": "s", "second_try": "^"}
CAUSE_COLOURS = {
    "wedge": "#0072B2", "stall": "#E69F00", "overload": "#009E73", "contact_loss": "#CC79A7",
}  # fmt: skip


def draw(scores: dict[str, dict], runs: dict[str, list[dict]], folder: Path) -> list[Path]:
    """
    Draw the pictures of a set of runs as PNG and SVG and return their paths.

    Parameters
    ----------
    scores : dict
        {variant: {family: pooled scores}}.
    runs : dict
        {variant: runs}.
    folder : Path

    """
    made = []
    for name, figure in (
        ("transition", _transition(scores, runs)),
        ("alarms", _alarms(scores, runs)),
        ("modes", _modes(scores)),
    ):
        for kind in ("png", "svg"):
            path = folder / f"{name}.{kind}"
            figure.savefig(path, dpi=130, metadata={"Date": None} if kind == "svg" else None)
            made.append(path)
        plt.close(figure)
    return made


def _transition(scores, runs):
    """Return how far off the flag was in each run, and how often the forecast was right."""
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(11, 4.8), layout="constrained", width_ratios=(3, 2)
    )
    families = [f for f in next(iter(scores.values())) if f != "all"]
    shown = [f for f in families if any(s[f]["transitions"] for s in scores.values())]
    for j, (variant, found) in enumerate(runs.items()):
        shift = (j - (len(runs) - 1) / 2) * 0.25
        for i, family in enumerate(shown):
            off = [r["transition"]["error"] for r in found if r["family"] == family]
            off = 1e3 * np.array([x for x in off if x is not None])
            place = i + shift + np.linspace(-0.09, 0.09, max(len(off), 1))[: len(off)]
            left.plot(
                place, np.sort(off), MARKERS[variant], ms=3.5, alpha=0.75,
                color=COLOURS[variant], label=variant if i == 0 else None,
            )  # fmt: skip
    left.axhspan(-5, 5, color="0.85", zorder=0, label="within 5 ms")
    left.set_yscale("symlog", linthresh=5)
    left.set_yticks([-100, -20, -5, 0, 5, 20, 100], ["-100", "-20", "-5", "0", "5", "20", "100"])
    left.set_xticks(range(len(shown)), [f.replace("_", "\n") for f in shown])
    left.set_ylabel("flag after the transition [ms]")
    left.set_title("Transition flag, one point a run (without those missed)")
    left.legend(loc="upper center", ncols=3, bbox_to_anchor=(0.5, -0.12), frameon=False)
    nominal = np.array(LEVELS)
    right.plot([0.4, 1], [0.4, 1], color="0.6", lw=1, label="as stated")
    for variant, found in scores.items():
        parts = [found["all"]["forecast"][str(level)] for level in LEVELS]
        if not parts[0]["count"]:
            continue
        value = np.array([p["value"] for p in parts])
        low, high = (np.array([p[k] for p in parts]) for k in ("low", "high"))
        shift = 0.006 * (list(COLOURS).index(variant) - 1)
        right.errorbar(
            nominal + shift, value, np.maximum([value - low, high - value], 0.0),
            fmt=MARKERS[variant] + "-",
            color=COLOURS[variant], capsize=3, label=f"{variant}, {parts[0]['count']} forecasts",
        )  # fmt: skip
    right.set_xlabel("interval stated")
    right.set_ylabel("share of forecasts inside it")
    right.set_xlim(0.45, 1.0)
    right.set_ylim(0, 1.03)
    right.set_title("Forecast 100 ms ahead")
    right.legend(loc="lower right", frameon=False)
    return figure


def _alarms(scores, runs):
    """Return precision and recall with intervals, and the leads of each cause."""
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(11, 4.8), layout="constrained", width_ratios=(3, 2)
    )
    scores = {name: found for name, found in scores.items() if name in WITH_ALARMS}
    rows = []
    for alarm in ALARMS:
        some = next(iter(scores.values()))["all"]["alarms"][alarm]["error"]
        rows.append((f"{alarm}: precision", alarm, None))
        rows += [(f"{cause}: recall", alarm, cause) for cause in some["causes"]]
    for j, (variant, found) in enumerate(scores.items()):
        for k, (level, fill) in enumerate((("error", "full"), ("warn", "none"))):
            shift = ((2 * j + k) - len(scores) + 0.5) * 0.17
            for i, (_, alarm, cause) in enumerate(rows):
                a = found["all"]["alarms"][alarm][level]
                s = a["precision"] if cause is None else a["causes"][cause]["recall"]
                if not s["count"]:
                    continue
                left.errorbar(
                    s["value"], i + shift,
                    xerr=[[max(0, s["value"] - s["low"])], [max(0, s["high"] - s["value"])]],
                    fmt=MARKERS[variant], fillstyle=fill, color=COLOURS[variant], ms=5,
                    capsize=2, lw=1,
                )  # fmt: skip
            left.plot(
                [], [], MARKERS[variant], fillstyle=fill, color=COLOURS[variant],
                label=f"{variant}, {level.upper()}",
            )  # fmt: skip
    left.axvline(0.95, color="0.6", lw=1, ls=":")
    left.set_yticks(range(len(rows)), [text.replace("_", " ") for text, _, _ in rows])
    left.set_ylim(len(rows) - 0.4, -0.6)
    left.set_xlim(-0.03, 1.03)
    left.set_xlabel("share, with its 95 % interval (dotted: 0.95)")
    left.set_title("Alarms")
    left.legend(loc="upper center", ncols=2, bbox_to_anchor=(0.4, -0.12), frameon=False)
    variant = next(iter(runs))
    for cause, colour in CAUSE_COLOURS.items():
        alarm = ALARM_OF.get(cause, cause)
        for level, style in (("error", "-"), ("warn", ":")):
            events = [e for r in runs[variant] for e in r["alarms"][alarm][level]["events"]]
            leads = [-np.inf if e[1] is None else e[1] for e in events if e[0] == cause]
            if not leads:
                continue
            lead = np.sort(1e3 * np.array(leads))
            ahead = np.arange(-60, 201)
            share = (lead[None, :] >= ahead[:, None]).mean(axis=1)
            label = cause.replace("_", " ") if level == "error" else None
            right.plot(ahead, share, style, color=colour, label=label)
    right.axvline(0, color="0.6", lw=1)
    right.set_xlabel("raised at least so long before [ms]")
    right.set_ylabel("share of events")
    right.set_ylim(-0.03, 1.03)
    right.set_title(f"Lead, {variant} (dotted: WARN)")
    right.legend(loc="upper center", ncols=4, bbox_to_anchor=(0.5, -0.12), frameon=False)
    return figure


def _modes(scores):
    """Return the confusion of modes, and how often what was said to be probable was true."""
    count = len(scores)
    figure, axes = plt.subplots(
        1, count + 1, figsize=(5.0 * (count + 1) + 2.5, 4.4), layout="constrained", squeeze=False
    )
    for axis, (variant, found) in zip(axes[0], scores.items(), strict=False):
        table = found["all"]["confusion"]
        kinds = [kind for kind, row in table.items() if sum(row.values())]
        modes = list(table[kinds[0]])
        share = np.array([[table[k][m] / sum(table[k].values()) for m in modes] for k in kinds])
        axis.imshow(share, cmap="cividis", vmin=0, vmax=1, aspect="auto")
        for i, j in np.ndindex(share.shape):
            colour = "black" if share[i, j] > 0.6 else "white"
            axis.text(j, i, f"{share[i, j]:.2f}", ha="center", va="center", color=colour)
        axis.set_xticks(range(len(modes)), [m.replace("_", "\n") for m in modes])
        axis.set_yticks(range(len(kinds)), [k.replace("_", "\n") for k in kinds])
        axis.set_xlabel("declared")
        axis.set_ylabel("true")
        axis.set_title(f"Share of samples, {variant}")
    axis = axes[0, -1]
    axis.plot([0, 1], [0, 1], color="0.6", lw=1)
    palette = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#000000", "0.5")
    for variant, found in scores.items():
        if variant != next(iter(scores)):
            continue
        for (name, c), colour, marker in zip(
            sorted(found["all"]["calibration"].items()), palette, "osD^vPX*", strict=False
        ):
            points = [(s, t) for s, t in zip(c["said"], c["true"], strict=True) if s is not None]
            label = f"{name.replace('mode_probability_', '')}, error {c['error']:.3f}"
            axis.plot(*np.array(points).T, marker + "-", ms=4, color=colour, label=label)
    axis.set_xlabel("probability stated")
    axis.set_ylabel("share of samples where it was true")
    axis.set_title(f"Calibration, {next(iter(scores))}")
    axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    return figure
