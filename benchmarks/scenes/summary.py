"""The scores that were promised, in one short table of Markdown."""

from benchmarks.scenes.table import by_family, shown_ms

TOLD = ("matched", "mismatch")
MODES = "mode_probability_", "three_point_validity", "transition_probability"


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
        ("scenes, transitions", lambda s: f"{s['runs']}, {s['transitions']}", ""),
        ("flag off, median / 95 % [ms]", _flag, "5 / 20"),
        (
            "missed / false flags",
            lambda s: f"{s['flag_missed']} / {s['flag_false_runs']}",
            "0 false",
        ),
        ("forecast given / right at 90 %", _forecast, ".85 to .95"),
    ]
    for level in ("warn", "error"):
        at = level.upper()
        rows += [
            (
                f"`jamming` at {at}: precision (near stalls counted false)",
                lambda s, level=level: _precision(s, "jamming", level, strict=True),
                ".95",
            ),
            (
                f"wedge at {at}: recall, lead [ms]",
                lambda s, level=level: _found(s, "jamming", level, "wedge"),
                ".95, what physics allows",
            ),
            (
                f"stall at {at}: recall, lead [ms]",
                lambda s, level=level: _found(s, "jamming", level, "stall"),
                ".95, 50",
            ),
            (
                f"`overload` at {at}: precision; recall, lead [ms]",
                lambda s, level=level: (
                    f"{_precision(s, 'overload', level)}; "
                    f"{_found(s, 'overload', level, 'overload')}"
                ),
                ".95; .95, 50",
            ),
        ]
    rows += [
        (
            "`contact_loss` at ERROR: precision; recall, lead [ms]",
            lambda s: (
                f"{_precision(s, 'contact_loss', 'error')}; "
                f"{_found(s, 'contact_loss', 'error', 'contact_loss')}"
            ),
            ".95",
        ),
        ("worst calibration error of a mode", _calibration, ".05"),
        ("contact begins / is lost: told after, median [ms]", _told_after, ""),
        ("longest wrong mode [s]", lambda s: f"{s['longest_wrong']['max']:.2f}", "none stays"),
    ]
    lines = [f"| | {' | '.join(scores)} | promised |", "|" + "---|" * (2 + len(scores))]
    for name, of, promised in rows:
        lines.append(f"| {name} | {' | '.join(of(s) for s in scores.values())} | {promised} |")
    return "\n".join(lines)


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
    errors = [c["error"] for name, c in s["calibration"].items() if name.startswith(MODES) and c]
    return f"{max(errors):.3f}" if errors else "-"


def _told_after(s):
    return " / ".join(shown_ms(s[change]["latency"]["median"]) for change in ("onset", "loss"))
