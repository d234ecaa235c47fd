"""
Insert a peg: touch, search the hole, align and go in, with the topics of the contact monitor.

    python examples/insert.py --ros-args -p plan:=plan.json -r current_pose:=/arm/current_pose

The robot's controller holds the peg on springs. It takes `target_frame` and sends `current_pose`
(PoseStamped, as Cartesian controllers do), both of the peg's lower end in the frame `hole`.
`Program` decides and knows no ROS, `Insert` is the node around it. Speeds and pushes are those of
a peg of 50 mm.
"""

import json
import re
import sys
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
from std_msgs.msg import Bool, String, UInt8
from std_srvs.srv import Trigger

WARN, ERROR = 1, 2
# What the text of an alarm advises: closing rate, turn [rad/s], share of the push [%].
ADVICE = r"close at ([\d.]+)", r"turn at ([\d.]+)", r"at most (\d+)%"


@dataclass(frozen=True)
class Options:
    """The job [m], [rad], [s], [N]. Without the last four it is a plain program."""

    hole_diameter: float = 0.050
    peg_diameter: float = 0.0498
    tilt: float = 0.2
    psi: float = 0.3  # azimuth to which the peg leans
    closing_rate: float = 0.15
    press: tuple = (0.003, 0.004)  # how far the springs are led beyond the rim, across and along
    lead: float = 0.004  # how far the springs are turned ahead of the peg
    above: float = 0.006
    depth: float = 0.010
    force_limit: float = 120.0  # of the controller
    tries: int = 2
    follow_modes: bool = True
    stop_on_error: bool = True
    follow_warn: bool = True
    plan: dict | None = None  # of `peg-on-hole plan --json`


class Seen(NamedTuple):
    """The pose by the robot, the force by the sensor, and the last messages of the monitor."""

    t: float
    position: np.ndarray
    lean: np.ndarray  # x, y of the peg's axis in the hole
    spin: float
    force: float
    mode: str = "unknown"
    transition: bool = False
    level: int = 0
    alarms: tuple = ()  # (name, level, text) of each


class Command(NamedTuple):
    """Where the peg shall be, and what the monitor is asked or announced."""

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
        self._hole, self._slower, self._turn = np.zeros(2), 1.0, 0.0
        self._expect, self._tare, self._watching = "", False, False
        self._steps = self._insert()
        next(self._steps)

    def step(self, seen: Seen) -> Command:
        """Decide; to be called some 100 times a second and more."""
        return self._steps.send(seen)

    def wait_for(self, done, within, move=lambda dt: None):
        """Move until `done(seen)`; return whether it was so within this time [s]."""
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

    def wait(self, seconds, *move):
        """Move for a time."""
        yield from self.wait_for(lambda seen: False, seconds, *move)

    def _check(self):
        """End the try on the controller's force limit, and on an alarm at ERROR."""
        if not self._watching:
            return
        if self.seen.force > self.o.force_limit:
            raise Stopped(f"force limit: {self.seen.force:.0f} N")
        if self.o.stop_on_error and self.seen.level >= ERROR:
            # Level and texts are two topics: the level may come first.
            texts = (f"{name}: {text}" for name, level, text in self.seen.alarms if level >= ERROR)
            raise Stopped("; ".join(texts) or "an alarm is ERROR")

    def _warned(self):
        """Return what alarms at WARN and above advise; empty: there are none, or not followed."""
        alarms = self.seen.alarms if self.o.follow_warn else ()
        return "; ".join(f"{name}: {text}" for name, level, text in alarms if level >= WARN)

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
        yield from self.wait(np.inf)

    def _to(self, position, lean, speed=0.03):
        """Return a motion there with a speed [m/s]; it turns by up to 0.4 rad/s."""

        def move(dt):
            self._at = near(position, self._at, speed * dt)
            self._lean = near(near(lean, self._lean, 0.4 * dt), self.seen.lean, 0.02)

        return move

    def _hang(self):
        """Hang in the air above the hole, and tare there."""
        place = self._above()
        move = self._to(place, self._leaned)
        yield from self.wait_for(lambda seen: np.allclose(self._at, place, atol=1e-6), 5.0, move)
        yield from self.wait(0.6, move)
        self._tare = True
        yield from self.wait(0.05)

    def _touch(self):
        self._watching = True
        down = self._to(np.append(self._at[:2], -0.01), self._leaned, 0.012)
        if not (yield from self.wait_for(lambda seen: seen.force > 5.0, 4.0, down)):
            raise Stopped("nothing touched")

    def _search(self):
        """Press along a spiral until the edge drops into the hole; lay the side on the rim."""
        centre, angle = self._at.copy(), 0.0
        centre[2] = self.seen.position[2] - 0.003

        def spiral(dt):
            nonlocal angle
            radius = 0.0006 * angle / (2 * np.pi)
            angle += 0.012 * dt / max(radius, 0.0003)
            there = radius * np.cos(angle), radius * np.sin(angle), 0.0
            self._to(centre + there, self._leaned, 0.02)(dt)

        edge = self._plate - 0.0015
        if not (yield from self.wait_for(lambda seen: seen.position[2] < edge, 6.0, spiral)):
            raise Stopped("no hole found")
        self._at[2] = self.seen.position[2] - 0.5 * self.o.press[1]

        def aside(dt):
            self._at[:2] -= 0.006 * dt * self._h

        def lies_on(seen):
            # Friction of a light push holds the springs back by less than this.
            return (seen.position - self._at)[:2] @ self._h > 0.0015

        yield from self.wait_for(lies_on, 1.5, aside)
        self._hole = self.seen.position[:2] - self._seat(self._tilt)[0] * self._h
        yield from self.wait(0.2, self._to(self._pressed(self._tilt), self._leaned))

    def _seat(self, tilt):
        """Return where three contacts, or the mouth, have the lower end, along h and z."""
        D, d = self.o.hole_diameter, self.o.peg_diameter
        gamma0 = np.arccos(d / D)
        s, c = np.sin(max(tilt, gamma0)), np.cos(max(tilt, gamma0))
        into = min(tilt / gamma0, 1.0)
        return (D - d * c) / 2 * into, (d - D * c - (D - d * c) * c) / (2 * s), into

    def _above(self):
        """Return the place above that on three contacts."""
        seat = self._hole + self._seat(self._tilt)[0] * self._h
        return np.append(seat, self._plate + self.o.above)

    def _pressed(self, tilt, push=1.0):
        """Return that place with a share of the push beyond it."""
        h, z, into = self._seat(tilt)
        across, along = self._slower * push * np.array(self.o.press)
        return np.append(self._hole + (h - across * into) * self._h, z - along)

    def _rates(self, tilt):
        """Return closing rate and turn [rad/s] of the plan, or of a plain closing."""
        if not self.o.plan:
            # What has jammed without a turn is tried with one.
            turn = 0.2 if self.o.follow_warn and self.tried > 1 else 0.0
            return self._slower * self.o.closing_rate, turn

        def planned(tilt):
            stages = self.o.plan["stages"]
            return next((each for each in stages if each["tilt"] < tilt), stages[-1])["rates"]

        closing = max(-planned(tilt)["gamma"], 0.01)
        # The monitor foresees the present motion: it has to see a turn before that matters.
        ahead = 0.25 * closing if self.o.follow_warn else 0.0
        return self._slower * closing, planned(tilt - ahead)["phi"]

    def _align(self):
        """Close the tilt under a push; an alarm at WARN slows, turns or presses less."""
        self._expect, tilt, push, resists = "insertion", self._tilt, 1.0, 0.0

        def close(dt):
            nonlocal tilt, push, resists
            (rate, turn), text, inside = self._rates(tilt), self._warned(), self._inside()
            if text:
                found = [re.search(pattern, text) for pattern in ADVICE]
                usual = 0.03, turn, 100.0
                slow, turn, most = (float(at[1]) if at else of for at, of in zip(found, usual))
                rate, push = min(rate, slow), min(push, most / 100.0)
            # The walls are near: a moment that no force shows loads them.
            lead = self.o.lead * (0.3 if text or inside else 1.0)
            rate *= 0.5 if inside else 1.0
            self._turn, self._spin = turn, self._spin + turn * dt
            closed, least = tilt - rate * dt, np.arcsin(-self.seen.lean @ self._h) - lead
            resists = resists + dt if closed < least else 0.0
            tilt = max(closed, 0.0, least)
            # Not far ahead, but where it overshoots the springs may hold it back.
            self._lean = near(-np.sin(tilt) * self._h, self.seen.lean, 2.0 * self.o.lead)
            self._at = self._pressed(tilt, push)
            if inside:
                # What falls on the walls between which it fits hits them hard.
                self._at[2] = max(self._at[2], self.seen.position[2] - 0.001)

        def closed(seen):
            return tilt <= 0.0 or (self._inside() and resists > 0.3)

        yield from self.wait_for(closed, 6.0, close)

    def _inside(self):
        """Return whether the monitor has seen the peg pass from the rim into the hole."""
        seen = self.seen
        inside = seen.transition or seen.mode in ("two_point", "inserted")
        return self.o.follow_modes and inside

    def _go_in(self):
        """Push along the hole, and give way to side force and moment; on a WARN slow, and turn."""
        # What turns slides, so that friction holds it back less along the hole.

        def go_in(dt):
            # Slowly, so that the controller's damping still stops what swings.
            share, seen = min(dt / 0.1, 1.0), self.seen
            self._at[:2] += share * (near(self._at[:2], seen.position[:2], 5e-4) - self._at[:2])
            self._lean += share * (near(self._lean, seen.lean, 0.25 * self.o.lead) - self._lean)
            warned = self._warned()
            self._spin += (max(self._turn, 0.3) if warned else self._turn) * dt
            self._at[2] -= (0.005 if warned else 0.01) * self._slower * dt
            self._at[2] = max(self._at[2], self.seen.position[2] - 0.006)

        def deep(seen):
            inserted = self.o.follow_modes and seen.mode == "inserted"
            return inserted or -seen.position[2] > self.o.depth

        self._at[2] = self.seen.position[2] - 0.001
        if not (yield from self.wait_for(deep, 4.0, go_in)):
            raise Stopped("not in")

    def _back_off(self):
        """Reverse the tilt under a pull until the peg is out, tilt back and lift off."""
        self._expect, self._watching = "lift_off", False
        self._lean = self.seen.lean.copy()

        def out(dt):
            self._at = self.seen.position + (0.0, 0.0, 0.006)
            self._lean = near(self._leaned, self.seen.lean, self.o.lead)
            self._spin += 0.2 * dt

        up = self._above()
        yield from self.wait_for(lambda seen: seen.position[2] > -0.0003, 6.0, out)
        self._at = self.seen.position.copy()
        off = self._to(up, self._leaned)
        yield from self.wait_for(lambda seen: seen.position[2] > up[2] - 0.002, 4.0, off)


def near(place, centre, most):
    """Return what is no farther from a centre, towards a place."""
    off = place - centre
    return centre + off * min(1.0, most / max(np.linalg.norm(off), 1e-9))


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
    """The node around the program: the program sees the latest message of each topic."""

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
        )  # fmt: skip

    def _decide(self):
        # It begins once every topic has been heard, and the monitor listens.
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
    """Run until the program has an outcome; return the exit code, 2 where it has given up."""
    rclpy.init()
    node = Insert()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        while not node.program.outcome:
            rclpy.spin_once(node)
    rclpy.try_shutdown()
    return 2 if node.program.outcome == "given up" else 0


if __name__ == "__main__":
    sys.exit(main())
