"""From samples to outputs: the one path that the node and the replay share."""

from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from math import isfinite

import numpy as np

from peg_on_hole_ros.estimation.filters.contact import ContactFilter, Correction, Prediction
from peg_on_hole_ros.estimation.filters.methods import make_filter
from peg_on_hole_ros.estimation.history import History, Unit
from peg_on_hole_ros.estimation.innovations import Innovations
from peg_on_hole_ros.estimation.measurement import PegJoints, WrenchReduction, wrench_fault
from peg_on_hole_ros.estimation.recent_stamps import RecentStamps
from peg_on_hole_ros.monitoring.assessment import Assessment
from peg_on_hole_ros.monitoring.unjudged import Unjudged
from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.records import AngleMeasurement, JointSample, Outputs, WrenchSample

# Joint states that wait for the wrench of their time; at 8 kHz these are 60 ms.
MAX_WAITING = 512
# A stamp this far behind is a clock that was set back or a bag played again, not a late message.
CLOCK_JUMP_NS = 1_000_000_000
TARE_SAMPLES = 100


class Pipeline:
    """
    Samples in, outputs out; time is that of the stamps, and nothing else is read.

    Joint states wait until the wrench of their stamp is there, so that every prediction runs
    under a wrench that was measured at its end. A late message is put in its place, and all since
    is processed again when the next wrench comes; what was given out before stays as it is.

    Parameters
    ----------
    configuration : Configuration
    orientation : callable or None
        From a JointSample to an AngleMeasurement, or to the reason why there is none; None reads
        the peg's own joints.
    make : callable
        From scene, filter options, the wrench's covariance and what is not known of bias and tilt
        to the filter, as `make_filter`.

    """

    def __init__(
        self,
        configuration: Configuration,
        orientation=None,
        make: Callable[..., ContactFilter] = make_filter,
    ):
        self.configuration = configuration
        self.scene = configuration.scene
        self._orientation = orientation or PegJoints(configuration.joints)
        self._reduction = WrenchReduction(configuration.wrench, self.scene)
        self._delay_ns = round(configuration.joints.delay * 1e9)
        self._delay_variance = configuration.joints.delay_stddev**2
        offsets = self._reduction.offsets(configuration)
        self._filter = make(self.scene, configuration.filter, self._reduction.covariance, offsets)
        # Bias and tilt: most cells know them.
        self._offset = self._filter if offsets.variance.any() else None
        self._assessment = self._new_assessment()
        self._innovations = Innovations(white=self._offset is None)
        # Fates that arrival decides, and those that going back decides anew.
        self._arrival_counts: Counter[str] = Counter()
        self._counts: Counter[str] = Counter()
        window_ns = round(configuration.filter.late_window * 1e9)
        self._expected_ns = max(self._delay_ns, 0)
        self._history = History(window_ns and window_ns + self._expected_ns)
        tolerance_ns = round(configuration.filter.late_tolerance * 1e9)
        self._joint_stamps = RecentStamps(max(window_ns, tolerance_ns) + self._expected_ns)
        self._recent: deque[WrenchSample] = deque(maxlen=TARE_SAMPLES)
        self._waiting: deque[AngleMeasurement] = deque()
        self._restart()

    @property
    def counts(self) -> Counter[str]:
        """Every message by what became of it, and what else happened."""
        return self._arrival_counts + self._counts

    @property
    def health(self) -> dict[str, float]:
        """State of the filter after the last wrench, for diagnostics."""
        return {
            "nis_mean": self._innovations.mean if self._innovations.any else 0.0,
            "evaluations": float(self._filter.evaluations),
            "sub_steps": float(self._filter.pieces),
            "steps_refused": float(self._filter.refused + self._filter.inaccurate),
            **self._innovations.told(),
        }

    def _restart(self):
        self._t_ns: int | None = None
        self._oriented_ns: int | None = None
        self._last_wrench_ns: int | None = None
        self._history.clear()
        self._filter.let_go()
        self._started = False
        if self._waiting:
            self._arrival_counts["joints_dropped_restart"] += len(self._waiting)
            self._waiting.clear()
        self._joint_stamps.clear()
        self._in_contact = self._touching = self._blind = False
        self._rung = self._filter.model.rung
        self._recent.clear()
        self._innovations.restart()
        self._assessment.restart()

    def _new_assessment(self):
        options = self.configuration.monitor
        judge = Assessment if options.modes else Unjudged
        return judge(self.scene, options, self._reduction.covariance)

    def reset(self) -> str:
        """Restart filter and monitor, forget what was learnt; the tare stays. Returns as text."""
        last = self._last_wrench_ns
        self._restart()
        # No stamp is told of twice.
        self._last_wrench_ns = last
        self._filter.forget()
        self._assessment = self._new_assessment()
        self._arrival_counts["reset"] += 1
        return (
            "filter and monitor restarted, with friction and clearance as stated; they wait for a "
            "joint state"
        )

    def tare(self) -> str:
        """Take the mean of the last wrenches as that of a free-hanging peg; return it as text."""
        if not self._recent or not self._started:
            return "nothing taken: no wrench and orientation have arrived yet"
        # Wrenches before a tare cannot be processed again after it.
        self._catch_up()
        self._history.clear()
        force = np.mean([sample.force for sample in self._recent], axis=0)
        torque = np.mean([sample.torque for sample in self._recent], axis=0)
        gravity = self._offset.gravity if self._offset else None
        taken = self._reduction.take_tare(force, torque, self._filter.x[:3], gravity)
        if self._offset:
            self._offset.tared(self._reduction.noise / len(self._recent))
        self._arrival_counts["tare"] += 1
        numbers = ", ".join(f"{value:.6g}" for value in taken)
        return (
            f"tare over {len(self._recent)} samples, sensor axes "
            f"[Fx, Fy, Fz N, Mx, My, Mz N m]: {numbers}"
        )

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
        measurement = self._orientation(sample)
        if isinstance(measurement, str):
            self._arrival_counts[f"joints_dropped_{measurement}"] += 1
            return
        if self._delay_ns:
            measurement = measurement._replace(t_ns=measurement.t_ns - self._delay_ns)
        if not self._started:
            self._filter.start(*self._in_hole_axes(measurement))
            self._started = True
            self._t_ns = self._oriented_ns = measurement.t_ns
            self._joint_stamps.take(measurement.t_ns, self._t_ns)
            self._counts["joints_used"] += 1
            return
        if self._t_ns - measurement.t_ns - self._expected_ns > CLOCK_JUMP_NS:
            self._arrival_counts["clock_jumped_back"] += 1
            self._restart()
            self.on_joints(sample)
            return
        if not self._joint_stamps.take(measurement.t_ns, self._t_ns):
            self._arrival_counts["joints_dropped_repeated_stamp"] += 1
            return
        if measurement.t_ns > self._t_ns:
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
        self._take_late_joints(measurement)

    def _take_late_joints(self, measurement: AngleMeasurement):
        lateness = self._t_ns - measurement.t_ns
        if not lateness:
            self._history.add_after(measurement)
            if not self._history.changed:
                self._correct(measurement)
        elif self._history.put_joints(measurement, self._t_ns):
            self._arrival_counts["joints_late"] += 1
        elif (
            self._history.window_ns
            or lateness - self._expected_ns > self.configuration.filter.late_tolerance * 1e9
        ):
            self._arrival_counts["joints_dropped_late"] += 1
        else:
            self._arrival_counts["joints_late"] += 1
            self._correct(measurement, lateness * 1e-9)

    def _notice_no_orientation(self):
        """Without any orientation for long, what the peg is doing is a guess: it is not told."""
        since = (self._t_ns - self._oriented_ns - max(self._delay_ns, 0)) * 1e-9
        if since > self.configuration.filter.max_joint_gap:
            self._counts["joints_gap"] += not self._blind
            self._blind = True
            self._assessment.restart_mode()

    def _in_hole_axes(self, measurement):
        q, R = measurement.q, measurement.covariance
        return self._offset.in_hole_axes(q, R) if self._offset else (q, R)

    def _correct(self, measurement: AngleMeasurement, lateness: float = 0.0):
        x, P = self._filter.x, self._filter.P
        q, R = self._in_hole_axes(measurement)
        if lateness:
            q = q + lateness * x[3:]
            R = R + lateness**2 * P[3:, 3:]
        if self._delay_variance:
            # What the peg turns in the time by which the stamp may be off.
            R = R + self._delay_variance * np.outer(x[3:], x[3:])
        if self._assessment.friction_seems_high:
            self._filter.seek_friction(q, R)
            self._assessment.friction_sought()
            self._counts["friction_sought"] += 1
            self._counts["joints_used"] += 1
            return
        result, nis = self._filter.correct(q, R)
        if isfinite(nis):
            used = result is Correction.USED
            told = self._innovations.add(
                self._t_ns, nis, self._filter, used, self._in_contact, self._touching
            )
            self._counts["innovations_too_large"] += told.too_large
            if told.friction:
                self._counts["friction_doubted"] += self._filter.doubt()
        if result is not Correction.GATED:
            self._oriented_ns, self._blind = self._t_ns, False
            self._assessment.oriented(self._t_ns, q, R, result is not Correction.INFLATED)
            if measurement.position is not None:
                self._assessment.placed(measurement, self._filter)
        self._counts["joints_gated" if result is Correction.GATED else "joints_used"] += 1
        if result is Correction.INFLATED:
            self._counts["rates_widened"] += 1
        elif result is Correction.RESET:
            self._counts["filter_restarted"] += 1
            self._assessment.restart_mode()

    def on_wrench(self, sample: WrenchSample) -> Outputs | None:
        """Take a wrench; returns the outputs at its stamp, or None if it gives none (counted)."""
        fault = wrench_fault(sample)
        if fault:
            self._arrival_counts[f"wrench_dropped_{fault}"] += 1
            return None
        if not self._started:
            self._arrival_counts["wrench_dropped_before_joints"] += 1
            return None
        if sample.t_ns == self._last_wrench_ns:
            self._arrival_counts["wrench_dropped_repeated_stamp"] += 1
            return None
        if sample.t_ns < self._t_ns:
            self._take_late_wrench(sample)
            return None
        self._recent.append(sample)
        self._last_wrench_ns = sample.t_ns
        self._catch_up()
        joints = []
        while self._waiting and self._waiting[0].t_ns <= sample.t_ns:
            joints.append(self._waiting.popleft())
        before = self._snapshot() if self._history.wants_snapshot else None
        unit = Unit(sample, joints, before, self._t_ns)
        self._history.append(unit)
        return self._process(unit)

    def _take_late_wrench(self, sample: WrenchSample):
        if self._t_ns - sample.t_ns > CLOCK_JUMP_NS:
            self._arrival_counts["clock_jumped_back"] += 1
            self._arrival_counts["wrench_dropped_late"] += 1
            self._restart()
        elif self._history.has_wrench(sample.t_ns):
            self._arrival_counts["wrench_dropped_repeated_stamp"] += 1
        elif self._history.put_wrench(sample, self._t_ns):
            self._arrival_counts["wrench_late"] += 1
        else:
            self._arrival_counts["wrench_dropped_late"] += 1

    def _process(self, unit: Unit) -> Outputs:
        wrench = unit.wrench
        gravity = self._offset.gravity if self._offset else None
        q = self._filter.x[:3]
        self._filter.hold(self._reduction.on_peg(wrench.force, wrench.torque, q, gravity))
        # The estimate stands where the wrench before, or the start, has left it.
        silent = (wrench.t_ns - self._t_ns) * 1e-9 > self.configuration.filter.max_gap
        if silent:
            self._counts["gap"] += 1
        for measurement in unit.joints:
            self._advance(measurement.t_ns, silent)
            self._correct(measurement)
        self._advance(wrench.t_ns, silent)
        self._counts["wrench_used"] += 1
        self._notice_no_orientation()
        outputs = self._assessment.outputs(wrench.t_ns, self._filter, self._innovations.misfit)
        self._note_model(outputs)
        outputs.monitor.update(self._innovations.told())
        if self._offset:
            outputs.monitor.update(self._offset.learnt(self._reduction.taken_off))
        for measurement in unit.after:
            self._correct(measurement)
        self._filter.mark(wrench.t_ns)
        return outputs

    def _note_model(self, outputs: Outputs):
        if self.configuration.filter.model == "dynamic":
            return
        model = self._filter.model
        if model.rung != self._rung:
            self._counts["model_changed"] += 1
        self._rung = model.rung
        outputs.monitor["model"] = float(model.rung)
        if model.error is not None:
            outputs.monitor["model_error"] = model.error

    @property
    def model(self) -> str:
        """Which model of the contact is in use, and why, and what is left out, as one line."""
        return "; ".join(filter(None, (self._filter.model.line, self._assessment.line)))

    @property
    def filter(self) -> ContactFilter:
        """The filter, for those who made it."""
        return self._filter

    def _catch_up(self):
        """Process again from where the first late message was put; its outputs are not given."""
        units = self._history.take_changed()
        if not units:
            return
        self._arrival_counts["went_back"] += 1
        self._arrival_counts["wrench_reprocessed"] += len(units)
        self._restore(units[0][0].before)
        for unit, with_snapshot in units:
            unit.before = self._snapshot() if with_snapshot else None
            unit.begin_ns = self._t_ns
            self._process(unit)

    def _snapshot(self):
        times = self._t_ns, self._oriented_ns
        state = *times, self._in_contact, self._touching, self._blind, self._rung
        parts = self._filter.snapshot(), self._assessment.snapshot(), self._innovations.snapshot()
        return state, parts, dict(self._counts)

    def _restore(self, snapshot):
        state, (kalman, assessment, innovations), counts = snapshot
        self._t_ns, self._oriented_ns, *flags = state
        self._in_contact, self._touching, self._blind, self._rung = flags
        self._innovations.restore(innovations)
        self._filter.restore(kalman)
        self._assessment.restore(assessment)
        self._counts = Counter(counts)

    def _advance(self, t_ns: int, silent: bool):
        """Predict up to a stamp [ns]; silent: no wrench was measured that could be held so far."""
        dt = (t_ns - self._t_ns) * 1e-9
        self._t_ns = t_ns
        if dt <= 0:
            return
        result = self._filter.predict(dt, self._assessment.on_contacts and not silent)
        self._in_contact = result is Prediction.CONTACT
        # A wrong setting makes the mode doubtful as well, and is not to hide behind that.
        self._touching = self._in_contact or self._assessment.doubtful
        if result is Prediction.FAILED:
            self._counts["step_without_solution"] += 1
        elif result is Prediction.LIMITED:
            self._counts["step_limited"] += 1
        elif result is Prediction.SLOW:
            self._counts["step_without_direction"] += 1
        elif result is Prediction.RUNAWAY:
            self._counts["step_runs_away"] += 1
        elif self._filter.refused:
            self._counts["step_divided_no_solution"] += 1
        elif self._filter.inaccurate:
            self._counts["step_divided_inaccurate"] += 1
