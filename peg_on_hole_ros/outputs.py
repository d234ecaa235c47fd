"""
The table of outputs: what an estimate says, one entry for each output, in the order of the row.

From it come the row that compiled code fills in (`monitor.output_row`), the messages and their
bytes (`messages.published`), the columns of a replay, and the tables in `docs/topics.md`. A new
number in `~/monitor` is one entry here and one assignment where it is computed.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from peg_on_hole_ros.records import ACCURACIES, ANGLES, CONTACTS, UNOBSERVABLE_SETTINGS
from peg_on_hole_ros.typed_record import Floats, Matrix3, Matrix6, Record, Vector3, Vector6


@dataclass(frozen=True)
class Entry:
    """
    An entry of the table.

    Attributes
    ----------
    topic : str
        Under the node's name; several, apart by blanks, share the numbers evenly, in this order.
        Empty: it is not published as it is.
    field : str
        Of the message; several share the numbers of a topic evenly.
    unit : str
        Empty: it has none.
    meaning : str
        One line.
    missing : str
        When it is NaN in the message; empty: never.
    names : tuple of str
        Of its numbers, where there are several with a name each.

    """

    topic: str
    field: str
    unit: str
    meaning: str
    missing: str = ""
    names: tuple[str, ...] = ()


# The row has numbers there; the messages do not.
NOT_DETERMINED = "`reactions_determined` is not 1, and the contact mode is not `open`"

# When numbers of the monitor do not exist.
_NO_MODES = "`monitor.modes` is false"
_UNJUDGED = "in the air, without orientations for long, and where `monitor.modes` is false"
_NOT_IN_HOLE = "elsewhere than in the hole"
_NOT_ON_TWO = "unless the peg is determined to be on K and B"
_NO_CLOSING = "unless the peg closes on three contacts, by two standard deviations of its rate"
_NO_PLACE = "without the place of the hole (`joints.hole_xyz_stddev`)"
_NO_BIAS = "without a tare, if no bias is stated to be uncertain"
_BIAS_KNOWN = "if no bias is stated to be uncertain"
_TILT_KNOWN = "if the tilt of the hole is stated to be exact"
_NOT_ON_THREE = "unless the contact mode is `three_point`, and until there are enough wrenches"

BIAS_NAMES = tuple(f"bias_{kind}_{axis}" for kind in ("force", "torque") for axis in "xyz")
TILT_NAMES = ("hole_tilt_x", "hole_tilt_y")


def _monitor(unit: str, meaning: str, missing: str = "", names: tuple[str, ...] = ()) -> Entry:
    return Entry("monitor", "position", unit, meaning, missing, names)


class AlarmRow(Record):
    """An alarm as numbers; `monitor.alarm_text` has the words."""

    # Below zero: nobody has looked at it.
    level: Annotated[int, Entry("alarms", "status.level", "", "0 OK, 1 WARN, 2 ERROR")]
    which: Annotated[int, Entry("", "", "", "which of its texts")]
    held: Annotated[int, Entry("", "", "", "1: held without a cause; NOT_JUDGED")]
    kind: Annotated[int, Entry("", "", "", "which names its numbers have; 0: none")]
    numbers: Annotated[Floats, (7,), Entry("alarms", "status.values", "", "what is behind it")]


class Row(Record):
    """
    What one wrench gives.

    What is published with every wrench comes first, as numbers in the order of the messages;
    a number that is not filled in is NaN.
    """

    state: Annotated[
        Vector6,
        Entry(
            "state",
            "position velocity",
            "rad, rad/s",
            "gamma, psi, phi, with psi and phi in (-pi, pi], and their Euler rates",
            names=ANGLES,
        ),
    ]
    state_stddev: Annotated[
        Vector6,
        Entry(
            "state_stddev",
            "position velocity",
            "rad, rad/s",
            "standard deviations of the state",
            names=ANGLES,
        ),
    ]
    closed: Annotated[
        Vector3,
        Entry(
            "contacts",
            "position",
            "",
            "1 closed, 0 open, by the contact mode; if that is `unknown`, by the load",
            names=CONTACTS,
        ),
    ]
    slip_speed: Annotated[
        Vector3, Entry("contacts", "velocity", "m/s", "slip speed", names=CONTACTS)
    ]
    normal: Annotated[
        Vector3,
        Entry(
            "contacts", "effort", "N", "normal reaction, 0 in the air", NOT_DETERMINED, CONTACTS
        ),
    ]
    slip_speed_stddev: Annotated[
        Vector3,
        Entry(
            "contacts_stddev",
            "velocity",
            "m/s",
            "standard deviation of the slip speed",
            names=CONTACTS,
        ),
    ]
    normal_stddev: Annotated[
        Vector3,
        Entry(
            "contacts_stddev",
            "effort",
            "N",
            "standard deviation of the reaction",
            names=CONTACTS,
        ),
    ]

    transition_probability: Annotated[
        float,
        _monitor(
            "", "probability that gamma is below gamma0, the clearance's uncertainty included"
        ),
    ]
    time_to_transition: Annotated[
        float,
        _monitor("s", "time until the tilt reaches gamma0, if its trend continues", _NO_CLOSING),
    ]
    time_to_transition_stddev: Annotated[
        float, _monitor("s", "standard deviation of `time_to_transition`", _NO_CLOSING)
    ]
    jamming_risk: Annotated[
        float,
        _monitor("", "probability of jamming within `monitor.jamming_horizon`", _UNJUDGED),
    ]
    jamming_wedging: Annotated[
        float, _monitor("", "part of the risk: friction wedges the peg", _UNJUDGED)
    ]
    jamming_stall: Annotated[
        float, _monitor("", "part of the risk: friction stops the motion", _UNJUDGED)
    ]
    jamming_load: Annotated[
        float, _monitor("", "part of the risk: a reaction exceeds `monitor.max_normal`", _UNJUDGED)
    ]
    determinant: Annotated[
        float,
        _monitor(
            "",
            "determinant of the six equations, divided by that without friction",
            "in the hole, in the air, without orientations for long, and where `monitor.modes` is "
            "false",
        ),
    ]
    insertion_ratio: Annotated[float, _monitor("", "l/d: depth divided by diameter", _NOT_IN_HOLE)]
    whitney_margin: Annotated[
        float, _monitor("N", "push left before the peg jams, by Whitney's diagram", _NOT_IN_HOLE)
    ]
    insertion_depth: Annotated[
        float,
        _monitor(
            "m",
            "depth of the centre of the peg's lower end; with chamfers, of the shoulder below the "
            "throat",
            _NOT_ON_TWO,
        ),
    ]
    insertion_depth_stddev: Annotated[
        float, _monitor("m", "standard deviation of `insertion_depth`", _NOT_ON_TWO)
    ]
    insertion_speed: Annotated[
        float, _monitor("m/s", "speed of that point into the hole", _NOT_ON_TWO)
    ]
    insertion_speed_stddev: Annotated[
        float, _monitor("m/s", "standard deviation of `insertion_speed`", _NOT_ON_TWO)
    ]
    three_point_validity: Annotated[
        float,
        _monitor("", "probability that wrench and pose fit three contacts at all", _NO_MODES),
    ]
    mode_probability_three_point: Annotated[
        float, _monitor("", "the peg slides on K, B1 and B2", _NO_MODES)
    ]
    mode_probability_two_point: Annotated[
        float, _monitor("", "the peg touches below gamma0", _NO_MODES)
    ]
    mode_probability_K_alone: Annotated[
        float,
        _monitor("", "part of `mode_probability_two_point`: K alone touches", _NOT_ON_TWO),
    ]
    mode_probability_B_alone: Annotated[
        float,
        _monitor("", "part of `mode_probability_two_point`: one wall alone touches", _NOT_ON_TWO),
    ]
    mode_probability_opened: Annotated[
        float,
        _monitor("", "the peg touches above gamma0, but K, B1 or B2 is open", _NO_MODES),
    ]
    mode_probability_stuck: Annotated[
        float,
        _monitor("", "the peg rests on all three, slower than `monitor.rest_speed`", _NO_MODES),
    ]
    mode_probability_free: Annotated[float, _monitor("", "the peg touches nothing", _NO_MODES)]
    mode_probability_unknown: Annotated[
        float, _monitor("", "the peg touches in a way for which there is no model", _NO_MODES)
    ]
    mode_probability_elsewhere: Annotated[
        float, _monitor("", "the peg touches something beside the hole", _NO_MODES)
    ]
    contact_age: Annotated[
        float, _monitor("s", "how long the peg has touched something", "nothing touches")
    ]
    contact_latency: Annotated[
        float, _monitor("s", "delay from that contact to its declaration", "nothing touches")
    ]
    free_age: Annotated[
        float, _monitor("s", "how long the peg has touched nothing", "something touches")
    ]
    free_latency: Annotated[
        float,
        _monitor("s", "delay from that loss of contact to its declaration", "something touches"),
    ]
    reactions_determined: Annotated[float, _monitor("", "**use the reactions only at 1**; 0 or 1")]
    friction: Annotated[
        float,
        _monitor(
            "", "friction coefficient: estimated, or stated where `scene.friction_stddev` is 0"
        ),
    ]
    friction_stddev: Annotated[float, _monitor("", "standard deviation of `friction`")]
    friction_before: Annotated[
        float,
        _monitor(
            "", "friction before its last step in this contact", "no step of friction was found"
        ),
    ]
    clearance: Annotated[
        float,
        _monitor("m", "clearance: estimated, or stated where `scene.clearance_stddev` is 0"),
    ]
    clearance_stddev: Annotated[float, _monitor("m", "standard deviation of `clearance`")]
    position_offset: Annotated[
        float,
        _monitor(
            "m",
            "distance from the place by the robot's joints to the place by the contacts",
            _NO_PLACE,
        ),
    ]
    position_misfit: Annotated[float, _monitor("", "the same in standard deviations", _NO_PLACE)]
    nis_median: Annotated[
        float,
        _monitor(
            "",
            "median of the last 200 NIS: 2.4 if the noise is as stated, above 3.3 if it is not",
            "until there are enough",
        ),
    ]
    nis_drift: Annotated[
        float,
        _monitor(
            "",
            "how far innovations are off in one direction: 3 if all is as stated, above 30 if not",
            "until there are enough, and where bias or tilt are uncertain",
        ),
    ]
    joints_noise: Annotated[
        float,
        _monitor("", "measured over stated standard deviation of orientations: 1 to 20"),
    ]
    bias: Annotated[
        Vector6,
        _monitor("N, N m", "what the unloaded sensor reads", _NO_BIAS, BIAS_NAMES),
    ]
    hole_tilt: Annotated[
        Floats,
        (2,),
        _monitor("rad", "tilt of the hole from the configured axis", _TILT_KNOWN, TILT_NAMES),
    ]
    bias_stddev: Annotated[
        Vector6,
        _monitor(
            "N, N m",
            "standard deviations of the bias",
            _BIAS_KNOWN,
            tuple(f"{name}_stddev" for name in BIAS_NAMES),
        ),
    ]
    hole_tilt_stddev: Annotated[
        Floats,
        (2,),
        _monitor(
            "rad",
            "standard deviations of the hole's tilt",
            _TILT_KNOWN,
            tuple(f"{name}_stddev" for name in TILT_NAMES),
        ),
    ]
    doubt: Annotated[
        Floats,
        (len(UNOBSERVABLE_SETTINGS),),
        _monitor(
            "N",
            "largest change of a reaction by the remaining error of a setting",
            _NOT_ON_THREE,
            tuple(f"doubt_{name}" for name in UNOBSERVABLE_SETTINGS),
        ),
    ]
    accuracy_doubt: Annotated[
        Floats,
        (len(ACCURACIES),),
        _monitor(
            "N",
            "standard deviation that a stated accuracy adds to the reaction that it changes most",
            "unless the peg is on three contacts or determined to be on K and B, and if every "
            "`accuracy.*` and `wrench.low_pass` is 0",
            tuple(f"doubt_{name}" for name in ACCURACIES),
        ),
    ]

    contact_wrench: Annotated[
        Floats,
        (3, 6),
        Entry(
            "contact/k contact/b1 contact/b2",
            "wrench.force wrench.torque",
            "N, N m",
            "force on the peg, normal and friction, and its torque about the origin of `hole`",
            NOT_DETERMINED,
        ),
    ]
    position: Annotated[
        Vector3,
        Entry("pose", "pose.pose.position", "m", "origin of the peg in `hole`"),
    ]
    orientation: Annotated[
        Floats,
        (4,),
        Entry("pose", "pose.pose.orientation", "", "peg axes in hole axes as x, y, z, w; w >= 0"),
    ]
    pose_covariance: Annotated[
        Matrix6,
        Entry(
            "pose",
            "pose.covariance",
            "m^2, m rad, rad^2",
            "x, y, z, rotation about x, y, z of `hole`; 1e-6 m and 1e-6 rad are added so that "
            "it can be inverted",
        ),
    ]

    # What is published on change or from time to time.
    contact_mode: Annotated[
        int,
        Entry(
            "contact_mode",
            "data",
            "",
            "`three_point`, `two_point`, `open`, `unknown`, `elsewhere` or `inserted`; in the "
            "row as a number",
        ),
    ]
    transition: Annotated[
        bool,
        Entry("transition", "data", "", "three-point contact has become two-point contact"),
    ]
    alarms: Annotated[
        Sequence[AlarmRow],
        (3,),
        Entry("alarms", "status", "", "`jamming`, `contact_loss`, `overload`"),
    ]

    # What the package reads, and does not publish.
    state_covariance: Annotated[Matrix6, Entry("", "", "rad^2, rad^2/s", "of the state")]
    contact_point: Annotated[Matrix3, Entry("", "", "m", "K, B1, B2 (rows) in `hole`")]
    rotation: Annotated[Matrix3, Entry("", "", "", "R_HP, peg axes in hole axes")]
