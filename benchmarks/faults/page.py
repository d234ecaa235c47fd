"""The tables of docs/faults.md, from figures."""

from math import isfinite, isnan

from benchmarks.faults.expected import Case
from benchmarks.faults.short import known

LEVELS = ("OK", "WARN", "ERROR")
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
    rows = ["| fault | has to happen | " + " | ".join(HEADS[n] for n in names) + " |"]
    rows.append("|" + "---|" * (2 + len(names)))
    groups: dict[str, list[Case]] = {}
    for case in cases:
        groups.setdefault(case.group or case.name, []).append(case)
    short = []
    for group, members in groups.items():
        cells = []
        for name in names:
            each = [found[name][case.name] for case in members if case.name in found[name]]
            cells.append(_cell(each))
            short += _short(group, members, name, found[name])
        rows.append(f"| {group} | {must(members[0])} | {' | '.join(cells)} |")
    text = "\n".join(rows)
    if short:
        text += "\n\n### What falls short\n\n| fault | scene | what | why |\n|---|---|---|---|\n"
        text += "\n".join(short)
    return text


def must(case: Case) -> str:
    """Return what has to happen with a case, in a few words."""
    parts = (
        [f"not seen: {case.unseen}; gamma within {case.gamma * 1e3:g} mrad"] if case.unseen else []
    )
    if case.told:
        parts.append(f"told “{case.told}” within {case.within:g} s")
    if case.level:
        parts.append(LEVELS[case.level])
    if case.counts:
        parts.append("counts " + ", ".join(f"`{name}`" for name in case.counts))
    if case.answer:
        parts.append(f"“{case.answer}”")
    if not case.unseen:
        parts.append("bounds hold, or told")
    if not case.lasts and not case.unseen:
        parts.append(f"back within {case.recovers:g} s")
    return "; ".join(parts)


def _short(group, members, scene, found):
    """Return rows of what falls short: of several cases of a group one that says how many."""
    by_why: dict[str, list[str]] = {}
    for case in members:
        listed = known(scene, case.name)
        for kind, text in found.get(case.name, {}).get("short", {}).items():
            by_why.setdefault(listed.get(kind, "?"), []).append(text)
    for why, texts in by_why.items():
        what = "; ".join(texts)
        if len(members) > 1:
            what = f"{len(texts)} of {len(members)}, such as {texts[0]}"
        yield f"| {group} | {HEADS[scene]} | {what} | {why} |"


def _cell(figures):
    """Return what happened, of several cases the worst; empty where the fault is not put in."""
    if not figures:
        return ""

    def worst(name, of=min):
        values = [each[name] for each in figures if not isnan(each[name])]
        return of(values, default=float("nan"))

    parts = [f"{_share(worst('angles'))} / {_share(worst('reactions'))}"]
    if not isnan(worst("angles_after")):
        after = _share(worst("angles_after")), _share(worst("reactions_after"))
        parts.append(f"after it {after[0]} / {after[1]}")
    told = [min(each["told"].values()) for each in figures if each["told"]]
    if told:
        parts.append(f"told {max(told):.1f} s")
    if isfinite(worst("recovered", max)):
        parts.append(f"back {worst('recovered', max) * 1e3:.0f} ms")
    text = ", ".join(parts)
    return f"**{text}**" if any(each["short"] for each in figures) else text


def _share(value):
    return "-" if isnan(value) else f"{value:.0%}"
