"""From samples, as they arrive, to outputs: the one path that the node and the replay share."""

from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration, JointInput
from peg_on_hole_ros.diagnosis.diagnosis import Diagnosis
from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.free_air import FreeAir
from peg_on_hole_ros.diagnosis.low_pass import LowPass
from peg_on_hole_ros.diagnosis.rim_motion import RimMotion
from peg_on_hole_ros.diagnosis.untold import KINDS, Untold
from peg_on_hole_ros.engine.announced_motion import Expected
from peg_on_hole_ros.engine.free_peg import FreeFor, not_free, turns
from peg_on_hole_ros.engine.history import History, Unit
from peg_on_hole_ros.engine.in_order import count_in_order
from peg_on_hole_ros.engine.kept import Kept
from peg_on_hole_ros.engine.late_orientations import MOST_BACK, stretch_of
from peg_on_hole_ros.engine.processing import Processor
from peg_on_hole_ros.engine.recent_stamps import RecentStamps
from peg_on_hole_ros.engine.still_poses import StillPoses
from peg_on_hole_ros.estimator.held_peg import HeldPeg
from peg_on_hole_ros.estimator.methods import make_filter
from peg_on_hole_ros.measurements.measurement import PegJoints, wrench_fault
from peg_on_hole_ros.monitor.memory import IN_AIR, THREE_POINT
from peg_on_hole_ros.monitor.output_row import AT, FLAG, MODE
from peg_on_hole_ros.monitor.outputs import outputs_of
from peg_on_hole_ros.monitor.while_in_doubt import doubt
from peg_on_hole_ros.records import (
    AngleMeasurement,
    Answer,
    Arrivals,
    JointSample,
    Outputs,
    Rows,
    WrenchSample,
)

# Joint states that wait for the wrench of their time; at 8 kHz these are 60 ms.
MAX_WAITING = 512
# A stamp this far behind is a clock that was set back or a bag played again, not a late message.
CLOCK_JUMP_NS = 1_000_000_000
# A tare takes so many wrenches at most, and none that is older: the peg may have touched before.
TARE_SAMPLES = 100
TARE_NS = 500_000_000
# Messages that are looked at together: few after one that was out of order, else more and more.
FEWEST, MOST = 32, 4096
# Stamps that fall by more begin another window of the diagnosis.
DUE_NS = 100_000_000
# Where a row has what each kind of setting would cost that the motion does not tell.
_DOUBTS = [getattr(AT, f"doubt_{kind.name}") for kind in KINDS]


class _Leap(NamedTuple):
    # A wrench that came after a silence, and the stamp of the one before.
    unit: Unit
    last_wrench_ns: int | None


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

    Attributes
    ----------
    processor : Processor
        What holds the estimate, and processes what has been put in order.
    orientation : callable

    """

    def __init__(
        self,
        configuration: Configuration,
        orientation: Callable | None = None,
        make: Callable[..., HeldPeg] = make_filter,
    ) -> None:
        self.configuration = configuration
        self.scene = configuration.scene
        self.orientation = orientation or PegJoints(configuration.joints)
        self._make = make
        self.processor = Processor(configuration, make)
        self._look(self.processor.reduction.taken_off)
        self._low_pass = LowPass(configuration.wrench)
        # What is used in place of what is stated, and the latest orientation.
        self._adopted: dict[str, object] = {}
        self._mounted: dict[str, object] = {}
        self._found: list[Finding] = []
        self._measured: AngleMeasurement | None = None
        self._flag = False
        self._together = FEWEST
        # Messages that are taken one by one before more are tried again, where order is poor.
        self._one_by_one, self._patience = 0, 1
        # Where states are kept to go back to, once orientations have been late.
        self._room: Kept | None = None
        # Fates that arrival decides; those that going back decides anew are the processor's.
        self._arrival_counts: Counter[str] = Counter()
        self._delay_ns = round(configuration.joints.delay * 1e9)
        window_ns = round(configuration.filter.late_window * 1e9)
        self._expected_ns = max(self._delay_ns, 0)
        self._history = History(window_ns and window_ns + self._expected_ns)
        tolerance_ns = round(configuration.filter.late_tolerance * 1e9)
        self._joint_stamps = RecentStamps(max(window_ns, tolerance_ns) + self._expected_ns)
        self._recent: deque[WrenchSample] = deque(maxlen=TARE_SAMPLES)
        self._waiting: deque[AngleMeasurement] = deque()
        self._expected, self._poses = Expected(), StillPoses(configuration)
        self._free = FreeFor(configuration)
        self._restart()

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
        told = [
            f"{finding.of}: {finding.text}; used in place of what is stated (wrench.adopt_found)"
            if self._adopted.items() >= finding.found.items() and finding.found
            else f"{finding.of}: {finding.text}"
            # What a wrench means rests on how hole and peg are stated.
            for finding in sorted(self._found, key=lambda each: each.of == "wrench")
        ]
        return [*told, *self.processor.causes]

    @property
    def filter(self) -> HeldPeg:
        """The filter, for those who made it."""
        return self.processor.filter

    def _restart(self):
        self.processor.restart()
        self._last_wrench_ns: int | None = None
        self._leap: _Leap | None = None
        # Stamp of the last message of a kind, where it was far behind.
        self._far_behind: dict[str, int] = {}
        # What was put in its place since the last wrench waits for the next one, as what is ahead.
        self._arrival_counts["wrench_dropped_restart"] += self._history.wrenches
        self._arrival_counts["joints_dropped_restart"] += self._history.joints + len(self._waiting)
        self._history.clear()
        # Stamp and row of the latest outputs; the newest stamp of an orientation.
        self._told: tuple[int, np.ndarray] | None = None
        self._newest_ns: int | None = None
        self._waiting.clear()
        self._joint_stamps.clear()
        self._recent.clear()
        self._diagnosis.restart()
        self._air.restart()
        self._rim.restart()
        self._untold.restart()
        self._measured = None

    def reset(self) -> Answer:
        """Restart filter and monitor, forget what was learnt; the tare stays."""
        last = self._last_wrench_ns
        self._restart()
        # No stamp is told of twice.
        self._last_wrench_ns = last
        self.processor.forget()
        self._expected, self._poses = Expected(), StillPoses(self.configuration)
        self._arrival_counts["reset"] += 1
        return Answer(
            True,
            "filter and monitor restarted, with friction and clearance as stated, and the tare as "
            "it was taken; they wait for a joint state"
            if self._arrival_counts["tare"]
            else "filter and monitor restarted, with friction and clearance as stated; they wait "
            "for a joint state",
        )

    def tare(self) -> Answer:
        """Take the mean of the last wrenches as that of a free-hanging peg, if there are any."""
        if not self._recent or not self.processor.oriented:
            return self.refuse_tare("no wrench and orientation have arrived yet")
        held = not_free(self._latest_outputs, self.configuration)
        if held and not self.configuration.wrench.tare_in_contact:
            return self.refuse_tare(
                f"{held}; call again once it hangs free and still (wrench.tare_in_contact takes "
                "it all the same)"
            )
        # Wrenches before a tare cannot be processed again after it.
        self._catch_up()
        self._history.clear()
        self._leap = None
        samples = self._latest()
        taken = self.processor.tare(samples)
        self._found = [finding for finding in self._found if finding is not self._air.finding]
        self._look(taken)
        self._arrival_counts["tare"] += 1
        numbers = ", ".join(f"{value:.6g}" for value in taken)
        seconds = (samples[-1].t_ns - samples[0].t_ns) * 1e-9
        return Answer(
            True,
            f"tare over {len(samples)} samples of {seconds:.3g} s, sensor axes "
            f"[Fx, Fy, Fz N, Mx, My, Mz N m]: {numbers}",
        )

    def expect(self, what: str) -> Answer:
        """Take what the robot's program announces, `lift_off`, `insertion` or `nothing`."""
        self._expected.announce(what)
        self._arrival_counts["expected"] += 1
        return Answer(True, f"expected: {what}")

    def take_pose(self) -> Answer:
        """Take the present pose as that of a free and still peg; say what all such poses tell."""
        refused = self._poses.refused
        if not refused and (not self._recent or not self.processor.oriented):
            refused = "no wrench and orientation have arrived yet"
        if not refused and self._told is not None:
            # Whether it touches cannot be told before the payload is known.
            refused = turns(self._latest_outputs, self.configuration)
        if refused:
            return Answer(False, f"no pose taken: {refused}")
        samples = self._latest()
        mean = np.mean([[*sample.force, *sample.torque] for sample in samples], axis=0)
        gravity_S = self.processor.gravity_in_sensor
        return Answer(True, self._poses.take(gravity_S, mean, len(samples)))

    def _latest(self):
        """Return the wrenches of the last moment."""
        now_ns = self._recent[-1].t_ns
        return [each for each in self._recent if now_ns - each.t_ns <= TARE_NS]

    def refuse_tare(self, reason: str) -> Answer:
        """Take no tare, and count that; stamps do not tell how long ago the last wrench came."""
        self._arrival_counts["tare_refused"] += 1
        return Answer(False, f"nothing taken: {reason}")

    def describe(self, joints: JointInput, orientation: Callable) -> None:
        """Take what the robot's description makes known, before which no joint state is used."""
        self.configuration = replace(self.configuration, joints=joints)
        self.orientation = orientation

    def mount(self, xyz: tuple[float, float, float], rpy: tuple[float, float, float]) -> None:
        """Take another pose of the sensor, before the first wrench [m], [rad]."""
        self._mounted = {"sensor_xyz": xyz, "sensor_rpy": rpy}
        self._rebuild()

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
        # Wrenches before it cannot be processed again after it.
        self._catch_up()
        self._history.clear()
        self._leap = None
        configuration = self._as_found(configuration)
        self.configuration = configuration
        self.orientation = orientation or PegJoints(configuration.joints)
        self.processor.retune(configuration)
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
        now_ns = self.processor.t_ns
        if now_ns is None:
            self.processor.start(measurement)
            self._measured = measurement
            self._newest_ns = measurement.t_ns
            self._joint_stamps.take(measurement.t_ns, measurement.t_ns)
            return
        far = now_ns - measurement.t_ns - self._expected_ns > CLOCK_JUMP_NS
        if self._clock_went_back("joints", measurement.t_ns, far):
            self._restart()
            self.on_joints(sample)
            return
        if far:
            self._arrival_counts["joints_dropped_late"] += 1
            return
        if not self._joint_stamps.take(measurement.t_ns, now_ns):
            self._arrival_counts["joints_dropped_repeated_stamp"] += 1
            return
        self._newest_ns = max(self._newest_ns, measurement.t_ns)
        if measurement.t_ns > now_ns:
            if self._waiting and measurement.t_ns < self._waiting[-1].t_ns:
                self._arrival_counts["joints_reordered"] += 1
                self._waiting = deque(
                    sorted([*self._waiting, measurement], key=lambda waiting: waiting.t_ns)
                )
            else:
                self._waiting.append(measurement)
            if len(self._waiting) > MAX_WAITING:
                self._waiting.popleft()
                self._arrival_counts["joints_dropped_without_wrench"] += 1
            return
        self._take_late_joints(measurement, now_ns)

    def _take_late_joints(self, measurement: AngleMeasurement, now_ns: int):
        lateness = now_ns - measurement.t_ns
        if self._measured is None or measurement.t_ns > self._measured.t_ns:
            self._measured = measurement
        if not lateness:
            self._history.add_after(measurement)
            if not self._history.changed:
                self.processor.correct(measurement)
        elif self._history.put_joints(measurement, now_ns):
            self._arrival_counts["joints_late"] += 1
        elif (
            self._history.window_ns
            or lateness - self._expected_ns > self.configuration.filter.late_tolerance * 1e9
        ):
            self._arrival_counts["joints_dropped_late"] += 1
        else:
            self._arrival_counts["joints_late"] += 1
            self.processor.correct(measurement, lateness * 1e-9)

    def on_wrench(self, sample: WrenchSample) -> Outputs | None:
        """Take a wrench; returns the outputs at its stamp, or None if it gives none (counted)."""
        row = self._row(sample)
        return None if row is None else self._expected.judged(outputs_of(sample.t_ns, row))

    def _row(self, sample):
        """Return the row of a wrench, see `on_wrench`."""
        fault = wrench_fault(sample)
        if fault:
            self._arrival_counts[f"wrench_dropped_{fault}"] += 1
            return None
        now_ns = self.processor.t_ns
        if now_ns is None:
            self._arrival_counts["wrench_dropped_before_joints"] += 1
            return None
        if sample.t_ns == self._last_wrench_ns:
            self._arrival_counts["wrench_dropped_repeated_stamp"] += 1
            return None
        if sample.t_ns < now_ns and self._take_back(sample.t_ns):
            return self._row(sample)
        far = now_ns - sample.t_ns > CLOCK_JUMP_NS
        if self._clock_went_back("wrench", sample.t_ns, far):
            self._restart()
        if far:
            self._arrival_counts["wrench_dropped_late"] += 1
            return None
        if sample.t_ns < now_ns:
            self._take_late_wrench(sample, now_ns)
            return None
        self._recent.append(sample)
        self._low_pass.take(sample)
        last_ns, self._last_wrench_ns = self._last_wrench_ns, sample.t_ns
        self._catch_up()
        joints = []
        while self._waiting and self._waiting[0].t_ns <= sample.t_ns:
            joints.append(self._waiting.popleft())
        if joints:
            self._measured = joints[-1]
        if self._due(sample.t_ns):
            self._diagnose(sample)
        leaps = 0 < self._history.window_ns < sample.t_ns - now_ns
        wanted = leaps or self._history.wants_snapshot
        unit = Unit(sample, joints, self.processor.snapshot() if wanted else None, now_ns)
        self._leap = _Leap(unit, last_ns) if leaps else None
        self._history.append(unit)
        row = self.processor.process(unit)
        if row is None:
            self._told = None
        else:
            self._tell(Rows(np.array([sample.t_ns]), row.reshape(1, -1)))
        if (
            self._free.asked
            and self._free.long(self._latest_outputs)
            and not self._diagnosis.unsure
        ):
            self._arrival_counts["tare_automatic"] += self.tare().success
        return row

    @property
    def _latest_outputs(self):
        return None if self._told is None else outputs_of(*self._told)

    def _tell(self, rows):
        """Take note of rows that are told, of which nothing sure may be left."""
        if self._diagnosis.unsure:
            self._arrival_counts["contact_doubted"] += len(rows.t_ns)
            doubt(rows.values, self._flag)
        self._untold.count(len(rows.t_ns))
        rests = rows.values[:, MODE, None] == THREE_POINT
        rows.values[:, _DOUBTS] = np.where(rests, self._untold.costs, np.nan)
        self._told = int(rows.t_ns[-1]), rows.values[-1]
        self._flag = bool(rows.values[-1, FLAG])

    def take(self, arrivals: Arrivals, begin: int) -> tuple[int, Rows | None]:
        """
        Take messages from a place on for as long as they come in order.

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
        if self._one_by_one:
            self._one_by_one -= 1
            return begin, None
        end, given = begin, []
        # What is looked at after each wrench is taken wrench by wrench.
        watched = self._expected.what or self._free.asked
        started = self.processor.t_ns is not None
        easy = started and self.processor.in_one_piece and not watched
        while easy and end < len(arrivals.t_ns) and not self._history.changed:
            most = min(self._together, len(arrivals.t_ns) - end)
            count = self._count_in_order(arrivals, end, most)
            if count and not arrivals.of_wrench[end + count - 1]:
                count = self._without_same(arrivals, end, count)
            rows = self._take_in_order(arrivals, end, end + count)
            late = 0
            if count < most and self._history.window_ns:
                late, more = self._take_late(arrivals, end + count, most - count)
                rows += more
                # To look ahead costs more than few messages in one go save.
                few = count + late < min(FEWEST, most)
                self._patience = min(2 * self._patience, MOST) if few else 1
                self._one_by_one = self._patience if few else 0
            given += rows
            end += count + late
            if count + late < most:
                self._together = FEWEST
                if not late or self._one_by_one:
                    break
            else:
                self._together = min(2 * self._together, MOST)
        if not given:
            return end, None
        return end, Rows(*map(np.concatenate, zip(*given)))

    def _without_same(self, arrivals, begin, count):
        """Leave out an orientation of the last wrench's own stamp, which corrects at once."""
        some = slice(begin, begin + count)
        at, t_ns = np.flatnonzero(arrivals.of_wrench[some]), arrivals.t_ns[some]
        first = int(at[-1]) + 1 if len(at) else 0
        stamp = t_ns[first - 1] if first else self.processor.t_ns
        return first if t_ns[first] == stamp else count

    def _count_in_order(self, arrivals, begin, most, **reach):
        return count_in_order(
            arrivals,
            slice(begin, begin + most),
            self.processor.t_ns,
            self._newest_ns,
            len(self._waiting),
            MAX_WAITING,
            self._in_order_ns,
            **reach,
        )

    @property
    def _in_order_ns(self):
        """A wrench that comes so long behind the one before may have a wrong stamp [ns]."""
        gap_ns = round(self.configuration.filter.max_gap * 1e9)
        return min(gap_ns, self._history.window_ns or gap_ns)

    def _take_in_order(self, arrivals, begin, end):
        """Take messages that come in order; return the rows of each run."""
        if begin == end:
            return []
        now_ns = self.processor.t_ns
        stretch = stretch_of([], self._waiting, arrivals, begin, end)
        given, taken, _ = self._process_runs(stretch, None)
        self._note(arrivals, begin, end, now_ns)
        self._waiting = stretch.measurements(taken, len(stretch.stamps))
        return given

    def _take_late(self, arrivals, begin, most):
        """Take messages of which orientations may be late; return how many, and their rows."""
        now_ns, history = self.processor.t_ns, self._history
        oldest_ns = now_ns if history.begin_ns is None else history.begin_ns
        count = self._count_in_order(arrivals, begin, most, reach=(history.window_ns, oldest_ns))
        at = np.flatnonzero(arrivals.of_wrench[begin : begin + count])
        if not len(at):
            return 0, []
        # What is late behind the last wrench waits for the next one, which is not there.
        end = begin + int(at[-1]) + 1
        units = history.last_units(now_ns)
        stretch = stretch_of(units, self._waiting, arrivals, begin, end)
        places = 1 + max(stretch.back, stretch.since(int(stretch.t_ns[-1]) - history.window_ns))
        if places > MOST_BACK:
            return 0, []
        if self._room is None or len(self._room.beside) < places:
            self._room = self.processor.room(places)
        begin_ns = units[0].begin_ns if units else now_ns
        if units:
            self.processor.fill(self._room, stretch, units[0].before)
        given, taken, wrenches = self._process_runs(stretch, self._room)
        if wrenches == len(stretch.t_ns):
            first = max(0, wrenches - len(self._room.beside))
            before = self.processor.snapshot_of(self._room, first % len(self._room.beside))
            history.hold(stretch.run(first, wrenches, taken, before, begin_ns))
        else:
            # Another setting is used from a wrench on, and what came before counts no more.
            end = begin + int(at[wrenches - stretch.begin - 1]) + 1
        self._note(arrivals, begin, end, now_ns)
        self._waiting = stretch.measurements(taken, stretch.ends[wrenches - 1])
        return end - begin, given

    def _note(self, arrivals, begin, end, now_ns):
        """Take note of messages that have been taken, from where the estimate stood [ns]."""
        of_wrench, t_ns = arrivals.of_wrench[begin:end], arrivals.t_ns[begin:end]
        wrench_ns, joint_ns = t_ns[of_wrench], t_ns[~of_wrench]
        behind = np.cumsum(of_wrench)[~of_wrench]
        stood_ns = np.concatenate([[now_ns], wrench_ns])[behind]
        self._arrival_counts["joints_late"] += int(np.count_nonzero(joint_ns < stood_ns))
        if len(joint_ns):
            self._far_behind.pop("joints", None)
            self._newest_ns = int(joint_ns[-1])
            self._joint_stamps.extend(joint_ns, int(stood_ns[-1]))
        if len(wrench_ns):
            self._far_behind.pop("wrench", None)
            self._leap = None
            self._last_wrench_ns = int(wrench_ns[-1])
            last = int(np.count_nonzero(arrivals.of_wrench[:end]))
            wrenches = arrivals.wrenches[last - len(wrench_ns) : last]
            newest = slice(-TARE_SAMPLES, None)
            self._recent.extend(map(WrenchSample.of_row, wrench_ns[newest], wrenches[newest]))

    def _process_runs(self, stretch, kept):
        """
        Process wrenches up to each that the diagnosis wants.

        Returns
        -------
        given : list of Rows
            What each run gives.
        taken : int
            How many orientations of the stretch have been taken.
        wrenches : int
            How many of its wrenches; not all where another setting is used from one on.

        """
        s, given, first, taken = stretch, [], stretch.begin, stretch.taken
        while first < len(s.t_ns):
            processor, begin_ns = self.processor, self.processor.t_ns
            sample = WrenchSample.of_row(s.t_ns[first], s.wrenches[first])
            self._low_pass.take(sample)
            due = self._due(sample.t_ns)
            if due and kept is not None and first:
                self._note_back(processor.go_on(s, first, first, taken, kept)[1])
                taken = max(taken, s.had(first, first - 1))
            self._note_newest(s, s.had(first, first))
            if due:
                self._diagnose(sample)
            other = self.processor is not processor and kept is not None
            last = first + 1
            if not other:
                last = max(last, int(np.searchsorted(s.t_ns, self._diagnosis.due_ns)))
            self._low_pass.take_all(s.t_ns[first + 1 : last], s.wrenches[first + 1 : last])
            in_order = kept is None or other
            before = None
            if in_order and self._history.window_ns:
                before = self.processor.snapshot()
            rows, went = self.processor.go_on(s, first, last, taken, None if in_order else kept)
            self._note_back(went)
            had = s.had(last - 1, last - 1)
            if in_order:
                self._history.append_run(s.run(first, last, had, before, begin_ns, taken))
            if len(rows.t_ns):
                self._tell(rows)
                given.append(rows)
            if not len(rows.t_ns) or rows.t_ns[-1] != s.t_ns[last - 1]:
                self._told = None
            first, taken = last, had
            if other:
                break
        if first:
            self._note_newest(s, taken)
        return given, taken, first

    def _note_back(self, went):
        self._arrival_counts["went_back"] += int(went[0])
        self._arrival_counts["wrench_reprocessed"] += int(went[1])

    def _note_newest(self, stretch, count):
        """Take note of the newest of so many orientations that have been taken."""
        if count:
            newest = stretch.stamps[count - 1], stretch.orientations[count - 1]
            self._measured = AngleMeasurement.of_row(*newest)

    def _due(self, t_ns):
        """Return whether the diagnosis wants the wrench of a stamp [ns]."""
        due_ns = self._diagnosis.due_ns
        return t_ns >= due_ns or due_ns > t_ns + DUE_NS

    def _look(self, taken_off):
        """Begin to look for wrong settings, with what is taken off a wrench as received."""
        self._diagnosis = Diagnosis(self.configuration, taken_off)
        self._air = FreeAir(self.configuration, self.processor.reduction)
        self._rim = RimMotion(self.configuration)
        self._untold = Untold(self.configuration)

    def _diagnose(self, sample):
        """Try what else the wrench may mean; what is sure takes the place of what is stated."""
        if self._measured is None:
            return
        diagnosis, known = self._diagnosis, self._diagnosis.finding
        diagnosis.take(sample, self._measured)
        if not diagnosis.unsure and not self.processor.wrench_stands_still:
            free = self._told is not None and self._told[1][MODE] == IN_AIR
            self._air.take(sample, self._measured.q, free)
        in_air = self._told is None or self._told[1][MODE] == IN_AIR
        self._rim.take(self._measured, in_air)
        self._look_at_untold(sample.t_ns)
        others = (
            self._air.finding, self._low_pass.finding, self._rim.finding, self._untold.finding,
        )  # fmt: skip
        for finding in (diagnosis.rounded(), diagnosis.finding, *others):
            if finding is None or finding is known or finding in self._found:
                continue
            self._arrival_counts["setting_contradicted"] += 1
            self._found.append(finding)
            # Each once: a wrench that fits the one now and the other then has another fault. Two
            # faults at once are told alone, for more of them fit by chance. And a tare that was
            # taken by the wrong setting has no meaning by the right one.
            alone = len(finding.found) == 1 or finding is not diagnosis.finding
            new = alone and finding.found and not finding.found.keys() & self._adopted.keys()
            if new and self.configuration.wrench.adopt_found and not self._arrival_counts["tare"]:
                self._adopted |= finding.found
                self._arrival_counts["setting_adopted"] += 1
                self._rebuild()
                return

    def _look_at_untold(self, t_ns):
        row = None if self._told is None else self._told[1]
        rests = row is not None and row[MODE] == THREE_POINT
        known = rests and row[AT.reactions_determined] == 1.0
        self._untold.take(t_ns, self.processor.filter if rests else None, known)

    def _as_found(self, configuration):
        wrench = replace(configuration.wrench, **(self._mounted | self._adopted))
        return replace(configuration, wrench=wrench)

    def _rebuild(self):
        """Begin anew from the latest orientation, by other settings of the wrench."""
        self.configuration = self._as_found(self.configuration)
        self._arrival_counts.update(self.processor.counts)
        self.processor, self._room = Processor(self.configuration, self._make), None
        if self._measured is not None:
            self.processor.start(self._measured)
            # It was used before.
            self._arrival_counts["joints_used"] -= 1
        self._look(self.processor.reduction.taken_off)
        # What came before cannot be processed again by another setting.
        self._history.clear()
        self._leap = None

    def _clock_went_back(self, source: str, t_ns: int, far: bool) -> bool:
        """
        Return whether a clock was set back: a second stamp in a row lies far behind, and goes on.

        One alone is a message whose stamp was not set, or of another clock.
        """
        before = self._far_behind.pop(source, None)
        if not far:
            return False
        self._far_behind[source] = t_ns
        if before is None or t_ns <= before:
            return False
        self._arrival_counts["clock_jumped_back"] += 1
        return True

    def _take_back(self, t_ns: int) -> bool:
        """
        Undo a wrench that had leapt ahead, where the next one goes on from before it.

        It is no silence then, but a stamp that was wrong. What was given out of it stays.
        """
        if self._leap is None:
            return False
        unit, last_ns = self._leap
        near = unit.begin_ns < t_ns < (unit.begin_ns + unit.wrench.t_ns) // 2
        if not near or not self._history.ends_with(unit):
            return False
        self.processor.restore(unit.before)
        self._waiting.extendleft(reversed(self._history.take_back()))
        self._recent.pop()
        self._last_wrench_ns, self._leap = last_ns, None
        self._arrival_counts["wrench_dropped_ahead"] += 1
        return True

    def _take_late_wrench(self, sample: WrenchSample, now_ns: int):
        if self._history.has_wrench(sample.t_ns, now_ns):
            self._arrival_counts["wrench_dropped_repeated_stamp"] += 1
        elif self._history.put_wrench(sample, now_ns):
            self._arrival_counts["wrench_late"] += 1
        else:
            self._arrival_counts["wrench_dropped_late"] += 1

    def _catch_up(self):
        """Process again from where the first late message was put; its outputs are not given."""
        changed, units = self._history.take_changed()
        if not units:
            return
        self._arrival_counts["went_back"] += 1
        self._arrival_counts["wrench_reprocessed"] += changed
        processor = self.processor
        processor.restore(units[0][0].before)
        for unit, with_snapshot in units:
            unit.before = processor.snapshot() if with_snapshot else None
            unit.begin_ns = processor.t_ns
            processor.process(unit)
