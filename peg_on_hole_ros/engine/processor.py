"""Settings and state that compiled `steps` work on, of one `Engine`; what is reported of them."""

from collections import Counter
from collections.abc import Sequence
from math import isnan, sqrt
from typing import Any

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.diagnosis.suspected.suspect import Standing
from peg_on_hole_ros.engine import steps
from peg_on_hole_ros.engine.ring import Unit
from peg_on_hole_ros.engine.state import COUNTS, EngineState, Rules
from peg_on_hole_ros.engine.tuned import KNOWN_MOTION
from peg_on_hole_ros.estimator.contact_filter import CORRECTIONS, ContactFilter
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.methods.method import Make
from peg_on_hole_ros.estimator.methods.registry import make_filter
from peg_on_hole_ros.measurements.freshness import causes
from peg_on_hole_ros.measurements.wrench_noise import registry as wrench_noise
from peg_on_hole_ros.measurements.wrench_noise import repeated, rough, saturated
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction, noise_of, turn_to_sensor
from peg_on_hole_ros.monitor.memory import begin_memory
from peg_on_hole_ros.monitor.pose_only import MODES_OFF
from peg_on_hole_ros.monitor.settings import force_noise, monitor_settings
from peg_on_hole_ros.monitor.states import NO_STAMP
from peg_on_hole_ros.monitor.way_in import NOT_TOLD, may_be_plate
from peg_on_hole_ros.number_text import quantity
from peg_on_hole_ros.records import AngleMeasurement, WrenchSample
from peg_on_hole_ros.typed_record import at, dtype_of


class Processor:
    """
    The filter, and what watches over it, from one unit to the next in order of their stamps.

    Parameters
    ----------
    configuration : Configuration
    make : callable
        From scene, filter options, the wrench's covariance and what is not known of bias and tilt
        to the filter, as `make_filter`. One that is derived from `ContactFilter` is called step by
        step.

    Attributes
    ----------
    filter : ContactFilter
    reduction : WrenchReduction
    memory : ndarray of EngineState, shape (1,)
        All that the next wrench depends on.
    words : ndarray of int64
        The same memory.
    engine : EngineState
        The same memory.
    rules_memory : ndarray of Rules, shape (1,)
    in_one_piece : bool
        Whether compiled code processes wrenches; otherwise `take_wrench` and `correct` do.

    """

    def __init__(self, configuration: Configuration, make: Make = make_filter) -> None:
        self.configuration = configuration
        scene, kalman, joints = configuration.scene, configuration.filter, configuration.joints
        self.reduction = WrenchReduction(configuration.wrench, scene, joints.hole_rpy)
        self._offsets = self.reduction.offsets(configuration)
        self.filter = make(scene, kalman, self.reduction.covariance, self._offsets)
        self.reduction.fill_accuracies(self.filter.fields.accuracies, configuration.accuracy)
        # A filter that has steps of its own is called step by step.
        self.in_one_piece = type(self.filter) is ContactFilter
        self.memory = np.zeros(1, dtype_of(EngineState))
        self.engine, self.words = at(EngineState, self.memory), self.memory.view(np.int64)
        self.engine.reduction = self.reduction.steps
        self.engine.tared[:] = np.nan
        self._state_noise()
        begin_memory(self.engine.memory)
        self.filter.rebind_memory(self.memory[0]["filter"])
        self.rules_memory = np.zeros(1, dtype_of(Rules))
        self.rules = at(Rules, self.rules_memory)
        self.rules.joints_variance = 1.0
        self._rule()
        self.restart()

    def _state_noise(self):
        reduction = self.reduction
        self._force_stddev = force_noise(self.configuration.scene, reduction.covariance)
        self.engine.variance[:] = reduction.noise
        self.engine.covariance[:] = reduction.covariance

    def _rule(self):
        configuration, kalman = self.configuration, self.configuration.filter
        delay_ns = max(round(configuration.joints.delay * 1e9), 0)
        rules = self.rules
        rules.gates = self.filter.gates
        rules.monitor = monitor_settings(
            configuration.monitor, configuration.scene, self._force_stddev
        )
        rules.judged = configuration.monitor.modes
        # Bias and tilt: most cells know them.
        rules.white = not self._offsets.variance.any()
        rules.max_gap, rules.max_joint_gap = kalman.max_gap, kalman.max_joint_gap
        rules.delay_ns = delay_ns
        lost = max(KNOWN_MOTION.lost, kalman.max_joint_gap)
        rules.lost_ns = round(lost * 1e9) + delay_ns

    @property
    def t_ns(self) -> int | None:
        """Stamp that the estimate has come to [ns]; None: not started."""
        t_ns = self.engine.progress.t_ns
        return None if t_ns == NO_STAMP else t_ns

    @property
    def _lost(self):
        return bool(self.engine.progress.lost)

    @property
    def counts(self) -> Counter[str]:
        """What happened, by name; `restore` undoes it."""
        return Counter({name: getattr(self.engine.counts, name).item() for name in COUNTS})

    def restart(self) -> None:
        """Forget the motion; what was learnt stays, and what was counted."""
        self.filter.end_estimate()
        steps.restart(self.engine, self.rules)

    def forget(self) -> None:
        """Forget what was learnt, after `restart`; the tare stays."""
        self.filter.forget()
        begin_memory(self.engine.memory)

    def retune(self, configuration: Configuration) -> None:
        """Use other gates, noise and thresholds; estimate, mode, flag and alarms stay."""
        before, self.configuration = self.configuration, configuration
        self.filter.options = configuration.filter
        if noise_of(configuration.wrench) != noise_of(before.wrench):
            self.reduction.take_noise(configuration.wrench)
            self._state_noise()
            wrench_noise.begin(self.engine.wrench_noise)
        self._rule()

    def start(self, measurement: AngleMeasurement) -> None:
        """Start from an orientation."""
        self.engine.progress.t_ns = measurement.t_ns
        self.filter.start(measurement.q, measurement.covariance)
        steps.record_start(self.engine)

    @property
    def oriented(self) -> bool:
        """Whether there is an estimate: it has been started, and the motion is not lost."""
        return self.t_ns is not None and not self._lost

    def tare(self, samples: Sequence[WrenchSample]) -> np.ndarray:
        """Take the mean of wrenches as that of a free-hanging peg; return what is taken off."""
        force = np.mean([sample.force for sample in samples], axis=0)
        torque = np.mean([sample.torque for sample in samples], axis=0)
        self.reduction.take_tare(force, torque, self.filter.x[:3], self.filter.gravity)
        self.filter.restart_bias(self.reduction.noise / len(samples))
        taken = self.reduction.taken_off
        self.engine.tared[:], self.engine.reduction = taken, self.reduction.steps
        return taken

    def shift_zero(self, jump: np.ndarray, measured: AngleMeasurement) -> None:
        """
        Take so much more off a wrench, sensor axes, shape (6,) [N], [N m], and begin anew.

        What the wrench has taught since the zero has jumped is forgotten, with what was learnt
        before it: how well the new zero is known, is what is stated of one. Flag and way stay.
        """
        self.reduction.tare += jump
        self.engine.reduction = self.reduction.steps
        if np.isfinite(self.engine.tared).all():
            self.engine.tared[:] = self.reduction.taken_off
        self.filter.restart_bias(np.full(6, np.inf))
        self.filter.end_estimate()
        self.filter.forget()
        steps.begin_mode_anew(self.engine, self.rules)
        self.start(measured)
        # It was used before.
        self.engine.counts.joints_used -= 1

    @property
    def gravity_in_sensor(self) -> np.ndarray:
        """Gravity in sensor axes at the present estimate, shape (3,) [m/s^2]."""
        return self.reduction.gravity_in_sensor(self.filter.x[:3], self.filter.gravity)

    def in_sensor_axes(self, wrench: np.ndarray) -> np.ndarray:
        """Return a wrench as received as the sensor reads it, whatever axes it came in, (6,)."""
        read = wrench.copy()
        turn_to_sensor(self.reduction.steps, read, self.filter.x[:3])
        return self.reduction.sign * read

    def zero_of(self, wrench: np.ndarray) -> np.ndarray:
        """Return the `WrenchReduction.tare` with which a wrench is a free peg's, shape (6,)."""
        return self.reduction.zero_of(
            wrench[:3], wrench[3:], self.filter.x[:3], self.filter.gravity
        )

    @property
    def open_since(self) -> float:
        """Since when the contact mode has been `open` [s]; NaN: it is another."""
        return float(self.engine.memory.alarms.open_since)

    @property
    def is_blind(self) -> bool:
        """Whether no orientation has come for long, or none that is news."""
        return bool(self.engine.progress.blind)

    @property
    def bias(self) -> np.ndarray:
        """What the unloaded sensor reads, as far as it is known, shape (6,) [N], [N m]."""
        return self.reduction.taken_off + self.filter.bias

    @property
    def health(self) -> dict[str, float]:
        """State of the filter after the last wrench, for diagnostics."""
        seen = self.engine.innovations
        found = {"nis_median": float(seen.median)}
        if self.rules.white:
            found["nis_drift"] = float(seen.drift)
        return {
            "nis_mean": float(seen.average) if seen.corrections else 0.0,
            "frictions": float(self.filter.hypotheses),
            "joints_noise": sqrt(self.filter.orientation_noise),
            "wrench_noise": sqrt(rough.factor(self.engine.wrench_noise.rough)),
            "misfit": float(seen.too_large),
            **{name: value for name, value in found.items() if value == value},
        }

    @property
    def noise_report(self) -> str:
        """What is reported of orientations that are noisier than stated; empty: nothing."""
        stated = self.configuration.joints.position_stddev
        if not self.counts["joints_noisy"]:
            return ""
        noise = self.engine.progress.noise
        return (
            f"joints.position_stddev: the noise of joint states is {noise:.1f} times the stated "
            f"one, {quantity(noise * stated, 'rad', 2)} for {quantity(stated, 'rad')}: used as "
            "found"
        )

    def causes(self, joints_explained: bool = False) -> list[str]:
        """
        Return what is wrong with the values that come, or is not told by them, a line each.

        `joints_explained`: whether it is known what is odd about the values of joint states.
        """
        e = self.engine
        wrench = wrench_noise.causes(e.wrench_noise, e.variance)
        memory = e.memory
        undecided = may_be_plate(memory.way, memory.declared.mode, memory.evidence)
        # A place that is measured decides, or the peg stands on a cone that it will leave.
        contact = [NOT_TOLD] if undecided and isnan(memory.place.deviations) else []
        joints = [] if joints_explained else [*causes(e.fresh), *filter(None, [self.noise_report])]
        return [*wrench, *joints, *contact]

    def widen_orientations(self, times: float) -> None:
        """Take orientations from here on as of so many times their stated variance [-]."""
        self.rules.joints_variance = times

    @property
    def is_beside_hole(self) -> bool:
        """Whether the place tells, likelier than not, that the peg may stand beside the hole."""
        return bool(self.engine.memory.place.beside > 0.5)

    @property
    def may_touch(self) -> bool:
        """Whether the place shows, likelier than not, a peg low enough to touch something."""
        return bool(self.engine.memory.place.within_reach > 0.5)

    @property
    def is_misfit(self) -> bool:
        """Whether the innovations in contact are larger than stated."""
        return bool(self.engine.innovations.too_large)

    @property
    def is_saturated(self) -> bool:
        """Whether a component of the last wrench was at the end of its range."""
        return bool(saturated.is_off(self.engine.wrench_noise.saturated))

    @property
    def standing(self) -> Standing | None:
        """Of a wrench that repeats one value, and is no measurement; None: it is one."""
        state = self.engine.wrench_noise.repeated
        if not repeated.is_off(state):
            return None
        since_ns = round(state.repeats.since * 1e9)
        return Standing(since_ns, bool(state.zeros), bool(state.turned_away))

    @property
    def stood_still_until_ns(self) -> int:
        """Stamp of the last wrench that was not used, as it repeated one value; 0: none [ns]."""
        return int(self.engine.wrench_noise.repeated.off_ns)

    @property
    def left_out(self) -> str:
        """What is left out of the model, as one line; empty: nothing."""
        return "" if self.rules.judged else MODES_OFF

    # A filter that is written in Python is called step by step.

    def take_wrench(self, unit: Unit, row: Any) -> bool:
        """Process a wrench with its orientations, fill in its row; return whether it has one."""
        e, rules = self.engine, self.rules
        silent = steps.is_after_silence(e, rules, unit.t_ns)
        for stamp, orientation in unit.before:
            self._advance(e, rules, stamp)
            self.correct(stamp, orientation, 0.0)
        self._advance(e, rules, unit.t_ns)
        admit_wrench = steps.admit_wrench(e, rules)
        if admit_wrench:
            contacts = steps.reduce(e, unit.t_ns, unit.wrench, silent)
            self.filter.weigh(e.u.copy(), ContactSet(contacts))
            self.filter.mark(unit.t_ns)
            steps.fill_row(e, rules, unit.t_ns, contacts, row)
        for stamp, orientation in unit.after:
            self.correct(stamp, orientation, 0.0)
        return admit_wrench

    def _advance(self, e, rules, t_ns):
        was_lost = self._lost
        dt = steps.time_to_predict(e, rules, t_ns)
        if dt > 0.0:
            self.filter.predict(dt)
            steps.check_upright(e, rules)
        if self._lost and not was_lost:
            self.filter.end_estimate()

    def correct(self, stamp: int, orientation: np.ndarray, lateness: float) -> None:
        """Correct by an orientation; parameters as for `steps.correct`."""
        e, rules = self.engine, self.rules
        kind = steps.classify_orientation(e, rules, stamp, orientation, lateness)
        if kind == steps.BEGINS:
            self.filter.start(e.q.copy(), e.R.copy())
            steps.record_start(e)
        elif kind == steps.NEWS:
            result, nis = self.filter.correct(e.q.copy(), e.R.copy())
            steps.record_orientation(e, rules, orientation, CORRECTIONS.index(result), nis)
