"""A small world for the program of examples/insert.py: a peg that is where it is commanded."""

import math

import numpy as np

from benchmarks.loop.program import program_module

insert = program_module()
OPTIONS = insert.Options()
DT = 0.004


class World:
    """A peg that is where it is commanded, a plate, and a hole that lets it through."""

    def __init__(self, off=(0.0, 0.0), alarms=lambda world: ()):
        # Where three contacts have the lower end; the hole is off from there.
        tilted = insert.Program(OPTIONS)._above()
        self.off, self.alarms, self.t = tilted[:2] + off, alarms, 0.0
        self.command, self.commands = None, []
        self.plate = 0.5 * OPTIONS.peg_diameter * math.sin(OPTIONS.tilt)

    def seen(self):
        c = self.command
        if c is None:
            lean = -math.sin(OPTIONS.tilt) * np.array([1.0, 0.0])
            return insert.Seen(0.0, np.array([0.0, 0.0, 0.02]), lean, 0.0, 0.0, "open")
        tilt = np.linalg.norm(c.lean)
        h = np.array([math.cos(OPTIONS.psi), math.sin(OPTIONS.psi)])
        off = c.position[:2] - self.off
        along, across = off @ h, abs(off @ (-h[1], h[0]))
        # The rim stops the side of a peg that has dropped in.
        dropped = c.position[2] < self.plate - 0.0005
        over_hole = (along < 0.0012 and across < 0.0012 and dropped) or tilt < 0.19
        # On the plate, on the rim, or in the hole.
        floor = self.plate if not over_hole else (-0.0005 if tilt > 0.06 else -1.0)
        touches = c.position[2] < floor
        stopped = max(-0.0003 - along, 0.0) * h if over_hole and touches else np.zeros(2)
        position = np.array([*(c.position[:2] + stopped), max(c.position[2], floor)])
        mode = "open" if not touches else ("three_point" if over_hole else "elsewhere")
        alarms = self.alarms(self)
        level = max((each[1] for each in alarms), default=0)
        return insert.Seen(self.t, position, c.lean, c.spin, 10.0 * touches, mode,
                           tilt < 0.06, level, alarms)  # fmt: skip

    def run(self, program, seconds=60.0):
        while self.t < seconds and not program.outcome:
            self.command = program.step(self.seen())
            self.commands.append(self.command)
            self.t += DT
        return program

    def stages(self):
        names = [command.stage for command in self.commands]
        return [name for name, before in zip(names, [None, *names]) if name != before]


def while_aligning(level, text, first_only=True):
    def alarms(world):
        tilt = np.linalg.norm(world.command.lean)
        here = world.command.stage == "align" and 0.1 < tilt < 0.15
        first = "back_off" not in world.stages() or not first_only
        return (("jamming", level, text),) if here and first else ()

    return alarms
