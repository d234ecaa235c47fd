"""The tables of docs/faults.md, from figures."""

from math import isnan

from benchmarks.faults.expected import Case
from benchmarks.faults.short import known
from benchmarks.harness.tables import table

LEVELS = ("OK", "WARN", "ERROR")
# Of `shortfalls`, in words.
KINDS = {
    "flag": "wrong flag", "jam": "jam missed", "false_jam": "false jam", "lost": "no outcome",
    "told": "not reported", "counts": "not counted", "level": "level", "answer": "answer",
    "gamma": "gamma", "angles": "angles", "reactions": "reactions",
    "angles_after": "angles then", "reactions_after": "reactions then",
    "back": "back",
}  # fmt: skip
HEADS = {
    "closing": "closing",
    "jam": "jam",
    "cycle": "cycle",
    "insertion": "insertion",
    "cell": "cell",
    "jam_within": "in the jam",
    "crossing_within": "at the transition",
}


def page(found: dict[str, dict[str, dict]], cases: list[Case]) -> str:
    """
    Return the tables.

    Parameters
    ----------
    found : dict of str to dict of str to dict
        Figures by scene and name of the case.
    cases : list of Case
        In their order.

    """
    names = list(found)
    rows = []
    groups: dict[str, list[Case]] = {}
    for case in cases:
        groups.setdefault(case.group or case.name, []).append(case)
    short: dict[str, list[str]] = {}
    for group, members in groups.items():
        cells = []
        for name in names:
            each = [found[name][case.name] for case in members if case.name in found[name]]
            cells.append(_cell(each))
            for why, kinds in _short(members, name, found[name]).items():
                short.setdefault(why, []).append(f"{group}, {HEADS[name]}: {', '.join(kinds)}")
        rows.append((group, must(members[0]), *cells))
    text = table(("fault", "has to happen", *(HEADS[name] for name in names)), rows)
    if short:
        counts = [(len(of), why) for why, of in short.items()]
        text += "\n\n### What falls short\n\n" + table(("number of cells", "reason"), counts)
    return text


def must(case: Case) -> str:
    """Return what has to happen with a case, in a few words."""
    limit = f"not detectable; error of gamma at most {case.gamma * 1e3:g} mrad"
    parts = [limit] * bool(case.unseen)
    parts += ["reported"] * bool(case.told) + [LEVELS[case.level]] * bool(case.level)
    parts += ["counted"] * bool(case.counts)
    return "; ".join(parts + [f"“{case.answer}”"] * bool(case.answer))


def _short(members, scene, found):
    """Return which kinds fall short by reason, of several cases with how many of them."""
    by_why: dict[str, dict[str, int]] = {}
    for case in members:
        listed = known(scene, case.name)
        for kind in found.get(case.name, {}).get("short", {}):
            kinds = by_why.setdefault(listed.get(kind, "?"), {})
            kinds[kind] = kinds.get(kind, 0) + 1
    many = len(members) > 1
    return {
        why: [f"{KINDS[kind]} ({count})" if many else KINDS[kind] for kind, count in kinds.items()]
        for why, kinds in by_why.items()
    }


def _cell(figures):
    """Return what happened, of several cases the worst; empty where the fault is not put in."""
    if not figures:
        return ""

    def worst(name, of=min):
        values = [each[name] for each in figures if not isnan(each[name])]
        return of(values, default=float("nan"))

    text = f"{_share(worst('angles'))}/{_share(worst('reactions'))}"
    if not isnan(worst("angles_after")):
        text += f"→{_share(worst('angles_after'))}/{_share(worst('reactions_after'))}"
    return f"**{text}**" if any(each["short"] for each in figures) else text


def _share(value):
    return "-" if isnan(value) else f"{100.0 * value:.0f}"
