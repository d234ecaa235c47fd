"""Settings of the pipeline's parts, as plain records; `configuration` checks and fills them."""

from dataclasses import dataclass, field
from typing import NamedTuple

from peg_on_hole_ros.mechanics.planning.cell import Cell
from peg_on_hole_ros.mechanics.scene import Scene


class BaseLink(NamedTuple):
    """
    A link of the robot that stands still.

    Attributes
    ----------
    name : str
    rpy : tuple of 3 float
        Its axes in those of the root link [rad].

    """

    name: str
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class WrenchInput:
    """How a wrench message becomes the wrench on the peg at its mass centre."""

    acts_on: str = "peg"
    axes: str = "sensor"
    gravity: str = "measured"
    adopt_found: bool = True
    sensor_pose: str = "frame_id"
    sensor_xyz: tuple[float, float, float] = (0.0, 0.0, 0.070)
    sensor_rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    force_stddev: float = 0.2
    torque_stddev: float = 0.005
    low_pass: float = 0.0
    bias_force: tuple[float, float, float] = (0.0, 0.0, 0.0)
    bias_torque: tuple[float, float, float] = (0.0, 0.0, 0.0)
    bias_force_stddev: float = 0.0
    bias_torque_stddev: float = 0.0
    bias_force_drift: float = 0.0
    bias_torque_drift: float = 0.0
    tare_in_contact: bool = False
    tare_automatically: bool = False
    payload_mass: float = 0.0
    payload_com: tuple[float, float, float] = (0.0, 0.0, 0.0)
    # Links that stand still, in whose axes numbers may be. No parameter.
    base_links: tuple[BaseLink, ...] = (BaseLink("base"),)

    @property
    def base_rpy(self) -> tuple[float, float, float] | None:
        """Axes of the numbers in the root link [rad]; None: those of the sensor."""
        return next((link.rpy for link in self.base_links if link.name == self.axes), None)


@dataclass(frozen=True)
class JointInput:
    """How a joint-state message becomes an orientation of the peg in the hole."""

    source: str = "peg"
    names: tuple[str, ...] = ("gamma", "psi", "phi")
    position_stddev: float = 1.0e-4
    delay: float = 0.0
    delay_stddev: float = 0.0
    urdf: str = ""
    tip_frame: str = ""
    peg_xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    peg_rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    hole_xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    hole_rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    hole_xyz_stddev: float = 1.0e-3
    hole_tilt_stddev: float = 0.0
    gravity_link: str = ""
    # Text of the URDF, where it is at hand: then no file is read. No parameter.
    description: str = ""
    # What errors call it where it is another's than the file in `urdf`. No parameter.
    described_by: str = ""
    # Gravity by the robot's description, hole axes [m/s^2]; None: it is not known. No parameter.
    robot_gravity: tuple[float, float, float] | None = None

    @property
    def is_placed(self) -> bool:
        """Whether it is stated where the hole is: one at the origin nobody has placed."""
        return any(self.hole_xyz)

    @property
    def place_stddev(self) -> float | None:
        """How well the robot knows where the peg is in the hole [m]; None: it does not."""
        stated = self.source == "robot" and self.is_placed and self.hole_xyz_stddev > 0.0
        return self.hole_xyz_stddev if stated else None


@dataclass(frozen=True)
class Accuracy:
    """How exact sensor, payload, encoders and parts are, a standard deviation each; 0: exact."""

    gain: float = 0.01
    crosstalk: float = 0.005
    sensor_xyz: float = 1.0e-3
    sensor_rpy: float = 5.0e-3
    payload_mass: float = 0.02
    payload_com: float = 1.0e-3
    orientation: float = 5.0e-4
    diameter: float = 1.0e-6
    compliance: float = 2.0e-8

    @staticmethod
    def exact() -> "Accuracy":
        """Return what a simulated cell has, in which everything is as it is stated."""
        return Accuracy(**dict.fromkeys(Accuracy.__dataclass_fields__, 0.0))


@dataclass(frozen=True)
class FilterOptions:
    """What the estimator learns, how long it trusts, and when it gives a motion up."""

    method: str = "mixture"
    max_gap: float = 0.1
    max_joint_gap: float = 0.5
    late_window: float = 0.05
    late_tolerance: float = 0.004
    initial_rate_stddev: float = 1.0
    friction: str = "estimated"
    wrench_bias: str = "estimated"
    hole_tilt: str = "estimated"
    clearance: str = "estimated"
    friction_noise: float = 0.0005
    gate_threshold: float = 50.0
    gate_reset_count: int = 2


@dataclass(frozen=True)
class MonitorOptions:
    """When the monitor speaks, and what it holds against the estimate."""

    modes: bool = True
    contact_force_threshold: float = 1.0
    free_acceleration: float = 2.0
    mode_dwell: float = 0.01
    mode_probability_on: float = 0.7
    mode_probability_off: float = 0.3
    mode_change_rate: float = 2.0
    evidence_time: float = 0.005
    rest_speed: float = 5.0e-4
    transition_probability_on: float = 0.9
    transition_probability_off: float = 0.1
    transition_hold: float = 0.1
    forecast_acceleration_stddev: float = 0.025
    forecast_acceleration_time: float = 0.2
    jamming_horizon: float = 0.2
    load_horizon: float = 0.1
    jamming_warn: float = 0.7
    jamming_error: float = 0.9
    alarm_hysteresis: float = 0.1
    alarm_dwell: float = 0.01
    alarm_hold: float = 0.2
    max_normal: tuple[float, float, float] = (500.0, 500.0, 500.0)
    singular_band: float = 0.12
    inserted_depth: float = 0.0

    @property
    def rest_rate(self) -> float:
        """Turning rate at which the contacts of a hole of 50 mm move at `rest_speed` [rad/s]."""
        return self.rest_speed / 0.05


@dataclass(frozen=True)
class Topics:
    """Names of the topics that are read."""

    wrench: str = "/wrench"
    joint_states: str = "/joint_states"
    robot_description: str = "/robot_description"


@dataclass(frozen=True)
class Frames:
    """Names of frames in messages and in the tree that /tf and /tf_static make."""

    hole: str = "hole"
    peg: str = "peg"
    base: str = ""


@dataclass(frozen=True)
class Configuration:
    """Everything that the pipeline is built from; the same for node and replay."""

    scene: Scene = field(default_factory=Scene)
    wrench: WrenchInput = field(default_factory=WrenchInput)
    joints: JointInput = field(default_factory=JointInput)
    accuracy: Accuracy = field(default_factory=Accuracy)
    filter: FilterOptions = field(default_factory=FilterOptions)
    monitor: MonitorOptions = field(default_factory=MonitorOptions)
    plan: Cell = field(default_factory=Cell)
    topics: Topics = field(default_factory=Topics)
    frames: Frames = field(default_factory=Frames)


@dataclass(frozen=True)
class NodeOptions:
    """What only the node uses (`markers_rate`: the replay too); no estimate depends on it."""

    autostart: bool = True
    record_arrivals: str = ""
    qos_depth: int = 200
    markers_rate: float = 10.0
