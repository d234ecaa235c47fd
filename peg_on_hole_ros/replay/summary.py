"""The figures of a replay, taken from the messages that the node would have published."""

import numpy as np

from peg_on_hole_ros.messages.columns import OutputColumns
from peg_on_hole_ros.messages.passed_time import PassedTime
from peg_on_hole_ros.records import ACCURACIES, ALARM_LEVELS, CONTACTS, UNOBSERVABLE_SETTINGS

VERSION = 1
# Why no reaction is told, though the outputs had some.
VOID = "they would rest on what the data contradict"
# An alarm that flickers would fill the summary; further changes are only counted.
MOST_ALARM_CHANGES = 1000


class Summary:
    """
    Collects from outputs what `--summary` tells.

    Time is what has passed: where stamps fall (a simulator that was reset, a bag played again) it
    goes on from where it was.

    Attributes
    ----------
    outputs : int

    """

    def __init__(self) -> None:
        self.outputs = 0
        self._passed = PassedTime()
        self._transition: float | None = None
        self._max_normal: list[float] | None = None
        self._untold: list[float] | None = None
        # Mean squares over the outputs with determined reactions [N^2].
        self._accuracies, self._determined = np.zeros(len(ACCURACIES)), 0
        self._levels: dict[str, int] = {}
        self._alarms: list[dict] = []
        self._alarm_changes = 0
        self._modes: dict[str, int] = {}
        self._mode = ""

    def take(self, columns: OutputColumns) -> None:
        """Take the outputs of stamps that rise."""
        n, t_ns = len(columns), columns.t_ns
        self.outputs += n
        self._passed.take(int(t_ns[0]))
        run = self._passed.runs[-1]
        normal = columns.normal[columns.determined]
        if len(normal):
            most = normal.max(axis=0).tolist()
            self._max_normal = list(map(max, self._max_normal or most, most))
        self._add_accuracies(columns["accuracy_doubt"][columns.determined])
        costs = columns["doubt"]
        known = costs[np.isfinite(costs).any(axis=1)]
        if len(known):
            self._untold = known[-1].tolist()
        begun = 0
        for i, messages in columns.beside:
            fields = {topic: message for topic, _, message in messages}
            passed = run.passed(int(t_ns[i])) * 1e-9
            if fields.get("transition", {"data": False})["data"] and self._transition is None:
                self._transition = passed
            if "contact_mode" in fields:
                self._count_mode(i - begun)
                self._mode, begun = fields["contact_mode"]["data"], i
            if "alarms" in fields:
                self._add_alarms(passed, fields["alarms"]["status"])
        self._count_mode(n - begun)
        self._passed.take_all(t_ns)

    def _add_accuracies(self, deviations):
        known = deviations[np.isfinite(deviations).all(axis=1)]
        # One after another, so that it is the same however many come at once.
        squares = np.vstack([self._accuracies, np.square(known)])
        self._accuracies = np.cumsum(squares, axis=0)[-1]
        self._determined += len(known)

    def _root_mean_square(self):
        if not self._determined:
            return [None] * len(ACCURACIES)
        return np.sqrt(self._accuracies / self._determined).tolist()

    def _count_mode(self, stamps):
        if stamps:
            self._modes[self._mode] = self._modes.get(self._mode, 0) + stamps

    def _add_alarms(self, passed, statuses):
        for status in statuses:
            before = self._levels.get(status["name"], 0)
            self._levels[status["name"]] = status["level"]
            if status["level"] == before:
                continue
            self._alarm_changes += 1
            if len(self._alarms) < MOST_ALARM_CHANGES:
                self._alarms.append(
                    {
                        "time": passed,
                        "name": status["name"],
                        "level": ALARM_LEVELS[status["level"]],
                        "message": status["message"],
                    }
                )

    def content(self) -> dict:
        """Return the part of the JSON that the outputs give; times are since the first output."""
        return {
            "outputs": self.outputs,
            "start_time": self._passed.first_ns * 1e-9,
            "duration": self._passed.ns * 1e-9,
            "transition_time": self._transition,
            "max_normal": dict(zip(CONTACTS, self._max_normal or [None] * 3)),
            "untold": dict(
                zip(UNOBSERVABLE_SETTINGS, self._untold or [None] * len(UNOBSERVABLE_SETTINGS))
            ),
            "accuracies": dict(zip(ACCURACIES, self._root_mean_square())),
            "contact_mode": {
                mode: count / self.outputs for mode, count in sorted(self._modes.items())
            },
            "alarms": self._alarms,
            "alarm_changes": self._alarm_changes,
        }


def without_reactions(content: dict) -> dict:
    """Return the JSON of a summary, its tries too, without a number that rests on reactions."""
    nothing = dict.fromkeys(CONTACTS)
    return content | {
        "reactions_void": VOID,
        "max_normal": nothing,
        "untold": dict.fromkeys(UNOBSERVABLE_SETTINGS),
        "accuracies": dict.fromkeys(ACCURACIES),
        "cycles": [
            cycle | {"peak_normal": nothing, "mean_normal": nothing} for cycle in content["cycles"]
        ],
    }
