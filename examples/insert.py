"""
Insert a peg: touch, search the hole, align and go in, by what the monitor of the peg tells.

    python examples/insert.py --ros-args -p plan:=plan.json -r current_pose:=/arm/current_pose

The robot's controller holds the peg on springs; it takes `target_frame` and sends `current_pose`
(PoseStamped, as Cartesian controllers do), both of the peg's lower end in the frame `hole`.
`Program` decides and knows no ROS, `Insert` is the node around it. It reads contact_mode,
transition, alarm_level, alarms and contacts of the monitor, announces what it `expect`s before a
contact ends, and tares in the air. Speeds and pushes are those of a peg of 50 mm.
"""

import json
import re
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, String, UInt8
from std_srvs.srv import Trigger

WARN, ERROR = 1, 2
STILL = lambda dt: None  # noqa: E731
NEVER = lambda seen: False  # noqa: E731


@dataclass(frozen=True)
class Options:
    """What is told of the job [m], [rad], [s], [N]; without the last three it is a plain one."""

    hole_diameter: float = 0.050
    peg_diameter: float = 0.0498
    tilt: float = 0.2
    psi: float = 0.3  # where the peg leans to
    closing_rate: float = 0.15
    press: tuple = (0.0015, 0.004)  # how far the springs are led beyond the rim, across and along
    lead: float = 0.004  # how far the springs are turned beyond where the peg is
    above: float = 0.006
    depth: float = 0.010
    force_limit: float = 120.0  # of the controller
    tries: int = 2
    stop_on_error: bool = True
    follow_warn: bool = True
    plan: dict | None = None  # of `peg-on-hole plan --json`


class Seen(NamedTuple):
    """What is known at a moment: pose by the robot, force by the sensor, the rest as published."""

    t: float
    position: np.ndarray
    lean: np.ndarray  # x, y of the peg's axis in the hole
    spin: float
    force: float
    mode: str = "unknown"
    transition: bool = False
    level: int = 0
    alarms: tuple = ()  # (name, level, text) of each
    loads: tuple = ()  # normal reactions, NaN where they are not determined


class Command(NamedTuple):
    """Where the peg shall be, and what is said to the monitor."""

    position: np.ndarray
    lean: np.ndarray
    spin: float
    stage: str
    expect: str = ""
    tare: bool = False


class Stopped(Exception):
    """The try has to end; says why."""


class Program:
    """The deciding part: `step` takes what is seen and returns what is commanded."""

    def __init__(self, options: Options):
        self.o, self.stage, self.outcome, self.tried, self.stops = options, "start", "", 0, []
        self._tilt = options.plan["start"]["tilt"] if options.plan else options.tilt
        self._h = np.array([np.cos(options.psi), np.sin(options.psi)])
        self._leaned = -np.sin(self._tilt) * self._h
        self._plate = 0.5 * options.peg_diameter * np.sin(self._tilt)
        self._hole, self._turn, self._slower = np.zeros(2), 0.0, 1.0
        self._expect, self._tare, self._watching = "", False, False
        self._steps = self._insert()
        next(self._steps)

    def step(self, seen: Seen) -> Command:
        """Decide; to be called some 100 times a second and more."""
        return self._steps.send(seen)

    def wait_for(self, done, within, move=STILL):
        """Move until `done` of what is seen; return whether it was so within this time [s]."""
        until = self.seen.t + within
        while not done(self.seen):
            if self.seen.t >= until:
                return False
            move(self._dt)
            at = self._at.copy(), self._lean.copy(), self._spin
            command = Command(*at, self.stage, self._expect, self._tare)
            self._expect, self._tare, before = "", False, self.seen.t
            self.seen = yield command
            self._dt = self.seen.t - before
            self._check()
        return True

    def _check(self):
        """End the try on the controller's force limit, and on what the monitor says."""
        if self._watching and self.seen.force > self.o.force_limit:
            raise Stopped(f"force limit: {self.seen.force:.0f} N")
        if self._watching and self.o.stop_on_error and self.seen.level >= ERROR:
            # Level and texts are two topics: the level may come first.
            told = (f"{name}: {text}" for name, level, text in self.seen.alarms if level >= ERROR)
            raise Stopped("; ".join(told) or "an alarm is ERROR")
        if self._watching and "lift the peg off" in self._advice():
            raise Stopped("no motion keeps the limits")

    def _advice(self):
        """Return what alarms of level WARN and above say, where that is followed."""
        told = self.seen.alarms if self.o.follow_warn else ()
        return "; ".join(text for _, level, text in told if level >= WARN)

    def _advised(self):
        """Return closing rate, turn [rad/s] and share of the push that are advised, or None."""
        text = self._advice()
        asked = r"close at ([\d.]+) rad/s", r"turn at ([\d.]+) rad/s", r"at most (\d+)%"
        found = [re.search(pattern, text) for pattern in asked]
        close, turn, push = (float(each[1]) if each else None for each in found)
        if close is None and turn is None and "do not close" in text:
            close, turn = 0.02, 0.15
        if turn is None and "turn it about" in text:
            turn = 0.15
        if push is None and "reduce the force" in text:
            push = 50.0
        return close, turn, 1.0 if push is None else push / 100.0

    def _insert(self):
        self.seen = yield
        self._at, self._lean = self.seen.position.copy(), self.seen.lean.copy()
        self._spin, self._dt = self.seen.spin, 0.0
        while not self.outcome and self.tried < self.o.tries:
            self.tried += 1
            try:
                for part in (self._hang, self._touch, self._search, self._align, self._go_in):
                    self.stage = part.__name__.strip("_")
                    yield from part()
                self.outcome = "inserted"
            except Stopped as why:
                self.stops.append((self.seen.t, self.stage, str(why)))
                self.stage, self._slower = "back_off", 0.6 * self._slower
                yield from self._back_off()
        self.outcome = self.outcome or "given up"
        self.stage, self._watching = self.outcome, False
        while True:
            yield from self.wait_for(NEVER, 1e9)

    def _to(self, position, lean, speed=0.03):
        """Return a motion there with a speed [m/s]; it turns by up to 0.4 rad/s."""

        def move(dt):
            off, turn = position - self._at, lean - self._lean
            self._at += off * min(1.0, speed * dt / max(np.linalg.norm(off), 1e-9))
            self._lean += turn * min(1.0, 0.4 * dt / max(np.linalg.norm(turn), 1e-9))

        return move

    def _hang(self):
        """Hang in the air above the hole, and tare there."""
        place = self._above()
        there = lambda seen: np.allclose(self._at, place, atol=1e-6)  # noqa: E731
        yield from self.wait_for(there, 5.0, self._to(place, self._leaned))
        yield from self.wait_for(NEVER, 0.6, self._to(place, self._leaned))
        yield from self.wait_for(lambda seen: seen.mode == "open", 0.5)
        self._tare = True
        yield from self.wait_for(NEVER, 0.05)

    def _touch(self):
        self._watching = True
        down = self._to(np.append(self._at[:2], -0.01), self._leaned, 0.012)
        if not (yield from self.wait_for(lambda seen: seen.force > 5.0, 4.0, down)):
            raise Stopped("nothing touched")

    def _search(self):
        """Press on the plate along a spiral, until the peg drops onto the rim; press it on."""
        centre, angle = self._at.copy(), 0.0
        centre[2] = self.seen.position[2] - 0.003

        def spiral(dt):
            nonlocal angle
            radius = 0.0006 * angle / (2 * np.pi)
            angle += 0.012 * dt / max(radius, 0.0003)
            there = radius * np.cos(angle), radius * np.sin(angle), 0.0
            self._to(centre + there, self._leaned, 0.02)(dt)

        def in_mouth(seen):
            return seen.mode == "three_point" or seen.position[2] < self._plate - 0.0015

        if not (yield from self.wait_for(in_mouth, 6.0, spiral)):
            raise Stopped("no hole found")
        self._hole = self.seen.position[:2] - self._seat(self._tilt)[0] * self._h
        on = self._to(self._pressed(self._tilt, 1.0), self._leaned)
        yield from self.wait_for(NEVER, 0.3, on)
        yield from self.wait_for(lambda seen: seen.mode == "three_point", 0.5)
        self._hole = self.seen.position[:2] - self._seat(self._tilt)[0] * self._h

    def _seat(self, tilt):
        """Return where three contacts, or the mouth, have the lower end, along h and z."""
        D, d = self.o.hole_diameter, self.o.peg_diameter
        gamma0 = np.arccos(d / D)
        s, c = np.sin(max(tilt, gamma0)), np.cos(max(tilt, gamma0))
        into = min(tilt / gamma0, 1.0)
        return (D - d * c) / (2 * s) * into, (d - D * c - (D - d * c) * c) / (2 * s), into

    def _above(self):
        """Return the place above that on three contacts."""
        seat = self._hole + self._seat(self._tilt)[0] * self._h
        return np.append(seat, self._plate + self.o.above)

    def _pressed(self, tilt, push):
        """Return that place with a share of the push beyond it."""
        h, z, into = self._seat(tilt)
        across, along = self._slower * push * np.array(self.o.press)
        return np.append(self._hole + (h - across * into) * self._h, z - along)

    def _rates(self, tilt):
        """Return closing rate and turn [rad/s] of the plan, or of a plain closing."""
        if not self.o.plan:
            return self._slower * self.o.closing_rate, self._turn
        stages = self.o.plan["stages"]
        rates = next((each for each in stages if each["tilt"] < tilt), stages[-1])["rates"]
        return self._slower * max(-rates["gamma"], 0.01), rates["phi"] or self._turn

    def _align(self):
        """Close the tilt under a push; a WARN slows, turns or presses less."""
        self._expect, tilt, push = "insertion", self._tilt, 1.0

        def close(dt):
            nonlocal tilt, push
            rate, turn = self._rates(tilt)
            slower, turned, less = self._advised()
            self._turn = turn if turned is None else turned
            push += np.clip(less - push, -10.0 * dt, 2.0 * dt)
            tilt = max(tilt - (rate if slower is None else min(slower, rate)) * dt, 0.0)
            self._spin += self._turn * dt
            # Springs that lead far wedge the peg with a moment that no force shows.
            tilt = max(tilt, np.arcsin(-self.seen.lean @ self._h) - self.o.lead)
            self._lean, self._at = self._led(-np.sin(tilt) * self._h), self._pressed(tilt, push)

        def closed(seen):
            return tilt <= 0.0 or seen.transition or seen.mode in ("two_point", "inserted")

        yield from self.wait_for(closed, 6.0, close)

    def _led(self, lean):
        """Return a lean that is no farther than the lead from that of the peg."""
        off = lean - self.seen.lean
        return self.seen.lean + off * min(1.0, self.o.lead / max(np.linalg.norm(off), 1e-9))

    def _go_in(self):
        """Let side force and moment go, then push along the hole: on a WARN slower and softer."""

        def go_in(dt):
            slow, soon = (0.005, 0.05) if self._advice() else (0.02, 0.15)
            share = min(dt / soon, 1.0)
            self._at[:2] += share * (self.seen.position[:2] - self._at[:2])
            self._lean = self._led(self._lean + share * (self.seen.lean - self._lean))
            self._at[2] -= slow * self._slower * dt * pushes
            self._at[2] = max(self._at[2], self.seen.position[2] - 0.006)
            self._spin += self._turn * dt

        pushes, self._at[2] = False, self.seen.position[2] - 0.001
        yield from self.wait_for(NEVER, 0.2, go_in)
        pushes = True
        deep = lambda seen: seen.mode == "inserted" or -seen.position[2] > self.o.depth  # noqa: E731
        if not (yield from self.wait_for(deep, 2.0, go_in)):
            raise Stopped("not in")

    def _back_off(self):
        """Let the springs go, pull out along the hole, tilt back and lift off."""
        self._expect, self._watching = "lift_off", False
        self._at, self._lean = self.seen.position.copy(), self.seen.lean.copy()
        out = self._to(np.append(self._at[:2], 0.0), self._lean.copy())
        yield from self.wait_for(lambda seen: seen.position[2] > -0.002, 4.0, out)
        up = self._above()
        off = self._to(up, self._leaned)
        yield from self.wait_for(lambda seen: seen.position[2] > up[2] - 0.002, 4.0, off)


def quaternion(lean, spin):
    """Return x, y, z, w of a peg that leans like this and has turned about its own axis."""
    half, c, s = np.sqrt((1 + np.sqrt(1 - lean @ lean)) / 2), np.cos(spin / 2), np.sin(spin / 2)
    x, y = -lean[1] / (2 * half), lean[0] / (2 * half)
    return c * x + s * y, c * y - s * x, s * half, c * half


def lean_and_spin(q):
    """Return lean and spin of a quaternion."""
    lean = np.array([2 * (q.x * q.z + q.w * q.y), 2 * (q.y * q.z - q.w * q.x)])
    return lean, 2 * np.arctan2(q.z, q.w)


class Insert(Node):
    """The node around the program: what it has heard last is what the program sees."""

    def __init__(self):
        super().__init__("insert")
        stated, self._heard, self._force, self._zero = {}, {}, np.zeros(3), np.zeros(3)
        for name, usual in vars(Options()).items():
            stated[name] = self.declare_parameter(name, "" if usual is None else usual).value
        stated["plan"] = json.loads(Path(stated["plan"]).read_text()) if stated["plan"] else None
        self.program, of = Program(Options(**stated)), "/peg_on_hole/"
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        topics = (
            (PoseStamped, "current_pose", 10), (WrenchStamped, "/wrench", 10),
            (String, of + "contact_mode", latched), (Bool, of + "transition", latched),
            (UInt8, of + "alarm_level", latched), (DiagnosticArray, of + "alarms", 10),
            (JointState, of + "contacts", 10),
        )  # fmt: skip
        for kind, topic, qos in topics:
            name = topic.rpartition("/")[2]
            self.create_subscription(kind, topic, partial(self._heard.__setitem__, name), qos)
        self._topics = len(topics)
        self._target = self.create_publisher(PoseStamped, "target_frame", 10)
        self._expect = self.create_publisher(String, of + "expect", 10)
        self._tare = self.create_client(Trigger, of + "tare")
        self.create_timer(0.005, self._decide)

    def _seen(self):
        heard, pose = self._heard, self._heard["current_pose"].pose
        p, f = pose.position, heard["wrench"].wrench.force
        self._force += 0.2 * (np.array([f.x, f.y, f.z]) - self._force)
        return Seen(
            self.get_clock().now().nanoseconds * 1e-9, np.array([p.x, p.y, p.z]),
            *lean_and_spin(pose.orientation), float(np.linalg.norm(self._force - self._zero)),
            heard["contact_mode"].data, heard["transition"].data, heard["alarm_level"].data,
            tuple((a.name, a.level[0], a.message) for a in heard["alarms"].status),
            tuple(heard["contacts"].effort),
        )  # fmt: skip

    def _decide(self):
        # Begins once all is heard, and whoever is told something is there.
        there = self._tare.service_is_ready() and self._expect.get_subscription_count()
        if not there or len(self._heard) < self._topics:
            return
        stage, command = self.program.stage, self.program.step(self._seen())
        if command.stage != stage:
            self.get_logger().info(f"{command.stage} {self.program.stops[-1:]}")
        if command.expect:
            self._expect.publish(String(data=command.expect))
        if command.tare:
            self._tare.call_async(Trigger.Request())
            self._zero = self._force.copy()
        target = PoseStamped()
        target.header.frame_id = "hole"
        p, q = target.pose.position, target.pose.orientation
        p.x, p.y, p.z = command.position.tolist()
        q.x, q.y, q.z, q.w = map(float, quaternion(command.lean, command.spin))
        self._target.publish(target)


def main():
    """Run until the program has an outcome."""
    rclpy.init()
    node = Insert()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        while not node.program.outcome:
            rclpy.spin_once(node)
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
