"""Estimates become the messages of all output topics, the same for the node and for a replay."""

from collections.abc import Iterable
from math import nan

import numpy as np

from peg_on_hole_ros.diagnosis.fence import Fenced
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.messages.markers import marker_array
from peg_on_hole_ros.messages.plain import HOLE_FRAME, floats, header, quaternion, xyz
from peg_on_hole_ros.monitor.output_row import (
    ALARM_WIDTH,
    ALARMS,
    FLAG,
    LEVEL,
    MODE,
    MONITOR_NAMES,
    SIZE,
)
from peg_on_hole_ros.monitor.outputs import outputs_of
from peg_on_hole_ros.monitor.still_possible import StillPossible
from peg_on_hole_ros.records import ANGLES, CONTACTS, Alarm, Outputs, Rows

JOINT_STATE = "sensor_msgs/msg/JointState"
WRENCH = "geometry_msgs/msg/WrenchStamped"
POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"
BOOL = "std_msgs/msg/Bool"
STRING = "std_msgs/msg/String"
UINT8 = "std_msgs/msg/UInt8"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
MARKERS = "visualization_msgs/msg/MarkerArray"

# Of a replay, and of a node that is not renamed.
PREFIX = "/peg_on_hole/"
# Topic under the node's name, and its type.
TOPICS = {
    "state": JOINT_STATE,
    "state_stddev": JOINT_STATE,
    "contacts": JOINT_STATE,
    "contacts_stddev": JOINT_STATE,
    "monitor": JOINT_STATE,
    "contact/k": WRENCH,
    "contact/b1": WRENCH,
    "contact/b2": WRENCH,
    "pose": POSE,
    "transition": BOOL,
    "contact_mode": STRING,
    "alarms": DIAGNOSTICS,
    "alarm_level": UINT8,
    "cycle": STRING,
    "markers": MARKERS,
}
# What was declared last.
DECLARED = ("transition", "contact_mode")
# Published on change, and kept for late subscribers.
LATCHED = (*DECLARED, "alarm_level")
# Without a header, and so without a stamp.
UNSTAMPED = (*LATCHED, "cycle")
# Of a replay alone.
SMOOTHED = {"smoothed_state": JOINT_STATE, "smoothed_state_stddev": JOINT_STATE}

# Three-point contact leaves three degrees of freedom, so the pose's covariance has rank 3, and
# programs that invert it would fail. These standard deviations are added on its diagonal: far
# below what any sensor of a cell resolves.
POSITION_FLOOR = 1.0e-6  # [m]
ROTATION_FLOOR = 1.0e-6  # [rad]
POSE_FLOOR = np.diag([POSITION_FLOOR**2] * 3 + [ROTATION_FLOOR**2] * 3)

ALARM_PERIOD_NS = 100_000_000
# Of markers, where their rate is next to none: 30 years, which is no int64 beside a stamp if more.
_LONGEST_NS = 10**18
_NOT_DETERMINED = (nan, nan, nan)
_NEVER = np.iinfo(np.int64).max
# What is said changes with these of a row.
_WATCHED = [MODE, FLAG, *range(ALARMS + LEVEL, SIZE, ALARM_WIDTH)]
_KNOWN = frozenset(MONITOR_NAMES)
HARDWARE_ID = "peg_on_hole"

Message = tuple[str, str, dict]


class OutputStream:
    """
    Turns one estimate after the other into messages; remembers what is published on change.

    All decisions depend on the estimates and their stamps alone, never on the clock, so a replay
    gives bit for bit what the node gave.

    Parameters
    ----------
    scene : Scene
        For the sizes of peg and hole and the friction cones.
    markers_rate : float
        Most marker messages per second of stamp time [Hz]; 0: none.
    possible : Fenced, optional
        Adds to the alarms what helps, where that can be planned.

    """

    def __init__(
        self,
        scene: Scene,
        markers_rate: float = 10.0,
        possible: Fenced[StillPossible] | None = None,
    ) -> None:
        self._scene, self._possible = scene, possible
        self.set_markers_rate(markers_rate)
        self._markers_ns: int | None = None
        self._alarms_ns: int | None = None
        self._levels: tuple | None = None
        self._worst: int | None = None
        self._mode: str | None = None
        self._transition: bool | None = None
        # Of the row that was last looked at, if nothing else was since.
        self._watched: list[float] | None = None

    def set_markers_rate(self, rate: float) -> None:
        """Take another rate of the markers [Hz]; 0: none."""
        self._markers_period_ns = round(min(1e9 / rate, _LONGEST_NS)) if rate > 0 else None

    def messages(self, outputs: Outputs) -> list[Message]:
        """Return (topic under the node's name, type, fields) of every message of one stamp."""
        return estimate_messages(outputs) + self.said(outputs)

    def said(self, outputs: Outputs) -> list[Message]:
        """Return what is published beside the estimate: on change, and from time to time."""
        messages: list[Message] = []
        self._watched = None
        if outputs.transition != self._transition:
            self._transition = outputs.transition
            messages.append(("transition", BOOL, {"data": bool(outputs.transition)}))
        if outputs.contact_mode != self._mode:
            self._mode = outputs.contact_mode
            messages.append(("contact_mode", STRING, {"data": outputs.contact_mode}))
        levels = tuple((alarm.name, alarm.level) for alarm in outputs.alarms)
        changed = levels != self._levels or self._made_due
        alarms = outputs.alarms
        if self._possible is not None:
            alarms = self._possible(lambda look: look.beside(outputs), alarms)
        # Alarms that nobody looks after are not published: their silence can be told.
        if levels and (changed or _due(outputs.t_ns, self._alarms_ns, ALARM_PERIOD_NS)):
            self._levels, self._alarms_ns = levels, outputs.t_ns
            messages.append(("alarms", DIAGNOSTICS, alarm_array(outputs.t_ns, alarms)))
        worst = max((level for _, level in levels), default=None)
        if worst != self._worst and worst is not None:
            self._worst = worst
            messages.append(("alarm_level", UINT8, {"data": int(worst)}))
        period = self._markers_period_ns
        if period is not None and _due(outputs.t_ns, self._markers_ns, period):
            self._markers_ns = outputs.t_ns
            messages.append(("markers", MARKERS, _markers(outputs, self._scene)))
        return messages

    def said_of_row(self, t_ns: int, row: np.ndarray) -> list[Message]:
        """Return what `said` would of the outputs of a row, which are built only if need be."""
        watched = row[_WATCHED].tolist()
        if watched == self._watched and not self._anything_due(t_ns):
            return []
        messages = self.said(outputs_of(t_ns, row))
        self._watched = watched
        return messages

    def said_of(self, rows: Rows) -> list[tuple[int, list[Message]]]:
        """Return what `said` would with one stamp of many after the other, by place."""
        t_ns = rows.t_ns
        watched = rows.values[:, _WATCHED]
        changes = np.flatnonzero((watched[1:] != watched[:-1]).any(axis=1)) + 1
        places, found, i = iter(changes.tolist()), [], 0
        change = next(places, len(t_ns))
        while i < len(t_ns):
            messages = self.said(outputs_of(int(t_ns[i]), rows.values[i]))
            if messages:
                found.append((i, messages))
            while change <= i:
                change = next(places, len(t_ns))
            i = min(change, *(max(int(np.searchsorted(t_ns, due)), i + 1) for due in self._dues()))
        return found

    @property
    def _made_due(self):
        return self._possible is not None and self._possible(lambda look: look.due, False)

    def _anything_due(self, t_ns):
        alarms = self._alarms_ns is not None and _due(t_ns, self._alarms_ns, ALARM_PERIOD_NS)
        period = self._markers_period_ns
        return (
            self._made_due
            or alarms
            or (period is not None and _due(t_ns, self._markers_ns, period))
        )

    def _dues(self):
        """Return the stamps from which on alarms and markers are due again [ns]."""
        # What is made at the next stamp is due whenever that is.
        dues = [_NEVER, *([-_NEVER] if self._made_due else [])]
        if self._alarms_ns is not None:
            dues.append(self._alarms_ns + ALARM_PERIOD_NS)
        if self._markers_period_ns is not None:
            dues.append((self._markers_ns or 0) + self._markers_period_ns)
        return dues


def estimate_messages(outputs: Outputs) -> list[Message]:
    """Return the messages that come with every stamp."""
    known = reactions_known(outputs)
    return [
        *_state(outputs),
        *_contacts(outputs, known),
        ("monitor", JOINT_STATE, _monitor(outputs)),
        *_contact_wrenches(outputs, known),
        ("pose", POSE, _pose(outputs)),
    ]


def _markers(outputs, scene):
    return marker_array(outputs, scene, reactions_known(outputs))


def _due(t_ns, last_ns, period_ns):
    # Stamps may jump back: a bag played again, a simulator started again.
    return last_ns is None or not last_ns <= t_ns < last_ns + period_ns


def joint_state(
    t_ns: int,
    names: Iterable[str],
    position: Iterable[float] = (),
    velocity: Iterable[float] = (),
    effort: Iterable[float] = (),
    frame: str = HOLE_FRAME,
) -> dict:
    """Return sensor_msgs/JointState."""
    return {
        "header": header(t_ns, frame),
        "name": list(names),
        "position": floats(position),
        "velocity": floats(velocity),
        "effort": floats(effort),
    }


def _state(outputs):
    t_ns, state = outputs.t_ns, outputs.state
    # Rounding may leave a variance of zero a hair below it.
    stddev = np.sqrt(np.maximum(np.diagonal(outputs.state_covariance), 0.0))
    yield "state", JOINT_STATE, joint_state(t_ns, ANGLES, state[:3], state[3:])
    yield "state_stddev", JOINT_STATE, joint_state(t_ns, ANGLES, stddev[:3], stddev[3:])


def smoothed_messages(t_ns: int, state: np.ndarray, covariance: np.ndarray) -> list[Message]:
    """Return `smoothed_state` and `smoothed_state_stddev`, which only a replay can give."""
    # To (-pi, pi], as in the filter's own state.
    angles = state[:3] - 2 * np.pi * np.ceil((state[:3] - np.pi) / (2 * np.pi)) * [0, 1, 1]
    stddev = np.sqrt(np.maximum(np.diagonal(covariance), 0.0))
    return [
        ("smoothed_state", JOINT_STATE, joint_state(t_ns, ANGLES, angles, state[3:])),
        ("smoothed_state_stddev", JOINT_STATE, joint_state(t_ns, ANGLES, stddev[:3], stddev[3:])),
    ]


def reactions_known(outputs: Outputs) -> bool:
    """Return whether the reactions are numbers: determined, or none as nothing touches."""
    determined = outputs.monitor["reactions_determined"] == 1.0
    return determined or outputs.contact_mode == "open"


def _contacts(outputs, known):
    t_ns = outputs.t_ns
    normal = outputs.normal if known else _NOT_DETERMINED
    contacts = joint_state(t_ns, CONTACTS, outputs.closed, outputs.slip_speed, normal)
    stddev = joint_state(t_ns, CONTACTS, (), outputs.slip_speed_stddev, outputs.normal_stddev)
    yield "contacts", JOINT_STATE, contacts
    yield "contacts_stddev", JOINT_STATE, stddev


def _monitor(outputs):
    return joint_state(outputs.t_ns, MONITOR_NAMES, monitor_values(outputs.monitor))


def monitor_values(told: dict[str, float]) -> list[float]:
    """
    Return a value for each of MONITOR_NAMES, NaN for one that does not exist at present.

    Raises
    ------
    KeyError
        A name that is not in the list: it would be lost without a word.

    """
    if not told.keys() <= _KNOWN:
        raise KeyError(f"not in MONITOR_NAMES: {sorted(told.keys() - _KNOWN)}")
    return [float(told.get(name, nan)) for name in MONITOR_NAMES]


def _contact_wrenches(outputs, known):
    points = outputs.contact_point.tolist()
    forces = outputs.contact_force.tolist() if known else [_NOT_DETERMINED] * len(CONTACTS)
    for name, (x, y, z), (X, Y, Z) in zip(CONTACTS, points, forces):
        torque = {"x": y * Z - z * Y, "y": z * X - x * Z, "z": x * Y - y * X}
        wrench = {"force": {"x": X, "y": Y, "z": Z}, "torque": torque}
        yield f"contact/{name.lower()}", WRENCH, {"header": header(outputs.t_ns), "wrench": wrench}


def _pose(outputs):
    pose = {"position": xyz(outputs.position), "orientation": quaternion(outputs.rotation)}
    covariance = floats(outputs.pose_covariance + POSE_FLOOR)
    return {"header": header(outputs.t_ns), "pose": {"pose": pose, "covariance": covariance}}


def alarm_array(t_ns: int, alarms: tuple[Alarm, ...]) -> dict:
    """Return diagnostic_msgs/DiagnosticArray; numbers as texts that read back unchanged."""
    return {
        "header": header(t_ns),
        "status": [
            {
                "level": int(alarm.level),
                "name": alarm.name,
                "message": alarm.message,
                "hardware_id": HARDWARE_ID,
                "values": [{"key": key, "value": repr(float(x))} for key, x in alarm.values],
            }
            for alarm in alarms
        ],
    }
