"""The one path of node and replay, samples in, outputs out: the `Engine` and requests to it."""

from collections import Counter
from collections.abc import Iterable, Iterator

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.diagnosis.guarded_looks import Failures
from peg_on_hole_ros.engine.engine import Engine
from peg_on_hole_ros.engine.processor import Processor
from peg_on_hole_ros.engine.requests import Requests
from peg_on_hole_ros.engine.state import ORIENTATION_WIDTH
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.methods.method import Make
from peg_on_hole_ros.estimator.methods.registry import make_filter
from peg_on_hole_ros.measurements.orientation import JointOrientation, PegJoints, positions_of
from peg_on_hole_ros.measurements.wrench_reduction import wrench_fault
from peg_on_hole_ros.monitor.output_row import ROW
from peg_on_hole_ros.monitor.output_view import OutputView
from peg_on_hole_ros.records import (
    Answer,
    Arrivals,
    JointSample,
    Rows,
    WrenchSample,
)

_NOT, _SOUND = np.zeros(1, bool), np.ones(1, bool)
_NO_WRENCH, _NO_ORIENTATION = np.empty((0, 6)), np.empty((0, ORIENTATION_WIDTH))
_NO_JOINTS = np.empty((0, 0))
_NO_ROWS = Rows(np.empty(0, np.int64), np.empty(0, ROW))


class Pipeline:
    """
    Samples in, outputs out; time is that of the stamps, and nothing else is read.

    See `Engine` for what becomes of messages that come late or out of order.

    Parameters
    ----------
    configuration : Configuration
    orientation : JointOrientation or None
        From a JointSample to an AngleMeasurement, or to the reason why there is none; None reads
        the peg's own joints.
    make : callable
        From scene, filter options, the wrench's covariance and what is not known of bias and tilt
        to the filter, as `make_filter`.
    offline : bool
        Whether there is time to look for a delay; the estimate is the same.

    Attributes
    ----------
    orientation : JointOrientation

    """

    def __init__(
        self,
        configuration: Configuration,
        orientation: JointOrientation | None = None,
        make: Make = make_filter,
        offline: bool = False,
    ) -> None:
        self.scene = configuration.scene
        self.orientation: JointOrientation = orientation or PegJoints(configuration.joints)
        self._delay_ns = round(configuration.joints.delay * 1e9)
        self._arrival_counts: Counter[str] = Counter()
        self._engine = Engine(configuration, make, self._arrival_counts, offline)
        self._requests = Requests(self._engine, self._arrival_counts)

    @property
    def configuration(self) -> Configuration:
        """The settings that are used now."""
        return self._engine.configuration

    @property
    def processor(self) -> Processor:
        """What holds the estimate, and processes what has been put in order."""
        return self._engine.processor

    @property
    def counts(self) -> Counter[str]:
        """Every message by what became of it, and what else happened."""
        return self._arrival_counts + self._engine.counts + self.processor.counts

    @property
    def kept(self) -> tuple[int, int]:
        """How many wrenches, and how many states before them, are kept for late messages."""
        return self._engine.kept

    @property
    def health(self) -> dict[str, float]:
        """State of the filter after the last wrench, for diagnostics."""
        return self.processor.health

    @property
    def left_out(self) -> str:
        """What the model in use leaves out, as one line; empty: nothing."""
        return self.processor.left_out

    @property
    def causes(self) -> list[str]:
        """Settings that the data contradict, likeliest first, then what is wrong with values."""
        found = self._engine.settings_against_data
        return [*found.causes, *self.processor.causes(self.joints_explained)]

    @property
    def joints_explained(self) -> bool:
        """Whether the causes say what is odd about the values of joint states."""
        return self._engine.settings_against_data.explains_joints

    @property
    def contradicted(self) -> list[str]:
        """Settings that the data contradict, likeliest first: some of the causes."""
        return self._engine.settings_against_data.causes

    @property
    def causes_of_stamps(self) -> list[str]:
        """What the stamps alone show of the clocks, a line each; `causes` has them as well."""
        return self._engine.settings_against_data.causes_of_stamps

    @property
    def failures(self) -> Failures:
        """The side looks that failed in this run, with their errors."""
        return self._engine.settings_against_data.failures

    @property
    def reactions_are_void(self) -> bool:
        """Whether reactions rest on what the data have contradicted, with nothing in its place."""
        return self._engine.settings_against_data.reactions_are_void

    @property
    def filter(self) -> ContactFilter:
        """The filter, for those who made it."""
        return self.processor.filter

    def reset(self) -> Answer:
        """Restart filter and monitor, forget what was learnt; the tare stays."""
        return self._requests.reset()

    def tare(self) -> Answer:
        """Take the mean of the last wrenches as that of a free-hanging peg, if there are any."""
        return self._requests.tare()

    def refuse_tare(self, reason: str) -> Answer:
        """Refuse a tare, and count that; stamps do not show how long ago the last wrench came."""
        return self._requests.refuse_tare(reason)

    def expect(self, what: str) -> Answer:
        """Process what the robot's program announces, `lift_off`, `insertion` or `nothing`."""
        return self._requests.expect(what)

    def take_pose(self) -> Answer:
        """Use the present pose as that of a free and still peg; return what all such show."""
        return self._requests.take_pose()

    def use_robot_description(
        self, configuration: Configuration, orientation: JointOrientation
    ) -> None:
        """Use what the robot's description makes known, before which no message is used."""
        self.scene = configuration.scene
        self._engine.use_robot_description(configuration)
        self._requests.forget()
        self.orientation = orientation

    def set_sensor_pose(
        self, xyz: tuple[float, float, float], rpy: tuple[float, float, float]
    ) -> None:
        """Use another pose of the sensor, before the first wrench [m], [rad]."""
        self._engine.set_sensor_pose(xyz, rpy)

    def retune(
        self, configuration: Configuration, orientation: JointOrientation | None = None
    ) -> None:
        """
        Use other settings from here on, of those that may change while a node is active.

        Parameters
        ----------
        configuration : Configuration
            Differs from the present one in such (`Parameter.live`) alone.
        orientation : JointOrientation, optional
            As for the class.

        """
        self._engine.retune(configuration)
        self.orientation = orientation or PegJoints(configuration.joints)
        self._arrival_counts["settings_changed"] += 1

    def on_sample(self, sample: WrenchSample | JointSample) -> OutputView | None:
        """Process a sample of either kind, see `on_wrench` and `on_joints`."""
        if isinstance(sample, WrenchSample):
            return self.on_wrench(sample)
        self.on_joints(sample)
        return None

    def play(self, samples: Iterable[WrenchSample | JointSample]) -> Iterator[OutputView]:
        """Yield what samples give, taken in the order in which they come."""
        for sample in samples:
            outputs = self.on_sample(sample)
            if outputs is not None:
                yield outputs

    def on_joints(self, sample: JointSample) -> None:
        """Process a joint state; it corrects the estimate, and gives no output of its own."""
        measurement = self.orientation(sample)
        if isinstance(measurement, str):
            self._arrival_counts[f"joints_dropped_{measurement}"] += 1
            return
        t_ns = np.array([measurement.t_ns - self._delay_ns], np.int64)
        read = positions_of(
            self.configuration.joints.names, sample.names, np.array([sample.position], float)
        )
        one = Arrivals(_NOT, t_ns, _SOUND, _NO_WRENCH, measurement.row.reshape(1, -1), read)
        # One that shows that the clock has jumped is taken once more, to begin with.
        while not self.push(one)[0]:
            pass

    def on_wrench(self, sample: WrenchSample) -> OutputView | None:
        """Process a wrench; return the outputs at its stamp, None if it gives none (counted)."""
        rows = self.take_wrench(sample)
        if not len(rows.t_ns):
            return None
        return self.without_announced_alarms(OutputView(sample.t_ns, rows.values[0]))

    def without_announced_alarms(self, outputs: OutputView) -> OutputView:
        """Return outputs in which an announced motion is no alarm."""
        return self._requests.without_announced_alarms(outputs)

    @property
    def expecting(self) -> bool:
        """Whether a motion was announced, so that `without_announced_alarms` may return others."""
        return self._requests.expecting

    def take_wrench(self, sample: WrenchSample) -> Rows:
        """Process a wrench; return the row at its stamp, or none if it gives none (counted)."""
        fault = wrench_fault(sample)
        if fault:
            self._arrival_counts[f"wrench_dropped_{fault}"] += 1
            return _NO_ROWS
        wrench = np.array([[*sample.force, *sample.torque]], float)
        t_ns = np.array([sample.t_ns], np.int64)
        one = Arrivals(_SOUND, t_ns, _SOUND, wrench, _NO_ORIENTATION, _NO_JOINTS)
        return self.push(one)[1]

    def push(self, arrivals: Arrivals, begin: int = 0) -> tuple[int, Rows]:
        """
        Process messages in the order in which they arrived, one or thousands.

        Parameters
        ----------
        arrivals : Arrivals
        begin : int
            Place of the first.

        Returns
        -------
        end : int
            Place of the first that is not taken, which may be one that is not sound; what is
            given has stamps that rise.
        rows : Rows
            What they give.

        """
        if not self._requests.watching:
            return self._engine.push(arrivals, begin)
        # What is looked at after each wrench is taken wrench by wrench.
        end, given = self._engine.push(arrivals, begin, 1)
        if self._engine.taken:
            self._requests.tare_if_free()
        return end, given
