"""A record of each try to insert a peg, from the messages that the node publishes."""

import json
from collections.abc import Sequence
from math import isfinite
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.messages.columns import OutputColumns
from peg_on_hole_ros.messages.passed_time import PassedTime
from peg_on_hole_ros.records import ALARM_LEVELS, CONTACTS

# Contact that is lost for less than this belongs to one try [ns].
PAUSE_NS = 200_000_000
# Within this contact is told from one beside the hole [ns].
CONTACT_DECIDED_NS = 300_000_000
# Without a wrench for longer a peg may have gone, and another come [ns].
PEG_CHANGE_NS = 1_000_000_000
# An alarm that flickers would fill the record; further ones are only counted.
MOST_CYCLE_ALARMS = 100
# Decimals of seconds, far below a wrench's period, and of newtons, below any sensor's noise.
_SECONDS, _NEWTONS = 6, 3
ELSEWHERE, INSERTED = "elsewhere", "inserted"
_TOUCHING = ("three_point", "two_point", INSERTED)


class _Came(NamedTuple):
    """What a try is made of at one stamp: messages, reactions [N], age and latency of contact."""

    messages: dict[str, dict]
    loads: Sequence[float] | None
    touch: Sequence[float]


def _came(columns, place, messages):
    determined = columns["reactions_determined"][place] == 1.0
    loads = columns["normal"][place].tolist() if determined else None
    touch = [columns[name][place].item() for name in ("contact_age", "contact_latency")]
    return _Came(messages, loads, touch)


def _seconds(ns):
    return round(ns * 1e-9, _SECONDS)


def json_line(record: dict) -> str:
    """Return a record as one line of JSON; a number that is not finite raises ValueError."""
    return json.dumps(record, allow_nan=False)


class Tries:
    """
    Makes a record of each try, ready for JSON, the same for node and replay; keeps none.

    A try begins where contact came. It ends where contact has gone for a while, where stamps
    fall, or where the wrench fell silent for longer than anybody can say what the peg did; the
    next one then begins with a contact mode that is declared anew. One stamp alone is no silence:
    what comes after it is waited for. What a record holds: docs/command_line.md.

    Attributes
    ----------
    depth_stated : bool
        Whether a try has gone in where the contact mode was `inserted` at its end, and not where
        contact became two-point.

    """

    def __init__(self, depth_stated: bool = False) -> None:
        self.depth_stated = depth_stated
        self._levels: dict[str, int] = {}
        self._flag = False
        self._mode = ""
        self._open_ns: int | None = None
        self._passed = PassedTime()
        self._seen_ns: int | None = None
        # The first stamp after a silence, and what came with it.
        self._held: tuple[int, _Came] | None = None
        # Since when the peg has touched elsewhere, until when it last did, and how long in all.
        self._elsewhere_ns: int | None = None
        self._searched_until_ns: int | None = None
        self._searched_ns = 0
        self._begin()

    def _begin(self):
        self._start_ns: int | None = None
        self._latency = 0.0
        self._transition_ns: int | None = None
        self._inserted = False
        self._last_ns = 0
        self._peak = [0.0, 0.0, 0.0]
        self._sum = [0.0, 0.0, 0.0]
        self._count = 0
        self._alarms: list[dict] = []
        self._alarm_count = 0

    def _add(self, t_ns, came):
        ended = []
        if self._held is not None:
            (held_ns, held), self._held = self._held, None
            if self._seen_ns < t_ns < held_ns:
                # It was a wrong stamp, and no silence: what it changed was so at once.
                held_ns = self._seen_ns
            else:
                ended += self._fall_silent()
            ended += self._take(held_ns, held)
        silent = self._seen_ns is not None and t_ns - self._seen_ns > PEG_CHANGE_NS
        if silent and self._start_ns is not None:
            self._held = t_ns, came
            return ended
        return ended + self._take(t_ns, came)

    def take(self, columns: OutputColumns) -> list[tuple[int, list[dict]]]:
        """Take stamps that rise; return the records of tries that end with each, by its place."""
        t_ns, ended, first = columns.t_ns, [], 0
        beside = {
            place: {topic: message for topic, _, message in messages}
            for place, messages in columns.beside
        }
        silent = np.flatnonzero(np.diff(t_ns) > PEG_CHANGE_NS) + 1 if len(t_ns) > 1 else t_ns[1:]
        alone = sorted({0, *beside, *silent.tolist()})
        while first < len(t_ns):
            if first and first not in beside and self._held is None:
                until = next((i for i in alone if i >= first), len(t_ns))
                quiet = self._take_quiet(columns, first, until)
                if quiet:
                    first += quiet
                    continue
            came = _came(columns, first, beside.get(first, {}))
            records = self._add(int(t_ns[first]), came)
            if records:
                ended.append((first, records))
            first += 1
        return ended

    def _take_quiet(self, columns, first, until):
        """Take stamps as far as nothing begins or ends; return how many these are."""
        t_ns = columns.t_ns[first:until]
        started = self._start_ns is not None
        touching = self._mode in _TOUCHING or (started and self._mode == "unknown")
        if touching and not started:
            return 0
        if touching:
            self._open_ns, self._last_ns = None, int(t_ns[-1]) if len(t_ns) else self._last_ns
            self._add_all_loads(columns, slice(first, until))
        elif started:
            if self._open_ns is None:
                return 0
            t_ns = t_ns[: np.searchsorted(t_ns, self._open_ns + PAUSE_NS)]
        if len(t_ns):
            self._seen_ns = int(t_ns[-1])
            self._passed.take_all(t_ns)
        return len(t_ns)

    def _add_all_loads(self, columns, places):
        loads = columns.normal[places][columns.determined[places]]
        if self._mode != "three_point" or not len(loads):
            return
        for i, most in enumerate(loads.max(axis=0).tolist()):
            self._peak[i] = max(self._peak[i], most)
            # One after the other, as they would come.
            self._sum[i] = float(np.cumsum(np.append(self._sum[i], loads[:, i]))[-1])
        self._count += len(loads)

    def _fall_silent(self):
        """End a try where the wrench fell silent."""
        record = self._end("unfinished" if self._open_ns is None else "aborted")
        self._mode, self._open_ns = "", None
        return [record]

    def _take(self, t_ns, came):
        fields = came.messages
        self._follow_search(t_ns, fields)
        self._seen_ns = t_ns
        # No time passes between the stamps before a fall and those after.
        ended = self._under_way() if self._passed.take(t_ns) else []
        if "contact_mode" in fields:
            self._mode = fields["contact_mode"]["data"]
        risen = fields.get("transition", {"data": self._flag})["data"] and not self._flag
        if "transition" in fields:
            self._flag = fields["transition"]["data"]
        touching = self._mode in _TOUCHING
        touching |= self._start_ns is not None and self._mode == "unknown"
        if touching:
            if self._start_ns is None:
                self._start(t_ns, came.touch)
            self._open_ns, self._last_ns = None, t_ns
            # What is no longer known, or let go, was not pulled out.
            self._inserted = self._mode == INSERTED or self._inserted and self._mode == "unknown"
            self._add_loads(came.loads)
        elif self._start_ns is not None:
            if self._mode == ELSEWHERE and t_ns - self._start_ns < CONTACT_DECIDED_NS:
                # It was no try: what touched first was not yet told from the hole.
                self._begin()
                return ended
            self._open_ns = t_ns if self._open_ns is None else self._open_ns
            if t_ns - self._open_ns >= PAUSE_NS:
                ended.append(self._end("aborted"))
        if risen and self._start_ns is not None:
            self._transition_ns = t_ns
        if "alarms" in fields:
            self._add_alarms(t_ns, fields["alarms"]["status"])
        return ended

    def _follow_search(self, t_ns, fields):
        """Add up how long the peg has touched elsewhere; a silence and a fall are no search."""
        mode = fields["contact_mode"]["data"] if "contact_mode" in fields else self._mode
        began, seen = self._elsewhere_ns, self._seen_ns
        if began is not None:
            broken = not 0 <= t_ns - seen <= PEG_CHANGE_NS
            if broken or mode != ELSEWHERE:
                until = seen if broken else t_ns
                self._searched_ns += until - began
                self._searched_until_ns, self._elsewhere_ns = until, None
        if mode == ELSEWHERE and self._elsewhere_ns is None:
            self._elsewhere_ns = t_ns

    def finish(self) -> list[dict]:
        """End all that is under way; return the records of tries that end so."""
        ended = []
        if self._held is not None:
            (held_ns, held), self._held = self._held, None
            ended = [*self._fall_silent(), *self._take(held_ns, held)]
        return ended + self._under_way()

    def _under_way(self):
        return [] if self._start_ns is None else [self._end("unfinished")]

    def _start(self, t_ns, touch):
        self._start_ns = t_ns
        age, latency = touch
        if isfinite(age) and isfinite(latency):
            self._start_ns, self._latency = t_ns - round(age * 1e9), latency
        until = self._searched_until_ns
        if until is not None and self._start_ns < until <= t_ns:
            # It touched elsewhere before: the try begins where that ended.
            self._start_ns, self._latency = until, 0.0

    def _add_loads(self, loads):
        if loads is None or self._mode != "three_point":
            return
        for i, normal in enumerate(loads):
            self._peak[i] = max(self._peak[i], normal)
            self._sum[i] += normal
        self._count += 1

    def _add_alarms(self, t_ns, statuses):
        for status in statuses:
            before = self._levels.get(status["name"], 0)
            self._levels[status["name"]] = status["level"]
            if status["level"] <= before or self._start_ns is None:
                continue
            self._alarm_count += 1
            if len(self._alarms) < MOST_CYCLE_ALARMS:
                self._alarms.append(
                    {
                        "time": _seconds(t_ns - self._start_ns),
                        "name": status["name"],
                        "level": ALARM_LEVELS[status["level"]],
                        "message": status["message"],
                    }
                )

    def _end(self, otherwise):
        since = self._transition_ns
        if self._inserted or (since is not None and self._flag and not self.depth_stated):
            outcome = "inserted"
        elif (since is None or self.depth_stated) and self._levels.get("jamming", 0) == 2:
            outcome = "jammed"
        else:
            outcome = otherwise
        known = self._count > 0
        peak = [round(most, _NEWTONS) for most in self._peak] if known else [None] * 3
        mean = [round(sum_ / self._count, _NEWTONS) for sum_ in self._sum] if known else peak
        ended = {
            "start_time": _seconds(self._start_ns),
            "contact_latency": round(self._latency, _SECONDS),
            "search_time": _seconds(self._searched_ns),
            "duration": _seconds(self._last_ns - self._start_ns),
            "outcome": outcome,
            "transition_time": None if since is None else _seconds(since - self._start_ns),
            "peak_normal": dict(zip(CONTACTS, peak)),
            "mean_normal": dict(zip(CONTACTS, mean)),
            "alarms": self._alarms,
            "alarm_count": self._alarm_count,
        }
        self._searched_ns, self._searched_until_ns = 0, None
        self._begin()
        return ended
