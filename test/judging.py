"""Mode, flag, alarms and levels by themselves, over the compiled functions that a judge calls."""

from collections import namedtuple
from math import nan

import numpy as np

from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitor import evidence, states
from peg_on_hole_ros.monitor.alarm_text import alarms_of
from peg_on_hole_ros.monitor.alarms import clear_alarms, follow_alarms, follow_level
from peg_on_hole_ros.monitor.dangers.registry import Dangers, parts
from peg_on_hole_ros.monitor.memory import Memory
from peg_on_hole_ros.monitor.mode import declare_mode, forget_mode
from peg_on_hole_ros.monitor.settings import monitor_settings
from peg_on_hole_ros.monitor.states import MODES, Touch
from peg_on_hole_ros.monitor.transition import lower_flag, update_flag
from peg_on_hole_ros.typed_record import dtype_of, new


def values_of(kind):
    """Return a named tuple of the fields of a kind of record, to state and to compare values."""
    return namedtuple(kind.__name__, dtype_of(kind).names)


Shown = values_of(evidence.Shown)
# What is published of all dangers, and the contact of the load.
Risk = namedtuple("Risk", "wedging stall load risk determinant insertion margin loaded")


def record_of(kind, values):
    """Return a record of a kind with values by name."""
    record = new(kind)
    for name, value in values._asdict().items():
        setattr(record, name, value)
    return record


def risk_of(dangers):
    """Return what is published of dangers."""
    stuck, load = dangers.stuck, dangers.load
    numbers = dangers.wedging.determinant, stuck.insertion, stuck.margin
    return Risk(*parts(dangers), dangers.risk, *numbers, load.which)


def dangers_of(risk):
    """Return dangers of which this is published: in the hole where there is an insertion."""
    dangers = new(Dangers)
    dangers.wedging.determinant, dangers.risk = risk.determinant, risk.risk
    dangers.load.probability, dangers.load.which = risk.load, int(risk.loaded)
    if risk.insertion:
        stuck = dangers.stuck
        stuck.wedged, stuck.rests = risk.wedging, risk.stall
        stuck.probability = max(risk.wedging, risk.stall)
        stuck.insertion, stuck.margin = risk.insertion, risk.margin
    else:
        dangers.wedging.probability, dangers.stall.probability = risk.wedging, risk.stall
    return dangers


class Declared:
    """A memory of which one part is looked at."""

    def __init__(self, options):
        self.settings = monitor_settings(options, Scene(), 0.0)
        self.memory = new(Memory)
        self.declared, self.transition = self.memory.declared, self.memory.transition
        forget_mode(self.declared)
        lower_flag(self.transition)
        clear_alarms(self.memory.alarms)


class Mode(Declared):
    @property
    def mode(self):
        return MODES[self.declared.mode]

    @property
    def touch(self):
        """Whether contact came last or went, when, and how long it took; None before."""
        d = self.declared
        if d.touch_change == Touch.UNKNOWN:
            return None
        return d.touch_change == Touch.TOUCHING, d.touch_changed, d.touch_latency

    def update(self, t, shown):
        declare_mode(self.declared, self.settings, t, record_of(evidence.Shown, shown))
        return self.mode


class Flag(Declared):
    def update(self, t, below, touching):
        update_flag(self.transition, self.settings, t, below, touching)
        return bool(self.transition.flag)


class Alarms(Declared):
    def update(self, t, mode, risk, shown, normal):
        follow_alarms(
            self.memory.alarms, states.Mode(MODES.index(mode)), self.settings, t,
            dangers_of(risk), record_of(evidence.Shown, shown), np.array(normal),
        )  # fmt: skip
        return alarms_of(self.memory.alarms.published, nan, nan)


class Level(Declared):
    def __init__(self, warn, error, options):
        super().__init__(options)
        self.ends = warn, error

    def update(self, t, value):
        level = self.memory.alarms.levels[0]
        return follow_level(level, *self.ends, self.settings, t, float(value))
