"""From samples, as they arrive, to outputs: the one path that the node and the replay share."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator

import numpy as np

from peg_on_hole_ros.config.options import Configuration, JointInput
from peg_on_hole_ros.diagnosis.fence import Failures
from peg_on_hole_ros.engine.arrival_order import COUNTED, FATE, arrive
from peg_on_hole_ros.engine.placing import Placing
from peg_on_hole_ros.engine.processor import Processor
from peg_on_hole_ros.engine.requests import Requests
from peg_on_hole_ros.engine.runs import look_again, orientation_at, run_of, take_run
from peg_on_hole_ros.estimator.held_peg import HeldPeg
from peg_on_hole_ros.estimator.methods import make_filter
from peg_on_hole_ros.measurements.measurement import PegJoints, wrench_fault
from peg_on_hole_ros.monitor.outputs import outputs_of
from peg_on_hole_ros.records import (
    Answer,
    Arrivals,
    JointSample,
    Outputs,
    Rows,
    WrenchSample,
)

# Messages that are looked at together; runs of fewer wrenches are taken one by one, as a call for
# many, and to keep states where some are late, costs as much as so many of them do.
MOST, FEWEST, FEWEST_LATE = 4096, 8, 32


class Pipeline:
    """
    Samples in, outputs out; time is that of the stamps, and nothing else is read.

    Joint states wait until the wrench of their stamp is there, so that every prediction runs
    under a wrench that was measured at its end. A late message is put in its place, and all since
    is processed again when the next wrench comes; what was given out before stays as it is. One
    stamp alone is no clock: one far back is late, a wrench far ahead of the next is taken back.

    Parameters
    ----------
    configuration : Configuration
    orientation : callable or None
        From a JointSample to an AngleMeasurement, or to the reason why there is none; None reads
        the peg's own joints.
    make : callable
        From scene, filter options, the wrench's covariance and what is not known of bias and tilt
        to the filter, as `make_filter`.
    offline : bool
        Whether there is time to look for a delay, see `Findings`: the estimate is the same.

    Attributes
    ----------
    orientation : callable

    """

    def __init__(
        self,
        configuration: Configuration,
        orientation: Callable | None = None,
        make: Callable[..., HeldPeg] = make_filter,
        offline: bool = False,
    ) -> None:
        self.scene = configuration.scene
        self.orientation: Callable = orientation or PegJoints(configuration.joints)
        self._delay_ns = round(configuration.joints.delay * 1e9)
        self._arrival_counts: Counter[str] = Counter()
        self._placing = Placing(configuration, make, self._arrival_counts, offline)
        self._requests = Requests(self._placing, self._arrival_counts)
        # One message, and what becomes of it; how many are not worth looking at together.
        self._one = np.zeros(1, bool), np.zeros(1, np.int64), np.ones(1, bool)
        self._fates = np.zeros(MOST, np.int64)
        self._one_by_one = 0

    @property
    def configuration(self) -> Configuration:
        """The settings that are used now."""
        return self._placing.configuration

    @property
    def processor(self) -> Processor:
        """What holds the estimate, and processes what has been put in order."""
        return self._placing.processor

    @processor.setter
    def processor(self, processor: Processor) -> None:
        self._placing.processor = processor

    @property
    def counts(self) -> Counter[str]:
        """Every message by what became of it, and what else happened."""
        return self._arrival_counts + self.processor.counts

    @property
    def health(self) -> dict[str, float]:
        """State of the filter after the last wrench, for diagnostics."""
        return self.processor.health

    @property
    def model(self) -> str:
        """Which model of the contact is in use, and why, and what is left out, as one line."""
        return self.processor.model

    @property
    def causes(self) -> list[str]:
        """Settings that the data have contradicted, a line each, the likeliest first."""
        return [*self._placing.findings.causes, *self.processor.causes]

    @property
    def failures(self) -> Failures:
        """The side looks that failed in this run, with their errors."""
        return self._placing.findings.failures

    @property
    def void_reactions(self) -> bool:
        """Whether reactions rest on what the data have contradicted, with nothing in its place."""
        return self._placing.findings.void_reactions

    @property
    def filter(self) -> HeldPeg:
        """The filter, for those who made it."""
        return self.processor.filter

    def reset(self) -> Answer:
        """Restart filter and monitor, forget what was learnt; the tare stays."""
        return self._requests.reset()

    def tare(self) -> Answer:
        """Take the mean of the last wrenches as that of a free-hanging peg, if there are any."""
        return self._requests.tare()

    def refuse_tare(self, reason: str) -> Answer:
        """Take no tare, and count that; stamps do not tell how long ago the last wrench came."""
        return self._requests.refuse_tare(reason)

    def expect(self, what: str) -> Answer:
        """Take what the robot's program announces, `lift_off`, `insertion` or `nothing`."""
        return self._requests.expect(what)

    def take_pose(self) -> Answer:
        """Take the present pose as that of a free and still peg; say what all such poses tell."""
        return self._requests.take_pose()

    def describe(self, joints: JointInput, orientation: Callable) -> None:
        """Take what the robot's description makes known, before which no joint state is used."""
        self._placing.describe(joints)
        self.orientation = orientation

    def mount(self, xyz: tuple[float, float, float], rpy: tuple[float, float, float]) -> None:
        """Take another pose of the sensor, before the first wrench [m], [rad]."""
        self._placing.findings.mount(xyz, rpy)
        self._placing.rebuild()

    def retune(self, configuration: Configuration, orientation: Callable | None = None) -> None:
        """
        Take other settings from here on, of those that a node takes while it is active.

        Parameters
        ----------
        configuration : Configuration
            Differs from the present one in such (`Parameter.live`) alone.
        orientation : callable, optional
            As for the class.

        """
        self._placing.retune(configuration)
        self.orientation = orientation or PegJoints(configuration.joints)
        self._arrival_counts["settings_changed"] += 1

    def on_sample(self, sample: WrenchSample | JointSample) -> Outputs | None:
        """Take a sample of either kind, see `on_wrench` and `on_joints`."""
        if isinstance(sample, WrenchSample):
            return self.on_wrench(sample)
        self.on_joints(sample)
        return None

    def play(self, samples: Iterable[WrenchSample | JointSample]) -> Iterator[Outputs]:
        """Yield what samples give, taken in the order in which they come."""
        for sample in samples:
            outputs = self.on_sample(sample)
            if outputs is not None:
                yield outputs

    def on_joints(self, sample: JointSample) -> None:
        """Take a joint state; it corrects the estimate, and gives no output of its own."""
        measurement = self.orientation(sample)
        if isinstance(measurement, str):
            self._arrival_counts[f"joints_dropped_{measurement}"] += 1
            return
        if self._delay_ns:
            measurement = measurement._replace(t_ns=measurement.t_ns - self._delay_ns)
        fate = self._arrives(False, measurement.t_ns)
        if fate == FATE.joints_restart:
            self._placing.restart()
            fate = self._arrives(False, measurement.t_ns)
        self._place(fate, measurement)

    def _arrives(self, of_wrench, t_ns):
        """Return what becomes of a message, and count it."""
        self._one[0][0], self._one[1][0] = of_wrench, t_ns
        arrive(self._placing.orders, *self._one, True, self._fates)
        fate = int(self._fates[0])
        self._count(fate, 1)
        return fate

    def _count(self, fate, times):
        if COUNTED[fate]:
            self._arrival_counts[COUNTED[fate]] += times

    def _place(self, fate, measurement):
        """Do what becomes of an orientation."""
        placing = self._placing
        if fate == FATE.starts:
            placing.start(measurement)
        elif fate in (FATE.waits, FATE.waits_before):
            placing.wait(measurement)
        elif fate == FATE.joints_late:
            placing.put_joints(measurement)
        elif fate in (FATE.same, FATE.joints_moved):
            placing.correct(measurement, (placing.now_ns - measurement.t_ns) * 1e-9)

    def on_wrench(self, sample: WrenchSample) -> Outputs | None:
        """Take a wrench; returns the outputs at its stamp, or None if it gives none (counted)."""
        row = self.row_of(sample)
        return None if row is None else self.outputs(sample.t_ns, row)

    def outputs(self, t_ns: int, row: np.ndarray) -> Outputs:
        """Return the outputs of a row; where a motion is expected its alarms are none."""
        return self._requests.judged(outputs_of(t_ns, row))

    @property
    def expecting(self) -> bool:
        """Whether a motion was announced, so that `outputs` may differ from their row."""
        return self._requests.expecting

    def row_of(self, sample: WrenchSample) -> np.ndarray | None:
        """Take a wrench as `on_wrench` does; return its outputs as a row, see `output_row`."""
        fault = wrench_fault(sample)
        if fault:
            self._arrival_counts[f"wrench_dropped_{fault}"] += 1
            return None
        placing = self._placing
        now_ns, fate = placing.now_ns, self._arrives(True, sample.t_ns)
        if fate == FATE.takes_back:
            placing.take_back()
            now_ns, fate = placing.now_ns, self._arrives(True, sample.t_ns)
        if fate == FATE.wrench_restarts:
            placing.restart()
            self._count(FATE.wrench_too_late, 1)
        elif fate == FATE.wrench_late:
            placing.history.put_wrench(sample)
        if fate not in (FATE.taken, FATE.leaps):
            return None
        row = placing.take_wrench(sample, now_ns, fate == FATE.leaps)
        self._requests.tare_if_free()
        return row

    def take(self, arrivals: Arrivals, begin: int) -> tuple[int, Rows | None]:
        """
        Take messages from a place on for as long as they can be taken many at once.

        It gives bit for bit what `on_sample` gives with one after the other, in less time.

        Parameters
        ----------
        arrivals : Arrivals
        begin : int
            Place of the first.

        Returns
        -------
        end : int
            Place of the first that is not taken. It is to be given to `on_sample`; where there is
            none, all have been taken.
        rows : Rows or None
            What they give.

        """
        end, given = begin, []
        # What is looked at after each wrench is taken wrench by wrench.
        together = self.processor.in_one_piece and not self._requests.watching
        while together and end < len(arrivals.t_ns):
            if self._one_by_one or self._placing.history.changed or not self._placing.started:
                self._one_by_one = max(self._one_by_one - 1, 0)
                break
            count, rows = self._take_together(arrivals, end)
            if not count:
                break
            given += rows
            end += count
        return end, Rows(*map(np.concatenate, zip(*given))) if given else None

    def _take_together(self, arrivals, begin):
        """Take messages in one go; return how many, and rows."""
        some = slice(begin, begin + MOST)
        of_wrench, t_ns, sound = (each[some] for each in arrivals[:3])
        ahead = self._placing.ahead()
        count = arrive(ahead, of_wrench, t_ns, sound, False, self._fates)
        fates = self._fates[:count]
        taken = np.flatnonzero(fates == FATE.taken)
        late = bool((fates == FATE.joints_late).any())
        done = None
        if len(taken) >= (FEWEST_LATE if late else FEWEST):
            run = run_of(arrivals, begin, fates[: taken[-1] + 1])
            done = take_run(self._placing, run, late)
        if done is None:
            self._one_by_one = count
            return 0, []
        given, wrenches, other = done
        last = int(taken[wrenches - 1])
        if other:
            count = last + 1
            look_again(self._placing, of_wrench[:count], t_ns[:count], self._fates[:count])
        self._placing.come_to()
        for fate, times in enumerate(np.bincount(self._fates[:count]).tolist()):
            self._count(fate, times)
        for i in range(last + 1, count):
            if not of_wrench[i]:
                self._place(int(self._fates[i]), orientation_at(arrivals, begin + i))
        return count, given
