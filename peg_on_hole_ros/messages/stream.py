"""From messages in their order of arrival to messages out: what the node runs and a replay too."""

import json
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

from peg_on_hole_ros.config.configuration import (
    BY_NAME,
    from_parameters,
    node_options,
    to_parameters,
)
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.diagnosis.guarded_looks import GuardedLook
from peg_on_hole_ros.engine.announced_motion import MODES, NOTHING
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.estimator.methods.method import Make
from peg_on_hole_ros.estimator.methods.registry import make_filter
from peg_on_hole_ros.measurements.edges import at_edges
from peg_on_hole_ros.measurements.orientation import (
    JointOrientation,
    PegJoints,
    UndescribedRobot,
)
from peg_on_hole_ros.messages.beside_estimates import STRING, Message, OutputStream
from peg_on_hole_ros.messages.columns import OutputColumns
from peg_on_hole_ros.messages.decode import Malformed, frame_of, joint_sample, wrench_sample
from peg_on_hole_ros.messages.learnt_layout import JointsReader, WrenchReader
from peg_on_hole_ros.messages.published import LAYOUTS, EstimateEncoder
from peg_on_hole_ros.messages.tries import Tries, json_line
from peg_on_hole_ros.messages.wrench_frames import WrenchFrames
from peg_on_hole_ros.monitor.still_possible import StillPossible
from peg_on_hole_ros.records import Answer, Arrivals, JointSample, Rows, WrenchSample
from peg_on_hole_ros.robot.described import described, with_description
from peg_on_hole_ros.robot.sensor_frame import mounting
from peg_on_hole_ros.robot.urdf_source import awaited
from peg_on_hole_ros.safe_text import shown

# Begins an event that sets parameters; what follows is JSON.
SET = "set "
# Begins one that announces a motion.
EXPECT = "expect "


def is_event(name: str) -> bool:
    """Return whether this version knows an event."""
    if name.startswith(EXPECT):
        return name.removeprefix(EXPECT) in (*MODES, NOTHING)
    return name in ("reset", "tare", "payload") or name.startswith(SET)


class Published(NamedTuple):
    """
    What a wrench makes known, as the node publishes it.

    Attributes
    ----------
    t_ns : int
        Stamp [ns].
    estimate : list of (str, bytes)
        Topic under the node's name and serialised message of all that comes with every stamp.
    pose : callable
        Returns its PoseWithCovarianceStamped.
    beside : list of Message
        What is published beside it.

    """

    t_ns: int
    estimate: list[tuple[str, bytes]]
    pose: Callable[[], dict]
    beside: list[Message]


class MessageStream:
    """
    Decoding, pipeline and output stream in a row; the same input gives the same output, bitwise.

    Parameters
    ----------
    configuration : Configuration
    pipeline : Pipeline
        Made from the same configuration.
    markers_rate : float
        Most marker messages per second of stamp time [Hz]; 0: none.

    Attributes
    ----------
    pipeline : Pipeline
    t_ns : int or None
        Stamp of the latest estimate [ns].
    frame : str or None
        frame_id of the wrench, see `take_frame`; None: not known yet.
    refused : str
        Why no wrench is used, as its frame_id contradicts what is stated; empty: they are.
    frames : WrenchFrames
        Which frame_id is that of the first wrench.

    """

    def __init__(
        self, configuration: Configuration, pipeline: Pipeline, markers_rate: float = 10.0
    ) -> None:
        self.pipeline = pipeline
        self.t_ns: int | None = None
        self.frame: str | None = None
        self.refused = ""
        self.frames = WrenchFrames(configuration.wrench.sensor_pose == "frame_id")
        self._possible = GuardedLook(
            "still_possible", lambda: StillPossible(configuration), pipeline.failures
        )
        self._hole = configuration.frames.hole
        self._outputs = OutputStream(configuration.scene, markers_rate, self._possible, self._hole)
        self._tries = Tries(configuration.monitor.inserted_depth > 0.0)
        self._parameters = to_parameters(configuration) | {"markers_rate": markers_rate}
        joints = configuration.joints
        self._joints_needed = joints.names
        self._wrenches, self._joints = WrenchReader(), JointsReader(joints.names)
        self._encoder = EstimateEncoder(self._hole)
        self._unusable: Counter[str] = Counter()

    @property
    def counts(self) -> dict[str, int]:
        """Every message by fate; those that never reached the pipeline's own counts by reason."""
        return {**self.pipeline.counts, **self._unusable}

    @property
    def causes(self) -> list[str]:
        """What makes the numbers doubtful by the data, a line each."""
        return [*self._of_frames, *self.pipeline.causes]

    @property
    def contradicted(self) -> list[str]:
        """Settings that the data have contradicted, a line each: some of the causes."""
        return [*self._of_frames, *self.pipeline.contradicted]

    @property
    def _of_frames(self):
        line = self.frames.line(self.t_ns)
        return [f"wrench: {line}"] if line else []

    @property
    def failed_looks(self) -> list[str]:
        """Side looks that failed, with their errors, a line each."""
        return self.pipeline.failures.lines

    def on_wrench(self, message: Any) -> list[Message]:
        """Take a geometry_msgs/WrenchStamped in any form; return what it makes known."""
        columns = self.take_wrench(wrench_sample(message), frame_of(message))
        return [] if columns is None else columns.messages(0)

    def take_wrench(
        self, sample: WrenchSample | Malformed, frame: str = ""
    ) -> OutputColumns | None:
        """
        Take a wrench that was read, or what is wrong with it; return what it makes known.

        Parameters
        ----------
        sample : WrenchSample or Malformed
        frame : str
            Its frame_id; empty: that of the wrenches before, or none.

        """
        if isinstance(sample, Malformed):
            self._unusable[f"wrench_dropped_malformed_{sample.reason}"] += 1
        elif self.frames.is_other(frame):
            self._unusable["wrench_dropped_other_frame"] += 1
            self.frames.note(frame, sample.t_ns)
        elif self.refused:
            self._unusable["wrench_dropped_sensor_contradicted"] += 1
        else:
            self.frames.begin(frame, sample.t_ns)
            return self._columns(self.pipeline.take_wrench(sample))
        return None

    def _columns(self, rows: Rows) -> OutputColumns | None:
        """Return what is published of rows, and beside them; None if there are none."""
        if not len(rows.t_ns):
            return None
        self.t_ns = int(rows.t_ns[-1])
        announced = self.pipeline.without_announced_alarms if self.pipeline.expecting else None
        columns = OutputColumns(rows, self._outputs.beside(rows, announced), self._hole)
        columns.add((place, _cycle_messages(ended)) for place, ended in self._tries.take(columns))
        return columns

    def take_wrench_bytes(self, payload: bytes, read: Callable[[bytes], Any]) -> Published | None:
        """
        Take a serialised WrenchStamped; return the messages of `on_wrench`, most in bytes.

        Parameters
        ----------
        payload : bytes
        read : callable
            Makes a message of it, or None; what differs in more than numbers needs that.

        """
        sample, frame = self._wrenches.read(payload), ""
        if sample is None:
            message = read(payload)
            if message is None:
                return None
            sample, frame = wrench_sample(message), frame_of(message)
            if not self.frames.is_other(frame):
                self._wrenches.learn(payload)
        columns = self.take_wrench(sample, frame)
        if columns is None:
            return None
        t_ns, numbers = int(columns.t_ns[0]), columns.numbers[0]
        beside = [message for _, messages in columns.beside for message in messages]
        pose = partial(_pose, t_ns, numbers, self._hole)
        return Published(t_ns, self._encoder(t_ns, numbers), pose, beside)

    def take(self, arrivals: Arrivals, begin: int) -> tuple[int, OutputColumns | None]:
        """
        Take messages from a place on, see `Pipeline.push`.

        Returns
        -------
        end : int
            Place of the first that is not taken.
        columns : OutputColumns or None
            What they make known.

        """
        end, rows = self.pipeline.push(arrivals, begin)
        return end, self._columns(rows)

    def take_frame(self, frame: str) -> Answer:
        """
        Take the frame_id of the wrench, before the first one; the sensor's pose may follow.

        Returns
        -------
        Answer
            Whether the pose is known by it, or by what is stated, and what there is to say of it;
            empty: nothing.

        """
        self.frame = frame
        try:
            wrench, line = mounting(self.pipeline.configuration, frame)
        except PegOnHoleError as error:
            self.refused = str(error)
            return Answer(False, self.refused)
        found = wrench != self.pipeline.configuration.wrench
        if found:
            self.pipeline.set_sensor_pose(wrench.sensor_xyz, wrench.sensor_rpy)
        return Answer(found or not line, line)

    def use_robot_description(self, text: str) -> None:
        """
        Take the robot's description, for which joint states and wrenches wait.

        Raises
        ------
        PegOnHoleError
            It cannot be used.

        """
        configuration = with_description(self.pipeline.configuration, text)
        self.pipeline.use_robot_description(configuration, orientation_of(configuration))
        self._possible(lambda look: look.take(configuration), None)

    def finish(self) -> list[Message]:
        """End a try that is under way; return what that makes known."""
        return _cycle_messages(self._tries.finish())

    def on_joints(self, message: Any) -> None:
        """Take a sensor_msgs/JointState in any form."""
        self.take_joints(joint_sample(message, self._joints_needed))

    def take_joints_bytes(self, payload: bytes, read: Callable[[bytes], Any]) -> None:
        """Take a serialised JointState; `read` as in `take_wrench_bytes`."""
        sample = self._joints.read(payload)
        if sample is None:
            message = read(payload)
            if message is None:
                return
            sample = joint_sample(message, self._joints_needed)
            if isinstance(sample, JointSample):
                self._joints.learn(payload, sample.names)
        self.take_joints(sample)

    def take_joints(self, sample: JointSample | Malformed) -> None:
        """Take a joint state that was read, or what is wrong with it."""
        if isinstance(sample, Malformed):
            self._unusable[f"joints_dropped_malformed_{sample.reason}"] += 1
        else:
            self.pipeline.on_joints(sample)

    def unreadable(self, source: str) -> None:
        """Count bytes that are no message, from `wrench` or `joints`."""
        self._unusable[f"{source}_dropped_malformed_unreadable"] += 1

    def pushed_out(self, source: str) -> None:
        """Count a message of `wrench` or `joints` for which there was no time."""
        self._unusable[f"{source}_dropped_overload"] += 1

    def missing(self, source: str, count: int) -> None:
        """Count messages of `wrench` or `joints` that were sent and never came."""
        self._unusable[f"{source}_dropped_not_received"] += count

    def undescribed(self, source: str) -> None:
        """Count a message of `wrench` or `joints` that came before the robot's description."""
        self._unusable[f"{source}_dropped_without_description"] += 1

    def failed(self, what: str) -> None:
        """Count an error of the program at `wrench`, `joints`, or a service by its name."""
        self._unusable[f"{what}_dropped_internal_error"] += 1

    def on_event(self, name: str) -> Answer:
        """
        Carry out an event; return whether it was done, and in words what happened.

        Parameters
        ----------
        name : str
            `reset`, `tare`, `payload`, `expect` and a motion, or `set` and a JSON object of
            parameters by their names.

        Raises
        ------
        KeyError
            Any other name.

        """
        if name.startswith(SET):
            return self._set(name.removeprefix(SET))
        if name.startswith(EXPECT):
            return self.pipeline.expect(name.removeprefix(EXPECT))
        return {
            "reset": self.pipeline.reset,
            "tare": self.pipeline.tare,
            "payload": self.pipeline.take_pose,
        }[name]()

    def _set(self, text):
        try:
            changed = json.loads(text)
            fixed = [name for name in changed if name not in BY_NAME or not BY_NAME[name].live]
            if fixed:
                return Answer(False, f"{', '.join(fixed)} cannot be set in a stream that runs")
            parameters = self._parameters | changed
            configuration, node = from_parameters(parameters), node_options(parameters)
            with_text = replace(
                configuration.joints, description=self.pipeline.configuration.joints.description
            )
            configuration = described(replace(configuration, joints=with_text))
        except (ValueError, TypeError, AttributeError, RecursionError) as error:
            return Answer(False, f"cannot set {shown(text)}: {error}")
        self._parameters = parameters
        self._tries.depth_stated = configuration.monitor.inserted_depth > 0.0
        self.pipeline.retune(configuration, orientation_of(configuration))
        self._possible(lambda look: look.take(configuration), None)
        self._outputs.set_markers_rate(node.markers_rate)
        return Answer(
            True, "set " + ", ".join(f"{name} = {value}" for name, value in changed.items())
        )


def _pose(t_ns, numbers, frame):
    layout = LAYOUTS["pose"]
    return layout.message(t_ns, numbers[layout.at], frame)


def _cycle_messages(records):
    return [("cycle", STRING, {"data": json_line(record)}) for record in records]


def message_stream(
    configuration: Configuration,
    markers_rate: float = 10.0,
    make: Make = make_filter,
    offline: bool = False,
) -> MessageStream:
    """
    Return a new stream, with the robot's kinematics where the configuration names a URDF.

    `make` makes the filter, and `offline` is whether a delay is looked for, see `Pipeline`.

    Raises
    ------
    PegOnHoleError
        A URDF that cannot be used.

    """
    configuration = described(configuration)
    pipeline = Pipeline(configuration, orientation_of(configuration), make, offline)
    return MessageStream(configuration, pipeline, markers_rate)


def orientation_of(configuration: Configuration) -> JointOrientation:
    """
    Return what makes an AngleMeasurement of a joint state, or the reason why there is none.

    Raises
    ------
    PegOnHoleError
        A URDF that cannot be used.

    """
    joints = configuration.joints
    if awaited(joints):
        return UndescribedRobot(joints.names)
    if joints.source == "robot":
        from peg_on_hole_ros.robot.kinematics import orientation_source  # pinocchio is an extra

        return orientation_source(at_edges(joints, configuration.scene))
    return PegJoints(joints)
