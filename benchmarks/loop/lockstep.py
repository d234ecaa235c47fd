"""
One try: a cell in MuJoCo, the pipeline of the package and a robot program, in lockstep.

Every 2 ms, and in this order: the engine goes on by 2 ms, the sensor and the joints send, the
pipeline takes both, the program decides by what is published, and the controller holds what it
commands. Nothing waits for a clock, so a seed gives the same try each time.
"""

import time
from types import ModuleType

import numpy as np

from benchmarks.loop import drawn
from benchmarks.loop.drawn import (
    LOW_PASS,
    Try,
    configuration_of,
    grasped,
    pose,
    stated_hole,
    true_hole,
)
from benchmarks.robot_cells.arms import ARMS
from benchmarks.robot_cells.cell import Plant, Setting, rotation_vector
from benchmarks.robot_cells.rows import D
from benchmarks.robot_cells.sensing import weight_taken_off
from peg_on_hole_ros.messages.stream import message_stream
from peg_on_hole_ros.records import JointSample, WrenchSample

START_NS = 1_767_225_600_000_000_000
EVERY = 2  # [ms]
FORCE_NOISE, TORQUE_NOISE, JOINT_NOISE = 0.5, 0.02, 2e-5
ZERO = np.array([0.4, -0.3, 0.6, 0.01, 0.02, 0.0])
# Of the forces' zero, with a memory of this long [N], [s].
WANDER, MEMORY = 0.3, 20.0
# Beyond it a try has failed [s].
LONGEST = 25.0
# The program's commands are not led faster than this [m/s], [rad/s].
FASTEST = np.repeat([0.1, 1.0], 3)


class Sensor:
    """
    What the sensor sends of a mean force and torque: filtered, off, with noise and drift.

    Attributes
    ----------
    filtered : ndarray, shape (6,)
        The last behind the low-pass, without zero and noise [N], [N m].

    """

    def __init__(self, seed: int):
        self._rng = np.random.default_rng([seed, 1])
        self.filtered: np.ndarray | None = None
        self._wander = WANDER * self._rng.normal(size=3)

    def send(self, means: np.ndarray, axes: np.ndarray) -> np.ndarray:
        """Return the wrench of some milliseconds, by the mean of each, shape (k, 6)."""
        taken = np.zeros(6)
        for mean in means:
            wrench = -mean - weight_taken_off(axes[None], ARMS["ur_like"])[0]
            if self.filtered is None:
                self.filtered = wrench
            share = 1.0 - np.exp(-2 * np.pi * LOW_PASS * 1e-3)
            self.filtered = self.filtered + share * (wrench - self.filtered)
            taken += self.filtered / len(means)
        keep = np.exp(-1e-3 * len(means) / MEMORY)
        self._wander = keep * self._wander + WANDER * np.sqrt(1 - keep**2) * self._rng.normal(
            size=3
        )
        taken[:3] += self._wander
        noise = np.repeat([FORCE_NOISE, TORQUE_NOISE], 3)
        return taken + ZERO + noise * self._rng.normal(size=6)

    def joints(self, angles: np.ndarray) -> np.ndarray:
        """Return what encoders send."""
        return angles + JOINT_NOISE * self._rng.normal(size=angles.shape)


class Published:
    """The last of what the pipeline has published, as a subscriber has it."""

    def __init__(self):
        self.mode, self.transition, self.level, self.alarms = "unknown", False, 0, ()
        self.loads = (float("nan"),) * 3

    def take(self, columns) -> None:
        """Take what a wrench makes known."""
        if columns is None:
            return
        self.loads = tuple(columns.normal[-1].tolist())
        for _, messages in columns.beside:
            for topic, _, fields in messages:
                if topic == "contact_mode":
                    self.mode = fields["data"]
                elif topic == "transition":
                    self.transition = fields["data"]
                elif topic == "alarm_level":
                    self.level = fields["data"]
                elif topic == "alarms":
                    self.alarms = tuple(
                        (each["name"], each["level"], each["message"]) for each in fields["status"]
                    )


def play(true: Try, module: ModuleType, options, watch=None, longest=LONGEST) -> dict:
    """
    Return what became of a try.

    Parameters
    ----------
    true : Try
    module : module
        The program.
    options : Options
        Of the program.
    longest : float
        Beyond it the try has failed [s].
    watch : callable, optional
        Takes time, row, command, what is published and the filtered force each 2 ms.

    """
    configuration = configuration_of(true)
    stated = stated_hole(configuration)
    hole, (arm, is_in_stated) = true_hole(true, stated), grasped(true)
    setting = Setting(
        friction=true.friction, damping=2e3, peg_diameter=D - true.clearance, rim=0.006,
        step=2e-4, boxes=180,
        hole_xyz=tuple(hole[:3, 3]), hole_rpy=_rpy(hole[:3, :3]),
    )  # fmt: skip
    up = 0.5 * options.peg_diameter * np.sin(options.tilt) + options.above
    lean = -np.sin(options.tilt) * np.array([np.cos(options.psi), np.sin(options.psi)])

    def goal(position, lean, spin):
        found = stated @ pose(position, drawn.axes(lean, spin)) @ is_in_stated
        return found[:3, 3], found[:3, :3]

    plant = Plant(arm, setting, *goal(np.array([0.0, 0.0, up]), lean, 0.0))
    stream, sensor = message_stream(configuration, markers_rate=0.0), Sensor(true.seed)
    begun = time.process_time()
    published, program = Published(), module.Program(options)
    at = goal(np.array([0.0, 0.0, up]), lean, 0.0)
    zero, loads, errors, warned, t, command = np.zeros(6), [], [], 0, 0.0, None
    names = arm.joints
    plant.hold(*at, np.zeros(6))
    spin_before = 0.0
    while t < longest and not program.outcome:
        rows = [plant.go() for _ in range(EVERY)]
        t = rows[-1][0]
        loads += [row[6].max() for row in rows]
        wrench = sensor.send(np.array([row[2] for row in rows]), rows[-1][3])
        t_ns = START_NS + round(t * 1e9)
        drives = sensor.joints(rows[-1][1])
        stream.take_joints(JointSample(t_ns, names, tuple(drives.tolist())))
        published.take(
            stream.take_wrench(
                WrenchSample(t_ns, tuple(wrench[:3].tolist()), tuple(wrench[3:].tolist()))
            )
        )
        if published.level >= 2 and (not errors or t - errors[-1] > 0.5):
            errors.append(t)
        warned = max(warned, published.level)
        x, R = plant.know()
        known = np.linalg.inv(stated) @ pose(x, R) @ np.linalg.inv(is_in_stated)
        leaned = known[:2, 2].copy()
        least = drawn.axes(leaned, 0.0).T @ known[:3, :3]
        spin = np.arctan2(least[1, 0], least[0, 0])
        spin_before += (spin - spin_before + np.pi) % (2 * np.pi) - np.pi
        force = float(np.linalg.norm(wrench[:3] - zero[:3]))
        command = program.step(
            module.Seen(
                t,
                known[:3, 3].copy(),
                leaned,
                spin_before,
                force,
                published.mode,
                published.transition,
                published.level,
                published.alarms,
                published.loads,
            )
        )
        if command.expect:
            stream.on_event(f"expect {command.expect}")
        if command.tare:
            stream.on_event("tare")
            zero = sensor.filtered + ZERO
        wanted = goal(command.position, command.lean, command.spin)
        rates = np.concatenate([wanted[0] - at[0], rotation_vector(wanted[1] @ at[1].T)]) / (
            EVERY * 1e-3
        )
        rates = np.where(np.abs(rates) > FASTEST, 0.0, rates)
        plant.hold(*wanted, rates)
        at = wanted
        if watch:
            watch(t, rows[-1], command, published, force, known)
    return {
        "outcome": program.outcome or "too long",
        "stage": program.stage,
        "tried": program.tried,
        "time": t,
        "stops": program.stops,
        "most_load": float(max(loads)),
        "errors": errors,
        "worst_level": int(warned),
        "cpu": time.process_time() - begun,
    }


def _rpy(R):
    """Return roll, pitch and yaw of Rz Ry Rx."""
    return (
        float(np.arctan2(R[2, 1], R[2, 2])),
        float(-np.arcsin(R[2, 0])),
        float(np.arctan2(R[1, 0], R[0, 0])),
    )
