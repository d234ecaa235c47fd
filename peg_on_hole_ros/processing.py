"""What one wrench and its orientations make of the estimate, and what is told of it."""

from collections import Counter
from collections.abc import Callable, Sequence
from math import isfinite, nan, pi

import numpy as np

from peg_on_hole_ros.estimation.filters.contact import ContactFilter, Correction, Prediction
from peg_on_hole_ros.estimation.filters.methods import make_filter
from peg_on_hole_ros.estimation.filters.offset import NAMES as OFFSET_NAMES
from peg_on_hole_ros.estimation.filters.rivals import Rivals
from peg_on_hole_ros.estimation.history import Unit
from peg_on_hole_ros.estimation.innovations import Innovations
from peg_on_hole_ros.estimation.kernel.offsets import BIAS
from peg_on_hole_ros.estimation.measurement import WrenchReduction
from peg_on_hole_ros.monitoring.assessment import Assessment
from peg_on_hole_ros.monitoring.unjudged import Unjudged
from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.records import AngleMeasurement, Outputs, WrenchSample

# What became of a prediction, where it is counted.
_COUNTED = {
    Prediction.FAILED: "step_without_solution",
    Prediction.LIMITED: "step_limited",
    Prediction.SLOW: "step_without_direction",
    Prediction.DOUBTED: "step_doubted",
    Prediction.RUNAWAY: "step_runs_away",
}
# Without any orientation for so long [s] constant rates lead anywhere, and rounding does in time.
LOST = 5.0
_STATE = ("t_ns", "_oriented_ns", "_in_contact", "_touching", "_blind", "_lost", "_rung")


class Processor:
    """
    The filter, and what watches over it, from one unit to the next in order of their stamps.

    Parameters
    ----------
    configuration : Configuration
    make : callable
        From scene, filter options, the wrench's covariance and what is not known of bias and tilt
        to the filter, as `make_filter`.

    Attributes
    ----------
    filter : ContactFilter
    reduction : WrenchReduction
    assessment : Assessment or Unjudged
    counts : Counter
        What happened, by name; `restore` takes it back.
    t_ns : int or None
        Stamp that the estimate has come to [ns]; None: not started.

    """

    def __init__(
        self, configuration: Configuration, make: Callable[..., ContactFilter] = make_filter
    ):
        self.configuration = configuration
        scene, kalman, joints = configuration.scene, configuration.filter, configuration.joints
        self.reduction = WrenchReduction(configuration.wrench, scene)
        offsets = self.reduction.offsets(configuration)
        self.filter = make(scene, kalman, self.reduction.covariance, offsets)
        # Bias and tilt: most cells know them.
        self._offset = self.filter if offsets.variance.any() else None
        self._rivals = Rivals(lambda: make_filter(scene, kalman, self.reduction.covariance))
        self._delay_ns = max(round(joints.delay * 1e9), 0)
        self._delay_variance = joints.delay_stddev**2
        self._lost_ns = round(max(LOST, kalman.max_joint_gap) * 1e9) + self._delay_ns
        # What a tare has taken, as it is published.
        self._tared: dict[str, float] = {}
        self.assessment = self._new_assessment()
        self._innovations = Innovations(white=self._offset is None)
        self.counts: Counter[str] = Counter()
        self.restart()

    def _new_assessment(self):
        options = self.configuration.monitor
        judge = Assessment if options.modes else Unjudged
        return judge(self.configuration.scene, options, self.reduction.covariance)

    def restart(self) -> None:
        """Let go of the motion; what was learnt stays, and what was counted."""
        self.t_ns = self._oriented_ns = None
        self.filter.let_go()
        self._rivals.let_go()
        self._in_contact = self._touching = self._blind = self._lost = False
        self._rung = self.filter.model.rung
        self._innovations.restart()
        self.assessment.restart()

    def forget(self) -> None:
        """Forget what was learnt, after `restart`; the tare stays."""
        self.filter.forget()
        self._rivals.restart()
        self.assessment = self._new_assessment()

    def retune(self, configuration: Configuration) -> None:
        """Take other gates and thresholds from here on; estimate, mode, flag and alarms stay."""
        self.configuration = configuration
        self.filter.options = configuration.filter
        self.assessment.retune(configuration.monitor)

    def start(self, measurement: AngleMeasurement) -> None:
        """Start from an orientation."""
        self.t_ns = measurement.t_ns
        self._begin(*self._in_hole_axes(measurement))

    def _begin(self, q, R):
        self.filter.start(q, R)
        self._rivals.start(q, R)
        self._oriented_ns, self._lost = self.t_ns, False
        self.counts["joints_used"] += 1

    @property
    def oriented(self) -> bool:
        """Whether there is an estimate: it has been started, and the motion is not lost."""
        return self.t_ns is not None and not self._lost

    def tare(self, samples: Sequence[WrenchSample]) -> np.ndarray:
        """Take the mean of wrenches as that of a free-hanging peg; return what is taken off."""
        force = np.mean([sample.force for sample in samples], axis=0)
        torque = np.mean([sample.torque for sample in samples], axis=0)
        gravity = self._offset.gravity if self._offset else None
        self.reduction.take_tare(force, torque, self.filter.x[:3], gravity)
        if self._offset:
            self._offset.tared(self.reduction.noise / len(samples))
        taken = self.reduction.taken_off
        self._tared = dict(zip(OFFSET_NAMES[BIAS], taken.tolist()))
        return taken

    @property
    def bias(self) -> np.ndarray:
        """What the unloaded sensor reads, as far as it is known, shape (6,) [N], [N m]."""
        learnt = self._offset.offset[BIAS] if self._offset else 0.0
        return self.reduction.taken_off + learnt

    @property
    def health(self) -> dict[str, float]:
        """State of the filter after the last wrench, for diagnostics."""
        return {
            "nis_mean": self._innovations.mean if self._innovations.any else 0.0,
            "evaluations": float(self.filter.evaluations),
            "sub_steps": float(self.filter.pieces),
            "steps_refused": float(self.filter.refused + self.filter.inaccurate),
            **self._innovations.told(),
        }

    @property
    def model(self) -> str:
        """Which model of the contact is in use, and why, and what is left out, as one line."""
        return "; ".join(filter(None, (self.filter.model.line, self.assessment.line)))

    def process(self, unit: Unit) -> Outputs | None:
        """Take the next unit; return the outputs at the stamp of its wrench, None while lost."""
        wrench = unit.wrench
        self._hold(wrench)
        # The estimate stands where the wrench before, or the start, has left it.
        silent = (wrench.t_ns - self.t_ns) * 1e-9 > self.configuration.filter.max_gap
        self.counts["gap"] += silent
        for measurement in unit.joints:
            self._advance(measurement.t_ns, silent)
            found = self._lost
            self.correct(measurement)
            if found:
                self._hold(wrench)
        self._advance(wrench.t_ns, silent)
        if self._lost:
            self.counts["wrench_dropped_without_orientation"] += 1
            for measurement in unit.after:
                self.correct(measurement)
            return None
        self.counts["wrench_used"] += 1
        self._notice_no_orientation()
        outputs = self.assessment.outputs(
            wrench.t_ns, self.filter, self._innovations.misfit, self._blind
        )
        self._note_model(outputs)
        outputs.monitor.update(self._innovations.told())
        self.filter.in_the_air(outputs.contact_mode == "open" and not silent)
        if self._rivals.count:
            outputs = self._with_rivals(outputs)
        outputs.monitor.update(self._tared)
        if self._offset:
            outputs.monitor.update(self._offset.learnt(self.reduction.taken_off))
        for measurement in unit.after:
            self.correct(measurement)
        self.filter.mark(wrench.t_ns)
        return outputs

    def _hold(self, wrench):
        gravity = self._offset.gravity if self._offset else None
        u = self.reduction.on_peg(wrench.force, wrench.torque, self.filter.x[:3], gravity)
        self.filter.hold(u)
        self._rivals.hold(u)

    def _with_rivals(self, outputs: Outputs) -> Outputs:
        friction, normal = self._rivals.widened(self.filter, outputs.normal, outputs.normal_stddev)
        outputs.monitor["friction_rivals"] = float(self._rivals.count)
        outputs.monitor["friction_stddev"] = friction
        determined = outputs.monitor["reactions_determined"]
        return outputs._replace(normal_stddev=normal) if determined else outputs

    def _advance(self, t_ns: int, silent: bool):
        """Predict up to a stamp [ns]; silent: no wrench was measured that could be held so far."""
        dt = (t_ns - self.t_ns) * 1e-9
        self.t_ns = t_ns
        if not self._lost and t_ns - self._oriented_ns > self._lost_ns:
            self._lose()
        if self._lost or dt <= 0:
            return
        in_contact = self.assessment.on_contacts and not silent and not self._blind
        # Where bias or tilt are learnt innovations are not white, and tell no likelihood.
        if in_contact and not self._offset:
            self._rivals.begin(self.filter)
        result = self.filter.predict(dt, in_contact)
        self._rivals.predict(dt, in_contact, self.filter, result)
        unbalance = self.filter.unbalance
        if unbalance is not None:
            self.counts["forces_out_of_balance"] += self._innovations.weigh(t_ns, unbalance)
        self._in_contact = result is Prediction.CONTACT
        # A wrong setting makes the mode doubtful as well, and is not to hide behind that.
        self._touching = self._in_contact or self.assessment.doubtful
        if result in _COUNTED:
            self.counts[_COUNTED[result]] += 1
        elif self.filter.refused:
            self.counts["step_divided_no_solution"] += 1
        elif self.filter.inaccurate:
            self.counts["step_divided_inaccurate"] += 1
        # Beyond a quarter turn there is no tilt, and nothing that is told of it would be true.
        if not -0.5 * pi < self.filter.x.item(0) < 0.5 * pi:
            self._lose()

    def _lose(self):
        """Let go of a motion that nothing is known of; the next orientation begins another."""
        t_ns = self.t_ns
        self.restart()
        self.t_ns, self._lost = t_ns, True
        self.counts["motion_lost"] += 1

    def correct(self, measurement: AngleMeasurement, lateness: float = 0.0) -> None:
        """Correct by an orientation; lateness: how long before the estimate's stamp it was [s]."""
        x, P = self.filter.x, self.filter.P
        q, R = self._in_hole_axes(measurement)
        if self._lost:
            turned = lateness * self.configuration.filter.initial_rate_stddev
            return self._begin(q, R + turned**2 * np.eye(3))
        if lateness:
            q = q + lateness * x[3:]
            R = R + lateness**2 * P[3:, 3:]
        if self._delay_variance:
            # What the peg turns in the time by which the stamp may be off.
            R = R + self._delay_variance * np.outer(x[3:], x[3:])
        if self.assessment.friction_seems_high:
            self.filter.seek_friction(q, R)
            self._rivals.correct(q, R, self.filter, Correction.RESET, nan)
            self.assessment.friction_sought()
            self.counts["friction_sought"] += 1
            self.counts["joints_used"] += 1
            return
        result, nis = self.filter.correct(q, R)
        if isfinite(nis):
            used = result is Correction.USED
            told = self._innovations.add(
                self.t_ns, nis, self.filter, used, self._in_contact, self._touching
            )
            self.counts["innovations_too_large"] += told.too_large
            if told.friction:
                self.counts["friction_doubted"] += self.filter.doubt()
                self._rivals.ask_again()
        self.counts["friction_replaced"] += self._rivals.correct(q, R, self.filter, result, nis)
        if result is not Correction.GATED:
            self._oriented_ns, self._blind = self.t_ns, False
            self.assessment.oriented(self.t_ns, q, R, result is not Correction.INFLATED)
            if measurement.position is not None:
                self.assessment.placed(measurement, self.filter)
        self.counts["joints_gated" if result is Correction.GATED else "joints_used"] += 1
        self.counts["rates_widened"] += result is Correction.INFLATED
        if result is Correction.RESET:
            self.counts["filter_restarted"] += 1
            self.assessment.restart_mode()

    def _in_hole_axes(self, measurement):
        q, R = measurement.q, measurement.covariance
        return self._offset.in_hole_axes(q, R) if self._offset else (q, R)

    def _notice_no_orientation(self):
        """Without any orientation for long, what the peg is doing is a guess: it is not told."""
        since = (self.t_ns - self._oriented_ns - self._delay_ns) * 1e-9
        if since > self.configuration.filter.max_joint_gap:
            self.counts["joints_gap"] += not self._blind
            self._blind = True

    def _note_model(self, outputs: Outputs):
        if self.configuration.filter.model == "dynamic":
            return
        model = self.filter.model
        self.counts["model_changed"] += model.rung != self._rung
        self._rung = model.rung
        outputs.monitor["model"] = float(model.rung)
        if model.error is not None:
            outputs.monitor["model_error"] = model.error

    def snapshot(self):
        """Return everything that what follows depends on, for `restore`."""
        state = {name: getattr(self, name) for name in _STATE}
        filters = self.filter.snapshot(), self._rivals.snapshot()
        parts = *filters, self.assessment.snapshot(), self._innovations.snapshot()
        return state, parts, dict(self.counts)

    def restore(self, snapshot) -> None:
        """Go back to a snapshot; what follows is then bit for bit what followed it."""
        state, (kalman, rivals, assessment, innovations), counts = snapshot
        vars(self).update(state)
        self._innovations.restore(innovations)
        self.filter.restore(kalman)
        self._rivals.restore(rivals)
        self.assessment.restore(assessment)
        self.counts = Counter(counts)
