"""Topics of all outputs, and the messages that are published on change and from time to time."""

from bisect import bisect_right
from collections.abc import Callable, Iterable

import numpy as np

from peg_on_hole_ros.diagnosis.guarded_looks import GuardedLook
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.messages.markers import marker_array
from peg_on_hole_ros.messages.plain import HOLE_FRAME, floats, header
from peg_on_hole_ros.monitor.output_view import OutputView
from peg_on_hole_ros.monitor.still_possible import StillPossible
from peg_on_hole_ros.records import ANGLES, Alarm, Rows

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

ALARM_PERIOD_NS = 100_000_000
# Of markers, where their rate is next to none: 30 years, which is no int64 beside a stamp if more.
_LONGEST_NS = 10**18
_NEVER_NS = np.iinfo(np.int64).max
HARDWARE_ID = "peg_on_hole"

Message = tuple[str, str, dict]


class OutputStream:
    """
    Says what is published beside the estimates; remembers what is published on change.

    All decisions depend on the estimates and their stamps alone, never on the clock, so a replay
    gives bit for bit what the node gave.

    Parameters
    ----------
    scene : Scene
        For the sizes of peg and hole and the friction cones.
    markers_rate : float
        Most marker messages per second of stamp time [Hz]; 0: none.
    possible : GuardedLook, optional
        Adds to the alarms what helps, where that can be planned.
    frame : str
        The hole's, which messages are in.

    """

    def __init__(
        self,
        scene: Scene,
        markers_rate: float = 10.0,
        possible: GuardedLook[StillPossible] | None = None,
        frame: str = HOLE_FRAME,
    ) -> None:
        self._scene, self._possible, self._frame = scene, possible, frame
        self.set_markers_rate(markers_rate)
        self._markers_ns: int | None = None
        self._alarms_ns: int | None = None
        self._levels: tuple | None = None
        self._worst: int | None = None
        self._mode: str | None = None
        self._transition: bool | None = None
        # Of the last row, if what was published is of it.
        self._watched: tuple | None = None

    def set_markers_rate(self, rate: float) -> None:
        """Take another rate of the markers [Hz]; 0: none."""
        self._markers_period_ns = round(min(1e9 / rate, _LONGEST_NS)) if rate > 0 else None

    def beside(
        self, rows: Rows, announced: Callable[[OutputView], OutputView] | None = None
    ) -> list[tuple[int, list[Message]]]:
        """
        Return what is published beside the estimates, by place of stamp.

        Parameters
        ----------
        rows : Rows
            Of stamps that rise.
        announced : callable, optional
            Returns outputs whose alarms may differ from those of their row; all rows are looked
            at then.

        """
        t_ns, values = rows
        watched = _watched(values[0])
        changes = [0] if announced or watched != self._watched else []
        changes += range(1, len(t_ns)) if announced else _changes(values)
        found: list[tuple[int, list[Message]]] = []
        place = (
            0 if changes[:1] == [0] or self._is_due(int(t_ns[0])) else self._next(0, t_ns, changes)
        )
        while place < len(t_ns):
            outputs = OutputView(int(t_ns[place]), values[place])
            messages = self._beside(announced(outputs) if announced else outputs)
            if messages:
                found.append((place, messages))
            place = self._next(place, t_ns, changes)
        if len(t_ns) > 1:
            watched = _watched(values[-1])
        self._watched = None if announced else watched
        return found

    def _next(self, place, t_ns, changes):
        """Return the next place at which something changes or is due."""
        if place + 1 == len(t_ns):
            return len(t_ns)
        at = bisect_right(changes, place)
        dues = (max(int(np.searchsorted(t_ns, due)), place + 1) for due in self._dues())
        return min(*changes[at : at + 1], *dues, len(t_ns))

    def _beside(self, outputs: OutputView) -> list[Message]:
        """Return what is published beside the estimate of one stamp, and remember it."""
        messages: list[Message] = []
        if outputs.transition != self._transition:
            self._transition = outputs.transition
            messages.append(("transition", BOOL, {"data": outputs.transition}))
        if outputs.contact_mode != self._mode:
            self._mode = outputs.contact_mode
            messages.append(("contact_mode", STRING, {"data": outputs.contact_mode}))
        levels = tuple((alarm.name, alarm.level) for alarm in outputs.alarms)
        changed = levels != self._levels or self._made_due
        alarms = outputs.alarms
        if self._possible is not None:
            alarms = self._possible(lambda look: look.beside(outputs), alarms)
        # Alarms that nobody looks after are not published: their silence shows.
        if levels and (changed or _due(outputs.t_ns, self._alarms_ns, ALARM_PERIOD_NS)):
            self._levels, self._alarms_ns = levels, outputs.t_ns
            messages.append(
                ("alarms", DIAGNOSTICS, alarm_array(outputs.t_ns, alarms, self._frame))
            )
        worst = max((level for _, level in levels), default=None)
        if worst != self._worst and worst is not None:
            self._worst = worst
            messages.append(("alarm_level", UINT8, {"data": int(worst)}))
        period = self._markers_period_ns
        if period is not None and _due(outputs.t_ns, self._markers_ns, period):
            self._markers_ns = outputs.t_ns
            shown = marker_array(outputs, self._scene, self._frame)
            messages.append(("markers", MARKERS, shown))
        return messages

    @property
    def _made_due(self):
        return self._possible is not None and self._possible(lambda look: look.due, False)

    def _is_due(self, t_ns):
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
        dues = [_NEVER_NS, *([-_NEVER_NS] if self._made_due else [])]
        if self._alarms_ns is not None:
            dues.append(self._alarms_ns + ALARM_PERIOD_NS)
        if self._markers_period_ns is not None:
            dues.append((self._markers_ns or 0) + self._markers_period_ns)
        return dues


def _watched(row):
    """Return of a row that with which what is published beside it changes."""
    levels = row["alarms"]["level"].tolist()
    return row["contact_mode"].item(), row["transition"].item(), *levels


def _changes(values):
    """Return the places at which that differs from the row before."""
    if len(values) == 1:
        return []
    differ = (values["alarms"]["level"][1:] != values["alarms"]["level"][:-1]).any(axis=1)
    for name in ("contact_mode", "transition"):
        differ |= values[name][1:] != values[name][:-1]
    return (np.flatnonzero(differ) + 1).tolist()


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


def smoothed_messages(
    t_ns: int, state: np.ndarray, covariance: np.ndarray, frame: str = HOLE_FRAME
) -> list[Message]:
    """Return `smoothed_state` and `smoothed_state_stddev`, which only a replay can give."""
    # To (-pi, pi], as in the filter's own state.
    angles = state[:3] - 2 * np.pi * np.ceil((state[:3] - np.pi) / (2 * np.pi)) * [0, 1, 1]
    angles[0] = max(angles[0], 0.0)
    stddev = np.sqrt(np.maximum(np.diagonal(covariance), 0.0))
    told = joint_state(t_ns, ANGLES, angles, state[3:], frame=frame)
    spread = joint_state(t_ns, ANGLES, stddev[:3], stddev[3:], frame=frame)
    return [
        ("smoothed_state", JOINT_STATE, told),
        ("smoothed_state_stddev", JOINT_STATE, spread),
    ]


def alarm_array(t_ns: int, alarms: tuple[Alarm, ...], frame: str = HOLE_FRAME) -> dict:
    """Return diagnostic_msgs/DiagnosticArray; numbers as texts that read back unchanged."""
    return {
        "header": header(t_ns, frame),
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
