"""Pool the scores of runs: shares with Wilson intervals, medians, tables in Markdown and CSV."""

from math import sqrt

import numpy as np

from benchmarks.scenes.draw import FAMILIES
from benchmarks.scenes.labels import CAUSES, CLASSES
from benchmarks.scenes.play import ALARMS, MODES
from benchmarks.scenes.score import BINS, LEVELS

# Standard normal quantiles of the central intervals of LEVELS.
QUANTILES = dict(zip(LEVELS, (0.67449, 1.28155, 1.64485, 1.95996), strict=True))
# Elsewhere alarms stand from the try before, or nothing happens.
WITH_ALARMS = ("matched", "mismatch")
ALARM_OF = {"wedge": "jamming", "stall": "jamming"}
Z95 = 1.959964
# A lead that a cell can use [s].
ENOUGH = 0.05


def wilson(hits: int, count: int) -> tuple[float, float]:
    """Return the 95 % score interval of a share (Wilson 1927)."""
    if not count:
        return 0.0, 1.0
    p, z2 = hits / count, Z95 * Z95
    middle = (p + z2 / (2 * count)) / (1 + z2 / count)
    half = Z95 * sqrt(p * (1 - p) / count + z2 / (4 * count * count)) / (1 + z2 / count)
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
        From `score.score_run`.

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


def by_family(runs: list[dict]) -> dict[str, dict]:
    """Return the pooled scores of each family that occurs, and of `all`."""
    families = {f: [r for r in runs if r["family"] == f] for f in FAMILIES}
    return {f: pooled(r) for f, r in families.items() if r} | {"all": pooled(runs)}


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


def tables(variants: dict[str, list[dict]]) -> str:
    """
    Return the tables in Markdown.

    Parameters
    ----------
    variants : dict of str to list of dict
        Runs by what the estimator was told: `matched`, and `mismatch` beside it.

    """
    found = {name: by_family(runs) for name, runs in variants.items()}
    parts = []
    for name, scores in found.items():
        parts += [f"Transition and forecast, {name}:", "", *_transition_table(scores), ""]
    alarmed = {name: scores for name, scores in found.items() if name in WITH_ALARMS}
    parts += ["Alarms, all scenes:", "", *_alarm_table(alarmed), ""]
    for name, scores in alarmed.items():
        parts += [f"Runs with a false alarm, {name}:", "", *_false_table(scores), ""]
    for name, scores in found.items():
        parts += [f"Modes, share of samples, {name}:", "", *_confusion_table(scores["all"]), ""]
    parts += ["Changes of contact, and modes that contradict the truth:", ""]
    parts += [
        *_latency_table(found),
        "",
        "Expected calibration error:",
        "",
        *_calibration_table(found),
    ]
    return "\n".join(parts)


def _transition_table(scores):
    lines = [
        "| family | runs | transitions | flag off, median / 95 % [ms] | missed | false | flicker "
        "| forecast given | right at 90 % |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for family, s in scores.items():
        off = f"{shown_ms(s['flag_error']['median'])} / {shown_ms(s['flag_error']['p95'])}"
        lines.append(
            f"| {family} | {s['runs']} | {s['transitions']} | {off} | {s['flag_missed']} "
            f"| {s['flag_false_runs']} | {s['flag_flicker_runs']} "
            f"| {shown_share(s['forecast_given'])} | {shown_share(s['forecast']['0.9'])} |"
        )
    return lines


def _alarm_table(found):
    lines = [
        "| alarm, level | told | precision | near stalls false | cause | recall "
        "| lead, median [ms] | 50 ms and more | from the onset [ms] |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for alarm in ALARMS:
        for level in ("error", "warn"):
            for name, scores in found.items():
                a = scores["all"]["alarms"][alarm][level]
                precision = shown_share(a["precision"])
                strict = "-"
                if a["near"]["count"]:
                    strict = f"{a['precision_strict']['value'] or 0:.2f}"
                    strict += f" ({a['near']['hits']} at {a['near']['count']} near stalls)"
                for cause, c in a["causes"].items():
                    lines.append(
                        f"| {alarm}, {level.upper()} | {name} | {precision} | {strict} | {cause} "
                        f"| {shown_share(c['recall'])} | {shown_ms(c['lead']['median'])} "
                        f"| {shown_share(c['enough_lead'])} "
                        f"| {shown_ms(c['from_onset']['median'])} |"
                    )
    return lines


def _false_table(scores):
    columns = [(alarm, level) for alarm in ALARMS for level in ("error", "warn")]
    head = " | ".join(f"{alarm} {level.upper()}" for alarm, level in columns)
    lines = [f"| family | runs | {head} |", "|" + "---|" * (2 + len(columns))]
    for family, s in scores.items():
        numbers = " | ".join(str(s["alarms"][a][level]["false_runs"]) for a, level in columns)
        lines.append(f"| {family} | {s['runs']} | {numbers} |")
    return lines


def _confusion_table(score):
    table = score["confusion"]
    modes = list(next(iter(table.values())))
    lines = [f"| truth | samples | {' | '.join(modes)} |", "|" + "---|" * (2 + len(modes))]
    for kind, row in table.items():
        count = sum(row.values())
        cells = " | ".join(f"{row[m] / count:.3f}" if count else "-" for m in modes)
        lines.append(f"| {kind} | {count} | {cells} |")
    return lines


def _latency_table(found):
    lines = [
        "| what | told | seen within 100 ms | median / 95 % / largest [ms] |",
        "|---|---|---|---|",
    ]
    for name, words in (("onset", "contact begins"), ("loss", "contact is lost")):
        for told, scores in found.items():
            s = scores["all"][name]
            times = " / ".join(shown_ms(s["latency"][k]) for k in ("median", "p95", "max"))
            lines.append(f"| {words} | {told} | {shown_share(s['seen'])} | {times} |")
    for told, scores in found.items():
        s = scores["all"]["longest_wrong"]
        times = " / ".join(shown_ms(s[k]) for k in ("median", "p95", "max"))
        lines.append(f"| longest wrong mode of a run | {told} | - | {times} |")
    return lines


def _calibration_table(found):
    names = sorted({n for scores in found.values() for n in scores["all"]["calibration"]})
    lines = [f"| probability | {' | '.join(found)} |", "|" + "---|" * (1 + len(found))]
    for name in names:
        cells = [scores["all"]["calibration"].get(name) for scores in found.values()]
        texts = " | ".join("-" if c is None else f"{c['error']:.3f}" for c in cells)
        lines.append(f"| `{name}` | {texts} |")
    return lines
