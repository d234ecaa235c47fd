"""The figures of a replay, taken from the messages that the node would have published."""

from peg_on_hole_ros.edges.messages.output import Message
from peg_on_hole_ros.records import CONTACTS

VERSION = 1
# An alarm that flickers would fill the summary; further changes are only counted.
MOST_ALARMS = 1000


class Summary:
    """Collects from output messages what `--summary` tells."""

    def __init__(self):
        self.outputs = 0
        self.first_ns: int | None = None
        self.last_ns: int | None = None
        self._transition_ns: int | None = None
        self._max_normal = dict.fromkeys(CONTACTS, 0.0)
        self._levels: dict[str, int] = {}
        self._alarms: list[dict] = []
        self._alarm_changes = 0
        self._modes: dict[str, int] = {}
        self._mode = ""

    def add(self, t_ns: int, messages: list[Message]) -> None:
        """Take the messages of one stamp [ns]."""
        self.outputs += 1
        self.first_ns = t_ns if self.first_ns is None else self.first_ns
        self.last_ns = t_ns
        for topic, _, message in messages:
            if topic == "contacts":
                for name, normal in zip(message["name"], message["effort"]):
                    self._max_normal[name] = max(self._max_normal[name], normal)
            elif topic == "transition":
                if message["data"] and self._transition_ns is None:
                    self._transition_ns = t_ns
            elif topic == "contact_mode":
                self._mode = message["data"]
            elif topic == "alarms":
                self._add_alarms(t_ns, message["status"])
        self._modes[self._mode] = self._modes.get(self._mode, 0) + 1

    def _add_alarms(self, t_ns, statuses):
        for status in statuses:
            before = self._levels.get(status["name"], 0)
            self._levels[status["name"]] = status["level"]
            if status["level"] == before:
                continue
            self._alarm_changes += 1
            if len(self._alarms) < MOST_ALARMS:
                self._alarms.append(
                    {
                        "time": self._since_start(t_ns),
                        "name": status["name"],
                        "level": ("OK", "WARN", "ERROR")[status["level"]],
                        "message": status["message"],
                    }
                )

    def _since_start(self, t_ns):
        return (t_ns - self.first_ns) * 1e-9

    def content(self) -> dict:
        """Return the part of the JSON that the outputs give; times are since the first output."""
        transition = self._transition_ns
        return {
            "outputs": self.outputs,
            "start_time": self.first_ns * 1e-9,
            "duration": self._since_start(self.last_ns),
            "transition_time": None if transition is None else self._since_start(transition),
            "max_normal": self._max_normal,
            "contact_mode": {
                mode: count / self.outputs for mode, count in sorted(self._modes.items())
            },
            "alarms": self._alarms,
            "alarm_changes": self._alarm_changes,
        }
