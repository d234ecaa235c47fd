"""The tables of the scenes: the scores that have a limit, and all of them by family."""

from benchmarks.harness.player import ALARMS
from benchmarks.harness.pooled import pooled, shown_ms, shown_share
from benchmarks.harness.tables import table
from benchmarks.scenes.draw import FAMILIES

TOLD = ("matched", "mismatch")
# Elsewhere alarms stand from the try before, or nothing happens.
WITH_ALARMS = TOLD
PROBABILITIES = "mode_probability_", "three_point_validity", "transition_probability"


def by_family(runs: list[dict]) -> dict[str, dict]:
    """Return the pooled scores of each family that occurs, and of `all`."""
    families = {f: [r for r in runs if r["family"] == f] for f in FAMILIES}
    return {f: pooled(r) for f, r in families.items() if r} | {"all": pooled(runs)}


def summary(variants: dict[str, list[dict]]) -> str:
    """
    Return the table; a column for each of TOLD that was run.

    Parameters
    ----------
    variants : dict of str to list of dict
        Runs by what the estimator was told.

    """
    scores = {told: by_family(variants[told])["all"] for told in TOLD if variants.get(told)}
    if not scores:
        return ""
    rows = [
        ("number of scenes, of transitions", lambda s: f"{s['runs']}, {s['transitions']}", ""),
        ("error of the flag, median / 95 % [ms]", _flag, "5 / 20"),
        (
            "number of missed / false flags",
            lambda s: f"{s['flag_missed']} / {s['flag_false_runs']}",
            "0 false",
        ),
        ("share of forecasts given / right at 90 %", _forecast, "0.85 to 0.95"),
    ]
    for level in ("warn", "error"):
        at = level.upper()
        rows += [
            (
                f"`jamming` at {at}: precision (near stalls count as false)",
                lambda s, level=level: _precision(s, "jamming", level, strict=True),
                "0.95",
            ),
            (
                f"wedge at {at}: recall, lead [ms]",
                lambda s, level=level: _found(s, "jamming", level, "wedge"),
                "0.95, as early as possible",
            ),
            (
                f"stall at {at}: recall, lead [ms]",
                lambda s, level=level: _found(s, "jamming", level, "stall"),
                "0.95, 50",
            ),
            (
                f"`overload` at {at}: precision; recall, lead [ms]",
                lambda s, level=level: (
                    f"{_precision(s, 'overload', level)}; "
                    f"{_found(s, 'overload', level, 'overload')}"
                ),
                "0.95; 0.95, 50",
            ),
        ]
    rows += [
        (
            "`contact_loss` at ERROR: precision; recall, lead [ms]",
            lambda s: (
                f"{_precision(s, 'contact_loss', 'error')}; "
                f"{_found(s, 'contact_loss', 'error', 'contact_loss')}"
            ),
            "0.95",
        ),
        ("largest calibration error of a mode probability", _calibration, "0.05"),
        ("delay of the mode, contact begins / is lost, median [ms]", _delays, ""),
        (
            "longest time with a wrong mode [s]",
            lambda s: f"{s['longest_wrong']['max']:.2f}",
            "no wrong mode stays",
        ),
    ]
    head = ["quantity", *scores, "limit"]
    return table(head, [(name, *map(of, scores.values()), limit) for name, of, limit in rows])


def _share(s):
    return f"{s['value']:.2f} ({s['hits']}/{s['count']})" if s["count"] else "-"


def _flag(s):
    return f"{shown_ms(s['flag_error']['median'])} / {shown_ms(s['flag_error']['p95'])}"


def _forecast(s):
    right = s["forecast"]["0.9"]
    interval = f" ({right['low']:.2f} to {right['high']:.2f})" if right["count"] else ""
    return f"{_share(s['forecast_given'])} / {_share(right)}{interval}"


def _precision(s, alarm, level, strict=False):
    a = s["alarms"][alarm][level]
    counted = a["precision_strict"]["value"] if strict else None
    return _share(a["precision"]) + ("" if counted is None else f" ({counted:.2f})")


def _found(s, alarm, level, cause):
    found = s["alarms"][alarm][level]["causes"][cause]
    return f"{_share(found['recall'])}, {shown_ms(found['lead']['median'])}"


def _calibration(s):
    named = [c for name, c in s["calibration"].items() if name.startswith(PROBABILITIES)]
    errors = [c["error"] for c in named if c]
    return f"{max(errors):.3f}" if errors else "-"


def _delays(s):
    return " / ".join(shown_ms(s[change]["latency"]["median"]) for change in ("onset", "loss"))


def tables(variants: dict[str, list[dict]]) -> str:
    """
    Return the tables in Markdown.

    Parameters
    ----------
    variants : dict of str to list of dict
        Runs by what the estimator was told: `matched`, and `mismatch` beside it.

    """
    found = {name: by_family(runs) for name, runs in variants.items()}
    alarmed = {name: scores for name, scores in found.items() if name in WITH_ALARMS}
    parts = {f"Transition and forecast, {name}": _transitions(s) for name, s in found.items()}
    parts["Alarms, all scenes"] = _alarms(alarmed)
    parts |= {f"Runs with a false alarm, {name}": _false(s) for name, s in alarmed.items()}
    parts |= {
        f"Modes, share of samples, {name}": _confusion(s["all"]) for name, s in found.items()
    }
    parts["Changes of contact, and modes that contradict the truth"] = _latencies(found)
    parts["Expected calibration error"] = _calibrations(found)
    return "\n\n".join(f"{title}:\n\n{text}" for title, text in parts.items())


def _transitions(scores):
    head = (
        "family", "runs", "transitions", "error of the flag, median / 95 % [ms]", "missed",
        "false", "flicker", "forecast given", "right at 90 %",
    )  # fmt: skip
    rows = [
        (
            family, s["runs"], s["transitions"], _flag(s), s["flag_missed"],
            s["flag_false_runs"], s["flag_flicker_runs"], shown_share(s["forecast_given"]),
            shown_share(s["forecast"]["0.9"]),
        )
        for family, s in scores.items()
    ]  # fmt: skip
    return table(head, rows)


def _alarms(found):
    head = (
        "alarm, level", "told", "precision", "near stalls false", "cause", "recall",
        "lead, median [ms]", "50 ms and more", "from the onset [ms]",
    )  # fmt: skip
    rows = []
    for alarm in ALARMS:
        for level in ("error", "warn"):
            for name, scores in found.items():
                a = scores["all"]["alarms"][alarm][level]
                strict = "-"
                if a["near"]["count"]:
                    strict = f"{a['precision_strict']['value'] or 0:.2f}"
                    strict += f" ({a['near']['hits']} at {a['near']['count']} near stalls)"
                first = f"{alarm}, {level.upper()}", name, shown_share(a["precision"]), strict
                for cause, c in a["causes"].items():
                    rows.append(
                        (
                            *first, cause, shown_share(c["recall"]),
                            shown_ms(c["lead"]["median"]), shown_share(c["enough_lead"]),
                            shown_ms(c["from_onset"]["median"]),
                        )
                    )  # fmt: skip
    return table(head, rows)


def _false(scores):
    columns = [(alarm, level) for alarm in ALARMS for level in ("error", "warn")]
    head = "family", "runs", *(f"{alarm} {level.upper()}" for alarm, level in columns)
    rows = [
        (family, s["runs"], *(s["alarms"][a][level]["false_runs"] for a, level in columns))
        for family, s in scores.items()
    ]
    return table(head, rows)


def _confusion(score):
    of = score["confusion"]
    modes, rows = list(next(iter(of.values()))), []
    for kind, row in of.items():
        count = sum(row.values())
        cells = (f"{row[mode] / count:.3f}" if count else "-" for mode in modes)
        rows.append((kind, count, *cells))
    return table(("truth", "samples", *modes), rows)


def _latencies(found):
    def times(spread):
        return " / ".join(shown_ms(spread[k]) for k in ("median", "p95", "max"))

    rows = []
    for name, words in (("onset", "contact begins"), ("loss", "contact is lost")):
        for told, scores in found.items():
            s = scores["all"][name]
            rows.append((words, told, shown_share(s["seen"]), times(s["latency"])))
    for told, scores in found.items():
        longest = scores["all"]["longest_wrong"]
        rows.append(("longest wrong mode of a run", told, "-", times(longest)))
    head = "what", "told", "seen within 100 ms", "median / 95 % / largest [ms]"
    return table(head, rows)


def _calibrations(found):
    names = sorted({n for scores in found.values() for n in scores["all"]["calibration"]})
    rows = []
    for name in names:
        cells = [scores["all"]["calibration"].get(name) for scores in found.values()]
        rows.append((f"`{name}`", *("-" if c is None else f"{c['error']:.3f}" for c in cells)))
    return table(("probability", *found), rows)


def flat_scores(variants) -> list[list]:
    """Return the CSV's rows: a head, then one number a row with its interval and count."""
    rows = [["told", "family", "score", "value", "low", "high", "count"]]

    def walk(told, family, name, value):
        if isinstance(value, dict) and "hits" in value:
            numbers = [value[k] for k in ("value", "low", "high", "count")]
            rows.append([told, family, name, *numbers])
        elif isinstance(value, dict):
            for key, part in value.items():
                walk(told, family, f"{name}.{key}" if name else key, part)
        elif not isinstance(value, list):
            rows.append([told, family, name, value, "", "", ""])

    for told, runs in variants.items():
        for family, scores in by_family(runs).items():
            walk(told, family, "", scores)
    return rows


def flat_runs(variants) -> list[list]:
    """Return the CSV's rows: a head, then one run a row."""
    head = ["told", "family", "number", "end", "duration", "events", "transition", "flag_error"]
    head += ["flag_missed", "flag_false", "forecast_z"]
    head += [f"{alarm}_{x}" for alarm in ALARMS for x in ("false", "leads")]
    rows = [head]
    for told, runs in variants.items():
        for r in runs:
            flag, forecast = r["transition"], r["forecast"] or {}
            events = " ".join(f"{cause}@{begin:.3f}" for cause, begin, *_ in r["events"])
            row = [told, r["family"], r["number"], r["end"], r["duration"], events]
            row += [flag["true"], flag["error"], int(flag["missed"]), flag["false"]]
            row.append(forecast.get("z"))
            for alarm in ALARMS:
                judged = r["alarms"][alarm]["error"]
                leads = ("-" if x is None else f"{x:.3f}" for _, x, _ in judged["events"])
                row += [judged["false"], " ".join(leads)]
            rows.append([f"{v:.6g}" if isinstance(v, float) else v for v in row])
    return rows
