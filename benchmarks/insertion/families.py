"""Families of insertions: how each draws its setting and what its holder is told to do."""

from math import cos, sin, sqrt
from typing import NamedTuple

from benchmarks.harness.draw import Draw
from peg_on_hole_ros.mechanics.scene import Scene

LEAD_IN = 0.05
# Of the push that would move a jammed peg.
LEAST_PUSH, MOST_PUSH = 0.5, 0.85


class Setting(NamedTuple):
    """What every family draws."""

    scene: Scene
    sensor_height: float  # [m]
    stiffness: float
    rotational_stiffness: float
    noise: float
    closing: float  # tilt's rate on three contacts [rad/s]
    slip: float  # phi' there [rad/s]
    azimuth: float  # psi [rad]

    @property
    def clearance(self) -> float:
        """Return D - d [m]."""
        return self.scene.hole_diameter - self.scene.peg_diameter


def setting_of(draw: Draw, **given) -> Setting:
    """Return a setting; `given` fixes friction, or relative clearance."""
    D = draw.even(0.014, 0.050)
    clearance = D * given.get("clearance", draw.log(1e-3, 8e-3))
    height = D * draw.even(1.5, 2.2)
    scene = Scene(
        hole_diameter=D,
        peg_diameter=D - clearance,
        peg_height=height,
        peg_mass=draw.even(0.2, 1.0),
        friction=given.get("friction", draw.even(0.1, 0.35)),
    )
    return Setting(
        scene=scene,
        sensor_height=height * draw.even(1.0, 1.5),
        stiffness=draw.log(5e3, 3e4),
        rotational_stiffness=draw.log(30.0, 200.0) * D / 0.05,
        noise=draw.log(0.5, 2.0),
        closing=min(draw.log(0.1, 0.4), 3 * scene.gamma0),
        slip=draw.sign() * draw.even(1.0, 3.0),
        azimuth=draw.even(-3.0, 3.0),
    )


class Program:
    """The holder's program of one scene, put together phase by phase."""

    def __init__(self, draw: Draw, setting: Setting):
        self.draw, self.setting, self.phases = draw, setting, {}
        self.turn = 0.0  # phi commanded [rad]
        self.depth = 0.0

    def begin(self):
        """Close on three contacts, and go through the transition on two; return the start."""
        s, draw = self.setting, self.draw
        gamma0, before = s.scene.gamma0, draw.even(0.05, 0.12)
        rates = [-s.closing, 0.0, s.slip]
        angles = [gamma0 + s.closing * (LEAD_IN + before), s.azimuth, 0.0]
        press = draw.even(5.0, 20.0) / s.stiffness
        self.phases["lead"] = {"kind": "insert", "duration": LEAD_IN, "rates": rates}
        self.phases["close"] = {"kind": "insert", "duration": before, "rates": rates}
        self.turn = s.slip * (LEAD_IN + before)
        return {"angles": angles, "rates": rates, "offset": [0.0, 0.0, -press]}

    def into(self, name, share, duration, rate, tilt, **more):
        """
        Go down to a share of the hole's diameter, to a tilt that depth leaves, times `tilt`.

        The end has `rate` [m/s] along the hole.
        """
        s = self.setting
        if self.depth == 0.0:
            # As far as the tilt takes it, at the rate at which it closed.
            first = min(share, 1.6 * s.scene.gamma0)
            left = self.left(first)
            through = 1.5 * (s.scene.gamma0 - left) / s.closing
            self._phase("through", max(through, 0.05), left, depth=first * s.scene.hole_diameter)
        depth, left = share * s.scene.hole_diameter, self.left(share)
        self._phase(name, duration, left * tilt, depth=depth, depth_rate=rate, **more)

    def left(self, share):
        """Return the tilt at which rim and edge touch a share of the diameter deep [rad]."""
        s = self.setting
        # Of l sin(gamma) = D - d cos(gamma), the lower end's centre half of d sin(gamma) above.
        return min(s.clearance / (share * s.scene.hole_diameter), s.scene.gamma0)

    def _phase(self, name, duration, gamma, slip=0.0, depth=None, **more):
        self.turn += slip * duration if slip else 0.0
        phase = {
            "kind": "insert", "duration": duration, "rates": [0.0, 0.0, slip],
            "angles": [gamma, self.setting.azimuth, self.turn], **more,
        }  # fmt: skip
        if depth is not None:
            phase["depth"] = self.depth = depth
        self.phases[name] = phase

    def hold(self, name, duration, **more):
        """Stay as it is, or change what is given."""
        last = list(self.phases.values())[-1]
        gamma = more.pop("gamma", last["angles"][0])
        self._phase(name, duration, gamma, depth=more.pop("depth", self.depth), **more)

    def aside(self, force):
        """Return the place whose way to the side pulls with a force along the tilt [N]."""
        way = -force / self.setting.stiffness
        psi = self.setting.azimuth
        return [way * cos(psi), way * sin(psi)]

    def kept(self, force, share):
        """
        Return the push that friction keeps where a side load presses rim and edge [N].

        The side load at the sensor, with both contacts at a share of the hole's diameter deep.
        """
        s = self.setting
        depth, f = share * s.scene.hole_diameter, s.scene.friction
        at_edge = force * (s.sensor_height - depth) / depth
        at_rim = at_edge + force
        return f * (at_edge + at_rim)


def _normal(draw):
    setting = setting_of(draw)
    program = Program(draw, setting)
    start = program.begin()
    D = setting.scene.hole_diameter
    speed = draw.log(0.02, 0.06)
    # Tilted on two points, or past the middle with next to no load.
    tilt = draw.even(0.0, 3.0)
    turning = setting.slip if draw.chance(0.4) else 0.0
    first, deep = draw.even(0.35, 0.5), draw.even(1.12, 1.3)
    side = {"place": program.aside(draw.even(-4.0, 4.0))}
    program.into("go_in", first, 1.6 * first * D / speed, speed, tilt, slip=turning, **side)
    last = 1.4 * (deep - first) * D / speed
    farther = (deep + 0.05) * D
    if draw.chance(0.35):
        # Along one wall: the side load acts half way down, by the holder's moment.
        force = draw.log(2.0, 15.0)
        lean = force * (setting.sensor_height - deep * D / 2) / setting.rotational_stiffness
        program.hold(
            "along_one_wall", last, gamma=lean, slip=turning, depth=deep * D, depth_rate=speed,
            place=program.aside(-force),
        )  # fmt: skip
    else:
        program.into("down", deep, last, speed, tilt, slip=turning, **side)
    # Let go of before it rests: at rest under a push it would be stuck.
    program.hold("let_go", draw.even(0.05, 0.1), gamma=0.0, place=[0.0, 0.0], depth=farther)
    program.hold("rest", draw.even(0.05, 0.15))
    return setting, start, program.phases


def _pushed_aside(draw, program, force, share):
    """Come to rest at some depth, load the side, then push, though not enough to move."""
    setting = program.setting
    D = setting.scene.hole_diameter
    speed = draw.log(0.03, 0.08)
    program.into("go_in", share, 1.7 * share * D / speed, 0.0, 1.0)
    program.hold("settle", 0.08)
    aside = program.aside(force)
    push = draw.even(LEAST_PUSH, MOST_PUSH) * program.kept(force, share)
    weight = setting.scene.peg_mass * 9.80665
    way = max(push - weight, 0.0) / setting.stiffness
    if draw.chance(0.5):
        program.hold("side_load", draw.even(0.1, 0.2), place=aside)
        program.hold("push", draw.even(0.08, 0.2), depth=program.depth + way)
    else:
        program.hold("feed_aslant", draw.even(0.15, 0.3), place=aside, depth=program.depth + way)
    program.hold("pushing", draw.even(0.25, 0.5))


def _jammed(draw):
    setting = setting_of(draw, friction=draw.even(0.15, 0.4))
    program = Program(draw, setting)
    start = program.begin()
    _pushed_aside(draw, program, draw.log(12.0, 40.0), draw.even(0.35, 0.8))
    return setting, start, program.phases


def _squeezed(draw, program):
    """Tilt a peg that is hardly in against rim and wall, let it go, and push."""
    s = program.setting
    D, f = s.scene.hole_diameter, s.scene.friction
    # Wedging needs a depth below f d; it begins at D sin(gamma0).
    least = sqrt(2 * s.clearance / D)
    share = draw.even(1.1 * least, max(0.7 * f, 1.15 * least))
    program.into("go_in", share, draw.even(0.15, 0.25), 0.0, 1.0)
    program.hold("settle", 0.06)
    depth, load = share * D, draw.log(60.0, 250.0)
    left = program.left(share)
    more = load * depth / s.rotational_stiffness
    program.hold("squeeze", draw.even(0.1, 0.2), gamma=left + more)
    program.hold("let_go", draw.even(0.1, 0.2), gamma=left)
    push = draw.even(0.3, 0.6) * f * load
    program.hold("push", draw.even(0.08, 0.2), depth=program.depth + push / s.stiffness)
    program.hold("pushing", draw.even(0.25, 0.5))


def _wedged(draw):
    f = draw.even(0.2, 0.45)
    # So tight that the peg is in before it is as deep as friction holds it.
    setting = setting_of(draw, friction=f, clearance=draw.log(1e-3, 0.12 * f * f))
    program = Program(draw, setting)
    start = program.begin()
    _squeezed(draw, program)
    return setting, start, program.phases


def _freed(draw):
    """Return a peg that is stuck, and one of the ways out of it."""
    wedges = draw.chance(0.3)
    f = draw.even(0.2, 0.4)
    clearance = draw.log(1e-3, 0.12 * f * f) if wedges else draw.log(1e-3, 8e-3)
    setting = setting_of(draw, friction=f, clearance=clearance)
    program = Program(draw, setting)
    start = program.begin()
    if wedges:
        _squeezed(draw, program)
    else:
        _pushed_aside(draw, program, draw.log(12.0, 40.0), draw.even(0.35, 0.7))
    way = draw.even(0.0, 3.0)
    if way < 1.0:
        program.hold("turn", draw.even(0.25, 0.4), slip=draw.sign() * draw.even(1.0, 4.0))
    elif way < 2.0:
        _wiggle(draw, program)
    else:
        program.hold("less_side_force", draw.even(0.1, 0.2), place=[0.0, 0.0], gamma=0.0)
    farther = program.depth + 0.15 * setting.scene.hole_diameter
    program.hold("go_on", draw.even(0.25, 0.4), depth=farther)
    program.hold("rest", 0.1, depth=None, depth_rate=0.0)
    return setting, start, program.phases


def _wiggle(draw, program):
    """Swing the tilt to and fro about what clears both contacts."""
    last = list(program.phases.values())[-1]
    gamma = last["angles"][0]
    s = program.setting
    swing = draw.even(0.5, 1.2) * max(gamma, 0.3 * s.clearance / program.depth)
    place = last.get("place", [0.0, 0.0])
    for k in range(3):
        away = [-0.5 * x for x in place]
        program.hold(f"wiggle_{k}", 0.06, gamma=max(gamma - swing, 0.0), place=away)
        program.hold(f"wiggle_back_{k}", 0.06, gamma=gamma, place=[0.5 * x for x in place])


FAMILY = {"normal": _normal, "jammed": _jammed, "wedged": _wedged, "freed": _freed}
