"""
One try: a cell in MuJoCo, the pipeline of the package and a robot program, in lockstep.

Every 2 ms, and in this order: the engine goes on by 2 ms, the sensor and the joints send, the
pipeline takes both, the program decides by what is published, and the controller holds what it
commands. Nothing waits for a clock, so a seed gives the same try each time.
"""

import time
from types import ModuleType

import numpy as np

from benchmarks.harness.errors import inside
from benchmarks.loop import drawn
from benchmarks.loop.drawn import (
    EVERY,
    FRAME,
    LONGEST,
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
from peg_on_hole_ros.measurements.rotations import rpy_of
from peg_on_hole_ros.messages.stream import message_stream
from peg_on_hole_ros.monitor.states import Mode
from peg_on_hole_ros.records import JointSample, WrenchSample

START_NS = 1_767_225_600_000_000_000
CONTACT = (Mode.THREE_POINT.value, Mode.TWO_POINT.value, Mode.INSERTED.value)
FORCE_NOISE, TORQUE_NOISE, JOINT_NOISE = 0.5, 0.02, 2e-5
ZERO = np.array([0.4, -0.3, 0.6, 0.01, 0.02, 0.0])
# Of the forces' zero, with a memory of this long [N], [s].
WANDER, MEMORY = 0.3, 20.0
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
        self.loads, self.row = (float("nan"),) * 3, None

    def take(self, columns) -> None:
        """Take what a wrench makes known."""
        if columns is None:
            return
        self.row = columns.rows[-1]
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


class Covered:
    """How often 95 % bounds contain the truth while the program aligns and goes in."""

    STAGES = ("align", "go_in")

    def __init__(self, friction: float):
        self._friction, self._inside = friction, {"tilt": [], "friction": [], "reactions": []}

    def take(self, stage: str, row, tilt: float, loads) -> None:
        """Take what is published at a moment, and what is true there."""
        if stage not in self.STAGES or row is None or row["contact_mode"] not in CONTACT:
            return
        self._take("tilt", row["state"][:1] - tilt, row["state_stddev"][:1])
        self._take("friction", [row["friction"] - self._friction], [row["friction_stddev"]])
        if row["reactions_determined"] > 0.0:
            self._take("reactions", row["normal"] - loads, row["normal_stddev"])

    def _take(self, name: str, error, stddev) -> None:
        self._inside[name] += inside(np.asarray(error), np.asarray(stddev)).tolist()

    @property
    def counts(self) -> dict:
        """Return for each quantity how many are inside, of how many."""
        return {name: (sum(each), len(each)) for name, each in self._inside.items()}


class Cell:
    """
    Robot, sensor and controller of a try: what they send every 2 ms, and what they are led to.

    Parameters
    ----------
    true : Try
    options : Options
        Of the program: how the peg is held at first.

    Attributes
    ----------
    t : float
        Of the engine [s].
    rows : list of tuple
        Of the engine's last milliseconds.
    wrench, drives : ndarray
        As the sensor and the encoders send them.
    position, lean, spin : ndarray, ndarray, float
        Of the peg in the hole as stated, by the drives.
    force : float
        By the sensor, beside its zero [N].

    """

    def __init__(self, true: Try, options) -> None:
        self.configuration = configuration_of(true)
        self._stated = stated_hole(self.configuration)
        hole, (arm, self._is_in_stated) = true_hole(true, self._stated), grasped(true)
        setting = Setting(
            friction=true.friction, damping=2e3, peg_diameter=D - true.clearance, rim=0.006,
            step=2e-4, boxes=180,
            hole_xyz=tuple(hole[:3, 3]), hole_rpy=rpy_of(hole[:3, :3]),
        )  # fmt: skip
        up = 0.5 * options.peg_diameter * np.sin(options.tilt) + options.above
        lean = -np.sin(options.tilt) * np.array([np.cos(options.psi), np.sin(options.psi)])
        self._at = self._goal(np.array([0.0, 0.0, up]), lean, 0.0)
        self._plant, self._sensor = Plant(arm, setting, *self._at), Sensor(true.seed)
        self._plant.hold(*self._at, np.zeros(6))
        self.names, self._zero = arm.joints, np.zeros(6)
        self.t, self.spin, self.rows = 0.0, 0.0, []

    def go(self) -> None:
        """Go on by 2 ms, and send."""
        self.rows = [self._plant.go() for _ in range(EVERY)]
        self.t = self.rows[-1][0]
        means = np.array([row[2] for row in self.rows])
        self.wrench = self._sensor.send(means, self.rows[-1][3])
        self.drives = self._sensor.joints(self.rows[-1][1])
        x, R = self._plant.know()
        known = np.linalg.inv(self._stated) @ pose(x, R) @ np.linalg.inv(self._is_in_stated)
        self.position, self.lean = known[:3, 3].copy(), known[:2, 2].copy()
        least = drawn.axes(self.lean, 0.0).T @ known[:3, :3]
        turned = np.arctan2(least[1, 0], least[0, 0]) - self.spin
        self.spin += (turned + np.pi) % (2 * np.pi) - np.pi
        self.force = float(np.linalg.norm(self.wrench[:3] - self._zero[:3]))

    def tare(self) -> None:
        """Take what the sensor reads as its zero, for the controller's force limit."""
        self._zero = self._sensor.filtered + ZERO

    def lead(self, position, lean, spin) -> None:
        """Hold what is commanded."""
        wanted = self._goal(position, lean, spin)
        turned = rotation_vector(wanted[1] @ self._at[1].T)
        rates = np.concatenate([wanted[0] - self._at[0], turned]) / (EVERY * 1e-3)
        rates = np.where(np.abs(rates) > FASTEST, 0.0, rates)
        self._plant.hold(*wanted, rates)
        self._at = wanted

    def stay(self) -> None:
        """Hold what was commanded last."""
        self._plant.hold(*self._at, np.zeros(6))

    def _goal(self, position, lean, spin):
        """Return place and axes of the gripped peg in the base."""
        found = self._stated @ pose(position, drawn.axes(lean, spin)) @ self._is_in_stated
        return found[:3, 3], found[:3, :3]


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
    watch : callable, optional
        Takes time, row, command, what is published and the cell each 2 ms.
    longest : float
        Beyond it the try has failed [s].

    """
    cell, program, published = Cell(true, options), module.Program(options), Published()
    stream = message_stream(cell.configuration, markers_rate=0.0)
    stream.take_frame(FRAME)
    begun, covered = time.process_time(), Covered(true.friction)
    loads, errors, warned = [], [], 0
    while cell.t < longest and not program.outcome:
        cell.go()
        loads += [row[6].max() for row in cell.rows]
        published.take(_sent(stream, cell))
        if program.tried == 1:
            means = np.mean([row[6] for row in cell.rows], axis=0)
            covered.take(program.stage, published.row, cell.rows[-1][4][0], means)
        if published.level >= 2 and (not errors or cell.t - errors[-1] > 0.5):
            errors.append(cell.t)
        warned = max(warned, published.level)
        command = program.step(_seen(module, cell, published))
        if command.expect:
            stream.on_event(f"expect {command.expect}")
        if command.tare:
            stream.on_event("tare")
            cell.tare()
        cell.lead(command.position, command.lean, command.spin)
        if watch:
            watch(cell.t, cell.rows[-1], command, published, cell)
    return {
        "outcome": program.outcome or "too long",
        "stage": program.stage,
        "tried": program.tried,
        "time": cell.t,
        "stops": program.stops,
        "most_load": float(max(loads)),
        "errors": errors,
        "worst_level": int(warned),
        "covered": covered.counts,
        "cpu": time.process_time() - begun,
    }


def _sent(stream, cell: Cell):
    """Return what the pipeline publishes of what the cell sends."""
    t_ns = START_NS + round(cell.t * 1e9)
    stream.take_joints(JointSample(t_ns, cell.names, tuple(cell.drives.tolist())))
    force, torque = tuple(cell.wrench[:3].tolist()), tuple(cell.wrench[3:].tolist())
    return stream.take_wrench(WrenchSample(t_ns, force, torque))


def _seen(module: ModuleType, cell: Cell, published: Published):
    """Return what the program sees."""
    return module.Seen(
        cell.t, cell.position, cell.lean, cell.spin, cell.force, published.mode,
        published.transition, published.level, published.alarms,
    )  # fmt: skip
