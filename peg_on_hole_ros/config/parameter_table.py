"""The table of all parameters: name, type, default, unit, range and effect of each."""

from dataclasses import dataclass
from typing import Any

from peg_on_hole_ros.config.options import Configuration, NodeOptions
from peg_on_hole_ros.mechanics.planning.cell import AIMS
from peg_on_hole_ros.mechanics.scene import RANGES


@dataclass(frozen=True)
class Parameter:
    """
    One parameter as node and command line know it.

    Attributes
    ----------
    name : str
        Dotted, as in ROS 2.
    type : str
        ROS 2 type: `bool`, `integer`, `double`, `string`, `double[]` or `string[]`.
    default : bool, int, float, str or tuple
    unit : str
        SI; empty for a bare number or a text.
    low, high : float or None
        Inclusive range of a number, or of each number of an array.
    choices : tuple of str
        Allowed texts; empty: any.
    effect : str
        One line: what it does, and what goes wrong with a bad value.
    topic : bool
        Whether the text has to be the name of a topic.
    live : bool
        Whether a node that is configured takes a new value; else it has to be configured anew.

    """

    name: str
    type: str
    default: Any
    unit: str
    low: float | None
    high: float | None
    choices: tuple[str, ...]
    effect: str
    topic: bool = False

    @property
    def live(self) -> bool:
        """See above."""
        return self.name in LIVE or self.name.startswith("monitor.") and self.name not in _BUILT


# The monitor is built with it or without.
_BUILT = ("monitor.modes",)
LIVE = (
    "wrench.force_stddev",
    "wrench.torque_stddev",
    "wrench.tare_in_contact",
    "joints.position_stddev",
    "filter.gate_threshold",
    "filter.gate_reset_count",
    "markers_rate",
)
# Values of `filter.method`, each with what the estimator is; `estimator.methods` has them.
METHOD_NAMES = {
    "mixture": "a mixture of friction hypotheses and process-noise modes",
    "one_level": "one process-noise mode and one friction hypothesis",
    "dde_driven": "the wide-prior limit, driven by the dynamic equations",
    "quasi_static": "no inertia",
    "balance": "motion from orientations, reactions from a balance of forces without inertia",
    "small_angle": "the same balance with the lever arms of a small tilt",
    "one_dof": "a peg that only tilts",
    "two_dof": "a peg that tilts and turns about its axis",
    "unscented": "one process-noise mode by sigma points",
    "particles_100": "one process-noise mode by 100 particles, for comparison",
    "particles_1000": "by 1000 particles, for comparison",
}
# Value of `joints.gravity_link` where the robot's description does not say where down is.
GRAVITY_STATED = "stated"
_TYPES = {bool: "bool", int: "integer", float: "double", str: "string"}


def _row(name, effect, unit="", low=None, high=None, choices=(), topic=False):
    # The default is read from the record that the value ends in, so the two cannot differ.
    owner = NodeOptions()
    for part in name.split(".")[:-1]:
        owner = getattr(Configuration(), part)
    default = type(owner).__dataclass_fields__[name.rsplit(".", 1)[-1]].default
    array = isinstance(default, tuple)
    kind = _TYPES[type(default[0])] + "[]" if array else _TYPES[type(default)]  # type: ignore[index]
    return Parameter(name, kind, default, unit, low, high, choices, effect, topic)


def _scene(name, effect):
    low, high, unit = RANGES[name]
    return _row(f"scene.{name}", effect, unit, low, high)


def _wrench(name, *rest, **more):
    return _row(f"wrench.{name}", *rest, **more)


def _joints(name, *rest, **more):
    return _row(f"joints.{name}", *rest, **more)


def _accuracy(name, *rest):
    return _row(f"accuracy.{name}", *rest)


def _filter(name, *rest, **more):
    return _row(f"filter.{name}", *rest, **more)


def _monitor(name, *rest):
    return _row(f"monitor.{name}", *rest)


def _plan(name, *rest, **more):
    return _row(f"plan.{name}", *rest, **more)


PARAMETERS: tuple[Parameter, ...] = (
    _scene(
        "hole_diameter",
        "D, of the bore and not of its chamfer; D - d sets every lever: measure it",
    ),
    _scene(
        "peg_diameter",
        "d, of the shank and not of its chamfer, below D; an error of 2 um already biases N_K",
    ),
    _scene(
        "peg_height",
        "H, from the shoulder where it has a chamfer; sets mass centre and inertia unless given",
    ),
    _scene("peg_mass", "m, with all that is rigid with the peg below the sensor"),
    _scene("friction", "Coulomb coefficient f at all contacts"),
    _scene(
        "mass_center_height",
        "mass centre above the lower end face, or above the shoulder of a chamfer; 0: half the "
        "height",
    ),
    _scene("transverse_inertia", "Ie about the mass centre; 0: solid cylinder"),
    _scene("axial_inertia", "Iz about the peg's axis; 0: solid cylinder"),
    _scene(
        "gravity",
        "in hole axes; a hole need not be vertical. With joints.source robot the default stands "
        "for that of the robot, see joints.gravity_link, and any other value overrides it",
    ),
    _scene(
        "clearance_stddev",
        "of D - d; 0: known. Otherwise it is estimated, and enters flag, forecast and bounds",
    ),
    _scene("friction_stddev", "of the friction coefficient; 0: known, and not estimated"),
    _scene(
        "clearance_drift",
        "random walk of the effective clearance, as no rim is an ideal circle; 0: it is",
    ),
    _scene("friction_k_stddev", "by which friction at K may differ from f; 0: one friction"),
    _scene(
        "compliance_stddev",
        "how much of the clearance a newton of load may take; 0: rigid contacts",
    ),
    _scene(
        "hole_chamfer",
        "height of the hole's chamfer along its axis: joints.hole_xyz is on the outer face, and "
        "bore and hole frame begin so far below; 0: sharp, or hole_xyz is where the bore begins",
    ),
    _scene(
        "peg_chamfer",
        "height of the peg's chamfer along its axis: joints.peg_xyz is its outermost end, and "
        "shank and peg frame begin so far above; 0: sharp, or peg_xyz is where the shank begins",
    ),
    _wrench(
        "acts_on",
        "whose wrench the sensor reports; the wrong one flips every sign",
        choices=("peg", "robot"),
    ),
    _wrench(
        "axes",
        "axes of the six components: sensor; base, in which some drivers publish whatever the "
        "frame_id is: the link of that name if the URDF has one that stands still, else its root "
        "link, and for joints.source peg the axes of the angles; or any link of the URDF that is "
        "fixed to the root link or to the tip",
    ),
    _wrench(
        "gravity",
        "whether the wrench contains the weight of all that hangs below the sensor, or a "
        "controller has subtracted it already",
        choices=("measured", "compensated"),
    ),
    _wrench(
        "adopt_found",
        "whether a setting that the wrench contradicts is replaced by the one that fits (acts_on, "
        "axes, gravity, sensor_rpy, noise of rounded numbers), with a report; false: only the "
        "report, and no contact is published",
    ),
    _wrench(
        "sensor_pose",
        "where the sensor sits: at the link of the URDF that the wrench's frame_id names, if "
        "there is one, and another statement is an error; or as stated, whatever the frame_id "
        "is",
        choices=("frame_id", "stated"),
    ),
    _wrench(
        "sensor_xyz",
        "sensor origin in the peg frame, see scene.peg_chamfer; sets the levers",
        "m",
        -10.0,
        10.0,
    ),
    _wrench("sensor_rpy", "sensor axes in the peg frame (roll, pitch, yaw)", "rad", -6.3, 6.3),
    _wrench(
        "force_stddev",
        "noise of each force component; bounds of the reactions scale with it",
        "N",
        1e-6,
        1e3,
    ),
    _wrench("torque_stddev", "noise of each torque component", "N m", 1e-7, 1e3),
    _wrench(
        "low_pass",
        "cut-off of the low-pass in sensor or driver, first order; where the load changes "
        "fast, its lag widens the bounds; 0: there is none",
        "Hz",
        0.0,
        1e5,
    ),
    _wrench(
        "bias_force",
        "what the unloaded sensor reads, sensor axes; a tare takes its place",
        "N",
        -1e4,
        1e4,
    ),
    _wrench("bias_torque", "what the unloaded sensor reads, sensor axes", "N m", -1e4, 1e4),
    _wrench(
        "bias_force_stddev",
        "of each component of bias_force; 0: known, and six states less",
        "N",
        0.0,
        1e4,
    ),
    _wrench(
        "bias_torque_stddev",
        "of each component of bias_torque; 0: known; stated alone it leaves the bias of the "
        "forces known",
        "N m",
        0.0,
        1e4,
    ),
    _wrench(
        "bias_force_drift",
        "random walk of the bias of the force, estimated in free air; per root of a second",
        "N",
        0.0,
        1e3,
    ),
    _wrench(
        "bias_torque_drift",
        "random walk of the bias of the torque, estimated in free air; per root of a second",
        "N m",
        0.0,
        1e3,
    ),
    _wrench(
        "tare_in_contact",
        "whether a tare or a pose is accepted although no measurement shows a free and still peg: "
        "its load then counts as bias",
    ),
    _wrench(
        "tare_automatically",
        "whether the sensor is tared each time the peg has hung free and still for a second",
    ),
    _wrench(
        "payload_mass",
        "of what hangs between sensor and peg; its weight is subtracted",
        "kg",
        0.0,
        1e3,
    ),
    _wrench("payload_com", "mass centre of the payload in the sensor frame", "m", -10.0, 10.0),
    _joints(
        "source",
        "the peg's own angles, or a robot's joints with a URDF",
        choices=("peg", "robot"),
    ),
    _joints(
        "names",
        "joints to read: in the order gamma, psi, phi, or all of the robot that move the tip, "
        "in any order",
    ),
    _joints(
        "position_stddev",
        "noise of the orientation about each axis, or of each joint of the robot; too small: "
        "measurements are gated",
        "rad",
        1e-9,
        1.0,
    ),
    _joints(
        "delay",
        "how much later joint states are stamped than a wrench of the same moment",
        "s",
        -0.5,
        0.5,
    ),
    _joints(
        "delay_stddev",
        "uncertainty of the delay; each orientation is widened by how far the peg turns in "
        "that time",
        "s",
        0.0,
        0.1,
    ),
    _joints(
        "urdf",
        "file of the robot's description, without xacro, or topic: it comes by "
        "topics.robot_description; needed for source robot",
    ),
    _joints("tip_frame", "link of the URDF that carries the peg; needed for source robot"),
    _joints(
        "peg_xyz",
        "the peg's outermost end in the tip frame, see scene.peg_chamfer; the angles need its "
        "axes only",
        "m",
        -10.0,
        10.0,
    ),
    _joints("peg_rpy", "peg axes in the tip frame (roll, pitch, yaw)", "rad", -6.3, 6.3),
    _joints(
        "hole_xyz",
        "centre of the hole in its outer face, in the URDF's root link, see scene.hole_chamfer; "
        "as on /tf_static if it is stated; the angles need its axes only",
        "m",
        -100.0,
        100.0,
    ),
    _joints(
        "hole_rpy",
        "hole axes in the root link, or in those of the peg's own angles (roll, pitch, yaw); an "
        "error here is one of gamma",
        "rad",
        -6.3,
        6.3,
    ),
    _joints(
        "hole_xyz_stddev",
        "uncertainty of each coordinate of hole_xyz, with the robot's calibration: the contact "
        "mode uses the place of the peg; 0, or hole_xyz all 0: not known, and not used",
        "m",
        0.0,
        0.1,
    ),
    _joints(
        "hole_tilt_stddev",
        "uncertainty of the direction of the hole's axis in hole_rpy, about x and about y; 0: "
        "known, and two states less",
        "rad",
        0.0,
        0.2,
    ),
    _joints(
        "gravity_link",
        "link of the URDF along whose -z gravity pulls, fixed to its root link; empty: the root "
        f"link; {GRAVITY_STATED}: scene.gravity is used, also its default",
    ),
    _accuracy(
        "gain",
        "error of each channel of the sensor as a share of the load, with linearity, hysteresis "
        "and creep; a standard deviation as all of this group, only widens bounds; 0: exact",
        "",
        0.0,
        0.5,
    ),
    _accuracy(
        "crosstalk",
        "share of the other two forces that a force may take up, and of the other two torques "
        "that a torque may; 0: none",
        "",
        0.0,
        0.5,
    ),
    _accuracy("sensor_xyz", "of each coordinate of wrench.sensor_xyz; 0: exact", "m", 0.0, 0.1),
    _accuracy("sensor_rpy", "of the sensor, about each of its axes; 0: exact", "rad", 0.0, 0.5),
    _accuracy("payload_mass", "of wrench.payload_mass, as a share of it; 0: exact", "", 0.0, 1.0),
    _accuracy(
        "payload_com",
        "of each coordinate of wrench.payload_com, where there is a payload; 0: exact",
        "m",
        0.0,
        1.0,
    ),
    _accuracy(
        "orientation",
        "offset of the peg's tilt against the hole, by encoders, grip and hole_rpy, about each "
        "axis; not used where joints.hole_tilt_stddev is stated; 0: exact",
        "rad",
        0.0,
        0.2,
    ),
    _accuracy(
        "diameter",
        "of each of the two diameters as gauged; not used where scene.clearance_stddev is stated; "
        "0: exact",
        "m",
        0.0,
        0.01,
    ),
    _accuracy(
        "compliance",
        "by how much the contacts give, which takes clearance: 2e-8 for metal, 1e-7 to 1e-6 for "
        "plastics; not used where scene.compliance_stddev or clearance_stddev is stated; 0: rigid",
        "m/N",
        0.0,
        1e-5,
    ),
    _filter(
        "method",
        f"the estimator: {'; '.join(METHOD_NAMES.values())}",
        choices=tuple(METHOD_NAMES),
    ),
    _filter(
        "max_gap",
        "a silence of the wrench above this is predicted at constant rates, without contact; "
        "joint states within it still correct",
        "s",
        1e-3,
        100.0,
    ),
    _filter(
        "max_joint_gap",
        "no orientation for longer, beside joints.delay: the contact mode is unknown until one "
        "comes",
        "s",
        1e-3,
        100.0,
    ),
    _filter("initial_rate_stddev", "of the rates at the start", "rad/s", 1e-6, 1e3),
    _filter(
        "late_window",
        "a message at most this late is put in its place and all since processed again; 0: none",
        "s",
        0.0,
        1.0,
    ),
    _filter(
        "late_tolerance",
        "for late_window 0: joint states this late correct the present, later ones are dropped",
        "s",
        0.0,
        1.0,
    ),
    _filter(
        "friction",
        "whether an uncertain friction (scene.friction_stddev) is estimated, or only widens "
        "bounds",
        choices=("estimated", "considered"),
    ),
    _filter(
        "clearance",
        "whether an uncertain clearance (scene.clearance_stddev) is estimated, or only widens "
        "bounds",
        choices=("estimated", "considered"),
    ),
    _filter(
        "wrench_bias",
        "whether an uncertain bias (wrench.bias_force_stddev, bias_torque_stddev) is "
        "estimated, or only widens bounds",
        choices=("estimated", "considered"),
    ),
    _filter(
        "hole_tilt",
        "whether an uncertain direction of the hole (joints.hole_tilt_stddev) is estimated, or "
        "only widens bounds",
        choices=("estimated", "considered"),
    ),
    _filter(
        "friction_noise",
        "random walk of an estimated friction coefficient; per root of a second",
        "",
        0.0,
        1.0,
    ),
    _filter(
        "gate_threshold",
        "NIS (3 angles) above which an angle measurement is not used, only counted",
        "",
        1.0,
        1e9,
    ),
    _filter(
        "gate_reset_count",
        "gated in a row after which the next one restarts the filter",
        "",
        1,
        1_000_000,
    ),
    _monitor(
        "modes",
        "contact modes, forecast, jamming risk and alarms; false: less work, and above gamma0 the "
        "peg is assumed to be on three contacts, without a check",
    ),
    _monitor(
        "contact_force_threshold",
        "load of the rim, by all contacts together, above which something touches; in the hole, "
        "push above which a peg at rest may jam",
        "N",
        0.0,
        1e6,
    ),
    _monitor(
        "free_acceleration",
        "of a peg that is carried through the air; force for it does not count as contact",
        "m/s^2",
        0.0,
        1e3,
    ),
    _monitor("mode_dwell", "time a new contact mode must last to be published", "s", 0.0, 10.0),
    _monitor("mode_probability_on", "a mode is published from this probability on", "", 0.5, 1.0),
    _monitor("mode_probability_off", "below it a published mode becomes unknown", "", 0.0, 0.5),
    _monitor(
        "mode_change_rate",
        "how often contacts change; higher: modes follow sooner, and more false ones",
        "1/s",
        1e-6,
        1e3,
    ),
    _monitor(
        "evidence_time",
        "time in which noise and model errors are correlated; too short: overconfident modes",
        "s",
        1e-5,
        1.0,
    ),
    _monitor(
        "rest_speed",
        "of contacts, below which the peg is stuck; of a hole of 50 mm, in proportion of others",
        "m/s",
        1e-6,
        1.0,
    ),
    _monitor("transition_probability_on", "above it the transition is set", "", 0.5, 1.0),
    _monitor("transition_probability_off", "below it the transition is cleared", "", 0.0, 1.0),
    _monitor("transition_hold", "time above gamma0 that clears the transition", "s", 0.0, 60.0),
    _monitor(
        "forecast_acceleration_stddev",
        "of the tilt in a steady motion; the forecast adds the recent acceleration",
        "rad/s^2",
        1e-4,
        1e3,
    ),
    _monitor("forecast_acceleration_time", "how long an acceleration lasts", "s", 1e-3, 100.0),
    _monitor(
        "jamming_horizon",
        "how far the risk looks ahead: the time in which the arm stops, with the controller's "
        "latency, alarm_dwell and 0.01 s, or more; much longer: more false ones",
        "s",
        0.0,
        10.0,
    ),
    _monitor("load_horizon", "the same for overload; shorter than a press lasts", "s", 0.0, 10.0),
    _monitor("jamming_warn", "risk that gives jamming or overload, level WARN", "", 0.0, 1.0),
    _monitor("jamming_error", "risk that gives jamming or overload, level ERROR", "", 0.0, 1.0),
    _monitor(
        "alarm_hysteresis",
        "how far a probability has to fall below an alarm's threshold to clear it",
        "",
        0.0,
        0.49,
    ),
    _monitor("alarm_dwell", "time a threshold must be passed to raise an alarm", "s", 0.0, 10.0),
    _monitor("alarm_hold", "time without cause to clear an alarm by one level", "s", 0.0, 60.0),
    _monitor(
        "max_normal",
        "limits of the reactions at K, B1, B2; overload is the risk that one is passed",
        "N",
        1e-3,
        1e9,
    ),
    _monitor(
        "singular_band",
        "normalised determinant below which the reactions are declared undetermined",
        "",
        0.0,
        1.0,
    ),
    _monitor(
        "inserted_depth",
        "of the lower end of the shank below the edge of the bore, from which a peg that touches "
        "in the hole is inserted: less than where its seat is by what hole_xyz may be off; needs "
        "joints.hole_xyz and hole_xyz_stddev; 0: not stated",
        "m",
        0.0,
        10.0,
    ),
    _plan("aim", "quantity that the planned motion minimises, within its limits", choices=AIMS),
    _plan("start_tilt", "at which the peg has been set on the rim; above gamma0", "rad", 0.0, 1.5),
    _plan(
        "press",
        "push along h, e, z beside the weight, which the holder carries; loads grow with it",
        "N",
        -1e4,
        1e4,
    ),
    _plan("grip_height", "of the gripped point above the peg's lower end face", "m", 0.0, 10.0),
    _plan("stiffness", "of the holder's grip; softer: it gives way to the rim", "N/m", 1e2, 1e7),
    _plan("rotational_stiffness", "of the holder", "N m/rad", 1e-1, 1e6),
    _plan(
        "damping_ratio", "of the peg on the free holder; less: it chatters sooner", "", 0.01, 5.0
    ),
    _plan("force_limit", "of the holder, with the peg's weight", "N", 1e-3, 1e5),
    _plan("torque_limit", "of the holder, about the mass centre", "N m", 1e-4, 1e4),
    _plan("min_closing_rate", "slowest closing that is considered", "rad/s", 1e-4, 100.0),
    _plan(
        "max_closing_rate", "fastest closing; plain closing is judged at it", "rad/s", 1e-4, 100.0
    ),
    _plan("max_slip_rate", "of phi; 0: the peg is not turned about its axis", "rad/s", 0.0, 100.0),
    _plan("max_slide_rate", "of psi, beside the fastest slip; 0: none", "rad/s", 0.0, 100.0),
    _plan("max_acceleration", "of each angle; sets the ramps", "rad/s^2", 1e-2, 1e4),
    _plan("tilt_margin", "by which turning begins earlier than it must", "rad", 0.0, 0.5),
    _plan("wedge_probability", "allowed, by the spread of friction and clearance", "", 0.0, 1.0),
    _plan("overload_probability", "allowed for passing any other limit", "", 0.0, 1.0),
    _row("topics.wrench", "geometry_msgs/WrenchStamped to read", topic=True),
    _row("topics.joint_states", "sensor_msgs/JointState to read", topic=True),
    _row(
        "topics.robot_description",
        "std_msgs/String with the robot's description, transient local, for joints.urdf: topic",
        topic=True,
    ),
    _row(
        "frames.hole",
        "frame of the hole, in which messages are and the peg lies; each hole of a tree needs "
        "another",
    ),
    _row("frames.peg", "frame of the peg on /tf; no link of the robot, which has a parent"),
    _row(
        "frames.base",
        "frame on /tf_static in which joints.hole_xyz and hole_rpy are; empty: the URDF's root "
        "link",
    ),
    _row("autostart", "node: configure and activate itself at start"),
    _row("record_arrivals", "node: MCAP file for messages in their order of arrival; empty: none"),
    _row(
        "qos_depth",
        "node: queue of each input and of each output; short queues lose messages",
        "",
        1,
        100_000,
    ),
    _row("markers_rate", "most marker messages per second of stamp time", "Hz", 0.0, 1000.0),
)

_BY_MODEL = "the estimator needs no such setting, because it uses the wrench as a measurement"
_BY_SPREAD = "the variance of the slip gives the uncertainty of the direction of friction"
_BY_LEVELS = "process-noise modes follow the motion of a held peg"
# Parameters that are gone, each with what took its place.
SUPERSEDED = {
    "filter.slip_velocity_scale": _BY_SPREAD,
    "filter.slip_widening": _BY_SPREAD,
    "filter.slow_slip": _BY_SPREAD,
    "filter.wrench_jump": _BY_MODEL,
    "filter.slow_rate_noise": _BY_LEVELS,
    "filter.integrator": _BY_MODEL,
    "filter.model": "filter.method names the reduced estimators",
    "filter.reaction_tolerance": "filter.method names the reduced estimators",
    "filter.max_step": _BY_MODEL,
    "filter.step_tolerance": _BY_MODEL,
    "filter.max_evaluations": _BY_MODEL,
    "filter.free_rate_noise": _BY_LEVELS,
    "filter.contact_rate_noise": _BY_LEVELS,
    "filter.friction_rivals": "several friction hypotheses are always followed until one is "
    "determined",
    "filter.acceleration_stddev": _BY_LEVELS,
    "filter.inflation_threshold": "the process-noise mode of the largest acceleration covers "
    "sudden motions",
}
# Values of `filter.method` that are gone.
OLD_METHODS = ("extended", "iterated", "square_root")
