"""Scores of runs taken together: shares with Wilson intervals, medians, largest values."""

from math import sqrt

import numpy as np

from benchmarks.harness.errors import INTERVAL
from benchmarks.harness.events import BINS, CAUSES, CLASSES, LEVELS, MODES
from benchmarks.harness.player import ALARMS

# Standard normal quantiles of the central intervals of LEVELS.
QUANTILES = dict(zip(LEVELS, (0.67449, 1.28155, 1.64485, 1.95996), strict=True))
ALARM_OF = {"wedge": "jamming", "stall": "jamming"}
# A lead that a cell can use [s].
ENOUGH = 0.05


def wilson(hits: int, count: int) -> tuple[float, float]:
    """Return the 95 % score interval of a share (Wilson 1927)."""
    if not count:
        return 0.0, 1.0
    p, z2 = hits / count, INTERVAL * INTERVAL
    middle = (p + z2 / (2 * count)) / (1 + z2 / count)
    half = INTERVAL * sqrt(p * (1 - p) / count + z2 / (4 * count * count)) / (1 + z2 / count)
    return max(0.0, middle - half), min(1.0, middle + half)


def share(hits: int, count: int) -> dict:
    """Return a share with its interval and what it rests on."""
    low, high = wilson(hits, count)
    return {
        "value": hits / count if count else None, "low": low, "high": high,
        "hits": int(hits), "count": int(count),
    }  # fmt: skip


def spread(values) -> dict:
    """Return median, 95 % quantile and largest of values, and how many there are."""
    values = np.asarray(list(values), float)
    if not values.size:
        return {"median": None, "p95": None, "max": None, "count": 0}
    return {
        "median": float(np.median(values)),
        "p95": float(np.quantile(values, 0.95)),
        "max": float(values.max()),
        "count": int(values.size),
    }


def pooled(runs: list[dict]) -> dict:
    """
    Return the scores of runs taken together.

    Parameters
    ----------
    runs : list of dict
        From `events.score_run`.

    """
    flags = [run["transition"] for run in runs]
    errors = [f["error"] for f in flags if f["error"] is not None]
    asked = [run["forecast"] for run in runs if run["forecast"] is not None]
    given = [f for f in asked if f["given"]]
    return {
        "runs": len(runs),
        "transitions": sum(f["true"] is not None for f in flags),
        "flag_error": spread(np.abs(errors)),
        "flag_bias": spread(errors)["median"],
        "flag_missed": sum(f["missed"] for f in flags),
        "flag_unjudged": sum(f["unjudged"] for f in flags),
        "flag_false_runs": sum(f["false"] > 0 for f in flags),
        "flag_flicker_runs": sum(f["flicker"] > 0 for f in flags),
        "forecast_given": share(len(given), len(asked)),
        "forecast": {
            str(level): share(sum(abs(f["z"]) <= q for f in given), len(given))
            for level, q in QUANTILES.items()
        },
        "forecast_error": spread(abs(f["error"]) for f in given),
        "alarms": {
            name: {level: _alarm(runs, name, level) for level in ("warn", "error")}
            for name in ALARMS
        },
        "onset": _latency(runs, "onset"),
        "loss": _latency(runs, "loss"),
        "longest_wrong": spread(run["longest_wrong"] for run in runs),
        "confusion": _confusion(runs),
        "calibration": _calibration(runs),
    }


def _latency(runs, name):
    latencies = [x for run in runs for x in run[name]]
    seen = [x for x in latencies if x is not None]
    return {"seen": share(len(seen), len(latencies)), "latency": spread(seen)}


def _alarm(runs, name, level):
    judged = [run["alarms"][name][level] for run in runs]
    right, false, near = (sum(j[k] for j in judged) for k in ("right", "false", "near"))
    causes = {}
    for cause in CAUSES:
        events = [e for j in judged for e in j["events"] if e[0] == cause]
        if ALARM_OF.get(cause, cause) == name:
            seen = [lead for _, lead, _ in events if lead is not None]
            causes[cause] = {
                "recall": share(len(seen), len(events)),
                "lead": spread(seen),
                "enough_lead": share(sum(x >= ENOUGH for x in seen), len(events)),
                "from_onset": spread(room for _, _, room in events),
            }
    return {
        "precision": share(right, right + false),
        # Those raised where the peg nearly stalls count as false here.
        "precision_strict": share(right, right + false + near),
        "near": share(sum(j["near_met"] for j in judged), sum(j["near_events"] for j in judged)),
        "false_runs": sum(j["false"] > 0 for j in judged),
        "unjudged": sum(j["unjudged"] for j in judged),
        "open": sum(j["open"] for j in judged),
        "causes": causes,
    }


def _confusion(runs):
    modes = list(MODES)
    for run in runs:
        for row in run["confusion"].values():
            modes += [mode for mode in row if mode not in modes]
    return {
        kind: {m: sum(run["confusion"].get(kind, {}).get(m, 0) for run in runs) for m in modes}
        for kind in CLASSES
    }


def _calibration(runs):
    names = sorted({name for run in runs for name in run["calibration"]})
    out = {}
    for name in names:
        bins = np.zeros((3, BINS))
        for run in runs:
            if name in run["calibration"]:
                bins += np.asarray(run["calibration"][name])
        count, said, true = bins
        # |mean of what was said - share that was true|, weighted by samples.
        error = float(np.abs(said - true).sum() / count.sum()) if count.sum() else None
        out[name] = {
            "error": error, "samples": int(count.sum()),
            "said": [s / c if c else None for s, c in zip(said, count, strict=True)],
            "true": [s / c if c else None for s, c in zip(true, count, strict=True)],
            "count": count.tolist(),
        }  # fmt: skip
    return out


def shown_share(s, digits=2) -> str:
    """Return a share as text, with its interval and count."""
    if not s["count"]:
        return "-"
    return (
        f"{s['value']:.{digits}f} ({s['low']:.{digits}f} to {s['high']:.{digits}f}; "
        f"{s['hits']}/{s['count']})"
    )


def shown_ms(value) -> str:
    """Return a time in milliseconds as text."""
    return "-" if value is None else f"{value * 1e3:.1f}"
