"""Mode, flag, alarms and levels by themselves, over the compiled functions that a judge calls."""

import numpy as np

from peg_on_hole_ros.monitor.alarm_text import alarms_of
from peg_on_hole_ros.monitor.alarms import clear_alarms, follow_alarms, follow_level
from peg_on_hole_ros.monitor.judgement import MEMORY
from peg_on_hole_ros.monitor.memory import MODES, thresholds
from peg_on_hole_ros.monitor.mode import declare_mode, forget_mode
from peg_on_hole_ros.monitor.transition import lower_flag, raise_flag


def floats(values):
    return values._make(map(float, values))


class Declared:
    """A memory of which one part is looked at."""

    def __init__(self, options):
        self.thresholds = thresholds(options)
        self.memory = np.zeros(1, MEMORY)[0]
        self.record = self.memory["declared"][0]
        forget_mode(self.record)
        lower_flag(self.record)
        clear_alarms(self.memory)


class Mode(Declared):
    @property
    def mode(self):
        return MODES[self.record["mode"]]

    @property
    def touch(self):
        """Whether contact came last or went, when, and how long it took; None before."""
        onset, turned, latency = (self.record[name] for name in ("onset", "turned", "latency"))
        return None if onset < 0 else (bool(onset), turned, latency)

    def update(self, t, shown):
        declare_mode(self.record, self.thresholds, t, floats(shown))
        return self.mode


class Flag(Declared):
    def update(self, t, below, touching):
        raise_flag(self.record, self.thresholds, t, below, touching)
        return bool(self.record["flag"])


class Alarms(Declared):
    def update(self, t, mode, risk, shown, normal):
        self.record["mode"] = MODES.index(mode)
        follow_alarms(
            self.memory, self.thresholds, t, floats(risk), floats(shown), np.array(normal)
        )
        return alarms_of(self.memory["said"])


class Level(Declared):
    def __init__(self, warn, error, options):
        super().__init__(options)
        self.ends = warn, error

    def update(self, t, value):
        return follow_level(self.memory["levels"][0], *self.ends, self.thresholds, t, value)
