"""The first lines of a report: what happened, in words."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from peg_on_hole_ros.messages.passed_time import StampRun
from peg_on_hole_ros.number_text import quantity
from peg_on_hole_ros.records import ALARM_LEVELS, CONTACTS
from peg_on_hole_ros.report.tracks import PeakReaction

# A clock that goes back a little belongs to the stamps about it [ns].
_BESIDE_NS = 1_000_000_000
_ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth")
_MOST_ALARMS = 8


# What stands before a colon and has no more words is a label, as of a setting.
_LABEL_WORDS = 2
_ROOMS = "wrench", "joints", "scene", "clocks"
_SENTENCE_END = re.compile(r"\. (?=[A-Z])|; (?=with it |used in place of what is stated)")


class Cause(NamedTuple):
    """
    A line of what makes numbers doubtful, in its parts.

    Attributes
    ----------
    what : str
        What is wrong.
    remedy : str
        What to set or to do; empty: the line has nothing of it.
    evidence : str
        How that is known; empty: the line has nothing of it.

    """

    what: str
    remedy: str
    evidence: str


def parts_of(line: str) -> Cause:
    """Return the parts of a line that reads `what: remedy; with it evidence`, see `Finding`."""
    room, _, rest = line.partition(": ")
    if rest and room in _ROOMS:
        line = rest
    begin = 0
    first = line.find(": ")
    if first >= 0 and len(line[:first].split()) <= _LABEL_WORDS:
        begin = first + 2
    end = _SENTENCE_END.search(line, begin)
    stated = line[: end.start()] if end else line
    evidence = line[end.start() :].lstrip(".; ") if end else ""
    colon = stated.find(": ", begin)
    what, remedy = (stated, "") if colon < 0 else (stated[:colon], stated[colon + 2 :])
    return Cause(what, *map(_sentence, (remedy, evidence)))


class Remark(NamedTuple):
    """A sentence, and the time in the recording that it is about [s]; None: all of it."""

    text: str
    t: float | None = None


def tries_at(cycles: list[dict], runs: list[StampRun]) -> list[float]:
    """Return when each try begins, in passed time [s]: their records have stamps alone."""
    times, at, before_ns = [], 0, None
    for cycle in cycles:
        begun_ns = round(cycle["start_time"] * 1e9)
        # Tries follow each other: one that begins before the last is of a later run.
        at = min(at + (before_ns is not None and begun_ns < before_ns), max(len(runs) - 1, 0))
        before_ns = begun_ns
        for i in range(at, len(runs)):
            if runs[i].first_ns - _BESIDE_NS <= begun_ns <= runs[i].last_ns:
                at = i
                break
        times.append(max(runs[at].passed(begun_ns), 0) * 1e-9 if runs else 0.0)
    return times


def headline(cycles: list[dict], begun: list[float], judged: bool) -> Remark:
    """
    Return whether the peg went in, and when.

    Parameters
    ----------
    cycles : list of dict
        Tries, see `Tries`.
    begun : list of float
        When each began [s].
    judged : bool
        Whether contact modes were judged at all.

    """
    if not judged:
        return Remark("Whether the peg went in was not judged: monitor.modes is false.")
    if not cycles:
        return Remark("No try to insert the peg: contact never came.")
    last, t, count = cycles[-1], begun[-1], len(cycles)
    among = "" if count == 1 else f", in the {_ordinal(count)} of {count} tries"
    peg = {
        "inserted": "The peg went in",
        "jammed": "The peg did not go in: it jammed",
        "aborted": "The peg did not go in: contact was given up",
        "unfinished": "The recording ends before the peg was in",
    }[last["outcome"]]
    if last["transition_time"] is None:
        return Remark(f"{peg}{among}.", t)
    at = t + last["transition_time"]
    when = f", {last['transition_time']:.3f} s after first contact" if among == "" else ""
    return Remark(f"{peg}{among}: transition at {at:.3f} s{when}.", at)


def _ordinal(n):
    return _ORDINALS[n - 1] if n <= len(_ORDINALS) else f"{n}th"


class Doubt(NamedTuple):
    """
    What stands above all that rests on it.

    Attributes
    ----------
    headline : str
    lines : list of str
        What to do about it first, how that is known, and how many more there are.
    contradicted : bool
        Whether the data contradict a setting; else something is only odd.

    """

    headline: str
    lines: list[str]
    contradicted: bool


def doubt(contradicted: Sequence[str], doubts: Sequence[str]) -> Doubt | None:
    """
    Return what is wrong first, before any verdict; None: nothing is.

    Parameters
    ----------
    contradicted : sequence of str
        Settings that the data contradict, the likeliest first.
    doubts : sequence of str
        All that makes numbers doubtful, these among them.

    """
    first = [*contradicted, *doubts][:1]
    if not first:
        return None
    cause = parts_of(first[0])
    heading = "Settings are contradicted" if contradicted else "These results are doubtful"
    more = len(set(doubts) | set(contradicted)) - 1
    lines = [f"{part.rstrip('.')}." for part in (cause.remedy, cause.evidence) if part]
    if more:
        lines.append(f"{more} more below: correct the first one, then replay again.")
    return Doubt(f"{heading}: {cause.what}.", lines, bool(contradicted))


def load_line(
    peaks: dict[str, PeakReaction], limits: Sequence[float], void: str | None = None
) -> Remark:
    """Return the worst load against its limit [N], or `void`, why it is withheld."""
    if void:
        return Remark(f"Reactions are withheld: {void}.")
    if not peaks:
        return Remark("Reactions are not determined anywhere.")
    shares = {name: peaks[name].normal / limit for name, limit in _limited(peaks, limits)}
    worst = max(shares, key=shares.get)  # type: ignore[arg-type]
    peak, limit = peaks[worst], dict(_limited(peaks, limits))[worst]
    over = "over its limit" if shares[worst] > 1 else f"{shares[worst]:.0%} of its limit"
    load = quantity(peak.normal, "N")
    text = f"Worst load: {load} at {worst}, {over} of {quantity(limit, 'N')}."
    return Remark(text, peak.t_ns * 1e-9)


def _limited(peaks, limits):
    return [(name, limit) for name, limit in zip(CONTACTS, limits) if name in peaks]


def risen(alarms: Sequence[dict]) -> list[bool]:
    """Return for each change of an alarm's level whether it has risen, and rises no further."""
    levels: dict[str, list[int]] = {}
    at = []
    for alarm in alarms:
        of_name = levels.setdefault(alarm["name"], [0])
        at.append(len(of_name))
        of_name.append(ALARM_LEVELS.index(alarm["level"]))
    return [
        levels[alarm["name"]][i] > levels[alarm["name"]][i - 1]
        and levels[alarm["name"]][i] >= max(levels[alarm["name"]][i : i + 2])
        for alarm, i in zip(alarms, at)
    ]


def alarm_lines(alarms: list[dict], changes: int) -> list[Remark]:
    """Return each alarm with what to do, where it rose; one that comes again is counted."""
    found: dict[tuple, list[float]] = {}
    for alarm, told in zip(alarms, risen(alarms)):
        if told:
            key = alarm["name"], alarm["level"], alarm["message"]
            found.setdefault(key, []).append(alarm["time"])
    if not found:
        return [Remark("No alarm.")]
    # The graver ones first.
    ordered = sorted(found.items(), key=lambda item: (-ALARM_LEVELS.index(item[0][1]), item[1][0]))
    told = [
        Remark(f"{name} {level} at {times[0]:.3f} s{_times(times)}: {message}.", times[0])
        for (name, level, message), times in ordered[:_MOST_ALARMS]
    ]
    left = len(ordered) - len(told) + max(0, changes - len(alarms))
    return [*told, *([Remark(f"And {left} more, in the table of alarms.")] if left else [])]


def _times(times):
    more = len(times) - 1
    return f" and {more} more time{'s' if more > 1 else ''}" if more else ""


def doubt_lines(doubts: Sequence[str], undetermined: float | None) -> list[Remark]:
    """
    Return what makes the numbers doubtful beside what stands at the top.

    Parameters
    ----------
    doubts : sequence of str
        From `advice`, the likeliest cause first: that one is at the top.
    undetermined : float or None
        Share of three-point contact in which reactions are not determined.

    """
    found = [Remark(f"{_sentence(text)}.") for text in doubts[1:]]
    if not doubts:
        found = [Remark("The data do not contradict the settings.")]
    elif not found:
        found = [Remark("Nothing beside what stands at the top.")]
    if undetermined:
        found.append(
            Remark(
                f"In {undetermined:.1%} of three-point contact the wrench does not determine the "
                "reactions: they are left out of plots and figures there."
            )
        )
    return found


def dropped_line(messages: dict) -> Remark:
    """Return how many messages were used, and why others were not."""
    read, used, dropped = messages["read"], messages["used"], messages["dropped"]
    if not dropped:
        return Remark(f"Nothing was dropped: all {read} messages were used.")
    reasons = ", ".join(f"{count} {reason}" for reason, count in dropped.items())
    return Remark(f"{used} of {read} messages were used. Dropped: {reasons}.")


def _sentence(text):
    return text[:1].upper() + text[1:]
