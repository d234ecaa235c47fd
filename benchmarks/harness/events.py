"""Score one run: what was said against what happened, as a plain tree of counts and times."""

from typing import NamedTuple

import numpy as np

from benchmarks.harness.player import ALARMS, Record

MODES = ("three_point", "two_point", "open", "unknown", "elsewhere")
CAUSES = ("wedge", "stall", "overload", "contact_loss")
# What an alarm may foresee or not: neither counts for it nor against it.
NEAR_STALL = "near_stall"
CLASSES = ("three_point", "stuck", "two_point", "lost", "open")
# A flag this near to the transition [s] means it; any other is a false one.
FLAG_WINDOW = 0.1
# A transition with less of the record after it [s] cannot be missed.
FLAG_ROOM = 0.05
AHEAD = 0.1
LEVELS = (0.5, 0.8, 0.9, 0.95)
# An alarm may be late by so much [s], and must not have been taken back this long before.
LATE = 0.05
TAKEN_BACK = 0.05
# The first of a record: the filter settles.
SETTLE = 0.05
BINS = 10
# Modes that contradict what is true; `unknown` contradicts nothing.
CONTRADICTS = {
    "three_point": ("two_point", "open"),
    "stuck": ("two_point", "open"),
    "two_point": ("three_point", "open"),
    "lost": ("three_point", "two_point"),
    "open": ("three_point", "two_point"),
}
# A change of contact that is not declared within it [s] has not been seen.
SEEN_WITHIN = 0.1
# Which events each alarm speaks of, and which more make it right to have been raised.
SPEAKS_OF = {
    "jamming": ("wedge", "stall"),
    "overload": ("overload",),
    "contact_loss": ("contact_loss",),
}
ALSO_RIGHT = {"jamming": ("overload",)}
# And which leave open whether it was.
LEAVES_OPEN = {"jamming": (NEAR_STALL,)}
ALARM_LEVELS = {"warn": 1, "error": 2}


class Event(NamedTuple):
    """
    What happened, from when until when [s]; the end is that of the record if it stayed.

    Attributes
    ----------
    onset : float
        When the program entered the phase in which it happened: before, nothing pointed to it.

    """

    cause: str
    begin: float
    end: float
    onset: float


class SceneLabels(NamedTuple):
    """
    The truth of a scene as it is scored.

    Attributes
    ----------
    t : ndarray, shape (n,)
        [s]
    kind : ndarray of str, shape (n,)
        A member of CLASSES; empty where loads fade while the peg is let go.
    below : ndarray of bool, shape (n,)
        gamma < gamma0.
    transition : float or None
        When gamma passed gamma0 in contact [s].
    events : tuple of Event

    """

    t: np.ndarray
    kind: np.ndarray
    below: np.ndarray
    transition: float | None
    events: tuple[Event, ...]


def stretches(chosen: np.ndarray) -> list[tuple[int, int]]:
    """Return first and last index of every run of True."""
    padded = np.concatenate([[False], chosen, [False]]).astype(int)
    edges = np.flatnonzero(np.diff(padded))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def score_run(labels: SceneLabels, record: Record) -> dict:
    """Return everything that the tables need of one run."""
    return {
        "duration": float(labels.t[-1]),
        "events": [list(event) for event in labels.events],
        "transition": _transition(labels, record),
        "forecast": _forecast(labels, record),
        "alarms": {
            name: {
                level: judge_alarm(
                    episodes(labels.t, record.alarms[name] >= threshold),
                    [e for e in labels.events if e.cause in SPEAKS_OF[name]],
                    [e for e in labels.events if e.cause in ALSO_RIGHT.get(name, ())],
                    float(labels.t[-1]),
                    [e for e in labels.events if e.cause in LEAVES_OPEN.get(name, ())],
                )
                for level, threshold in ALARM_LEVELS.items()
            }
            for name in ALARMS
        },
        "confusion": confusion(labels, record),
        "longest_wrong": longest_wrong(labels, record),
        "onset": latencies(labels, record, ("open",), ("three_point",), ("three_point",)),
        "loss": latencies(
            labels, record, ("three_point", "stuck"), ("lost", "open", ""), ("open", "unknown")
        ),
        "calibration": calibration(labels, record),
    }


def episodes(t, on) -> list[tuple[float, float]]:
    """Return when something was on, from and to [s]."""
    return [(float(t[a]), float(t[b])) for a, b in stretches(on)]


def _transition(labels, record):
    """Return the true time, how far off the flag was, and false and missed flags."""
    rises = [begin for begin, _ in episodes(labels.t, record.flag)]
    true, end = labels.transition, float(labels.t[-1])
    near = [] if true is None else [r for r in rises if abs(r - true) <= FLAG_WINDOW]
    errors = [r - true for r in near]
    return {
        "true": true,
        "error": errors[0] if errors else None,
        "missed": bool(true is not None and not errors and end - true >= FLAG_ROOM),
        "unjudged": bool(true is not None and not errors and end - true < FLAG_ROOM),
        "false": len(rises) - len(near),
        # The flag rose more than once for one transition.
        "flicker": max(len(near) - 1, 0),
    }


def _forecast(labels, record):
    """Return how the forecast made AHEAD of the transition came out; None without one."""
    if labels.transition is None or labels.transition - AHEAD < SETTLE:
        return None
    k = int(np.searchsorted(labels.t, labels.transition - AHEAD))
    if labels.kind[k] != "three_point":
        return None
    nothing = np.full(len(labels.t), np.nan)
    time = record.monitor.get("time_to_transition", nothing)[k]
    stddev = record.monitor.get("time_to_transition_stddev", nothing)[k]
    if not np.isfinite(time) or not np.isfinite(stddev):
        return {"given": False}
    error = float(time - (labels.transition - labels.t[k]))
    return {"given": True, "error": error, "z": error / max(float(stddev), 1e-9)}


def judge_alarm(raised, events, also, end, near=()) -> dict:
    """
    Return which events an alarm foresaw, and how many times it was raised for nothing.

    Parameters
    ----------
    raised : list of (float, float)
        When the alarm was on, from and to [s].
    events : list of Event
        What it speaks of.
    also : list of Event
        What makes it right to have been raised, but is not asked for.
    end : float
        Of the record [s].
    near : sequence of Event
        What leaves open whether it was right to have been raised.

    Returns
    -------
    dict
        `events`: for each its cause, the lead [s] (negative: late) or None, and the lead from the
        event's onset; `right`, `false`, `near`: of the times it was raised; `unjudged`: raised
        less than 50 ms before the record ends; `open`: events that nothing was said of, less
        than 50 ms before the record ends; `near_events`: how many leave it open; `near_met`: at
        how many of these it was raised.

    """
    found, unsaid = [], 0
    for event in events:
        leads = [event.begin - r for r, c in raised if _meets(r, c, event)]
        if not leads and end - event.begin < LATE:
            unsaid += 1
            continue
        lead = max(leads) if leads else None
        found.append([event.cause, lead, event.begin - event.onset])
    right = false = unjudged = nearly = 0
    for r, c in raised:
        if any(_belongs(r, c, event) for event in [*events, *also]):
            right += 1
        elif any(_belongs(r, c, event) for event in near):
            nearly += 1
        elif end - r < LATE:
            unjudged += 1
        else:
            false += 1
    return {
        "events": found, "right": right, "false": false, "near": nearly, "unjudged": unjudged,
        "open": unsaid, "near_events": len(near),
        "near_met": sum(any(_belongs(r, c, event) for r, c in raised) for event in near),
    }  # fmt: skip


def _belongs(raised, cleared, event):
    return _meets(raised, cleared, event) or event.begin <= raised <= event.end


def _meets(raised, cleared, event):
    return raised <= event.begin + LATE and cleared >= event.begin - TAKEN_BACK


def confusion(labels, record) -> dict:
    """Return samples by true class and declared mode, {class: {mode: count}}."""
    told = (record.mode != "") & (labels.t >= SETTLE)
    modes = [*MODES, *sorted(set(record.mode[told]) - set(MODES))]
    table = {}
    for kind in CLASSES:
        chosen = told & (labels.kind == kind)
        if chosen.any():
            table[kind] = {mode: int((record.mode[chosen] == mode).sum()) for mode in modes}
    return table


def longest_wrong(labels, record) -> float:
    """Return the longest time for which a mode was declared that contradicts the truth [s]."""
    wrong = np.zeros(len(labels.t), bool)
    for kind, modes in CONTRADICTS.items():
        wrong |= (labels.kind == kind) & np.isin(record.mode, modes)
    wrong &= labels.t >= SETTLE
    return float(max((labels.t[b] - labels.t[a] for a, b in stretches(wrong)), default=0.0))


def latencies(labels, record, before, after, declared) -> list:
    """
    Return how long each true change took to be declared [s]; None if it was not within 0.1 s.

    Parameters
    ----------
    before, after : tuple of str
        Classes between which it is a change.
    declared : tuple of str
        Modes that say so.

    """
    changed = np.isin(labels.kind[:-1], before) & np.isin(labels.kind[1:], after)
    found = []
    for k in np.flatnonzero(changed & (labels.t[1:] >= SETTLE)) + 1:
        since = labels.t - labels.t[k]
        said = (since >= 0) & (since <= SEEN_WITHIN) & np.isin(record.mode, declared)
        if said.any():
            found.append(float(since[np.argmax(said)]))
        elif since[-1] >= SEEN_WITHIN:
            found.append(None)
    return found


def calibration(labels, record) -> dict:
    """
    Return for each published probability [samples, their sum, times it was true] a bin.

    A probability of a mode is held against the true class. `transition_probability` is held
    against gamma < gamma0 while the peg touches, `three_point_validity` against three-point
    contact, moving or not.

    """
    settled = (labels.t >= SETTLE) & (labels.kind != "")
    touching = settled & np.isin(labels.kind, ("three_point", "two_point", "stuck"))
    three = np.isin(labels.kind, ("three_point", "stuck"))
    kind = labels.kind
    asked = {
        "transition_probability": (touching, labels.below),
        "three_point_validity": (settled, three),
        "mode_probability_three_point": (settled, kind == "three_point"),
        "mode_probability_two_point": (settled, kind == "two_point"),
        "mode_probability_stuck": (settled, kind == "stuck"),
        "mode_probability_opened": (settled, kind == "lost"),
        "mode_probability_free": (settled, kind == "open"),
        "mode_probability_open": (settled, np.isin(kind, ("open", "lost"))),
    }
    found = {}
    for name, (where, true) in asked.items():
        values = record.monitor.get(name)
        if values is None:
            continue
        where = where & np.isfinite(values)
        index = np.clip((values[where] * BINS).astype(int), 0, BINS - 1)
        found[name] = [
            np.bincount(index, weights, BINS).tolist()
            for weights in (None, values[where], true[where].astype(float))
        ]
    return found
