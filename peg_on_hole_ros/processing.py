"""What one wrench and its orientations make of the estimate, and what is told of it."""

from collections import Counter
from collections.abc import Callable, Sequence
from math import isfinite, pi, sqrt

import numpy as np

from peg_on_hole_ros.estimation.freshness import Freshness
from peg_on_hole_ros.estimation.history import Unit
from peg_on_hole_ros.estimation.innovations import Innovations
from peg_on_hole_ros.estimation.measurement import WrenchReduction
from peg_on_hole_ros.estimator.held_peg import ContactSet, Correction, HeldPeg
from peg_on_hole_ros.estimator.methods import make_filter
from peg_on_hole_ros.estimator.offsets import NAMES as OFFSET_NAMES
from peg_on_hole_ros.monitoring.judge import Judge
from peg_on_hole_ros.monitoring.outputs import outputs_of
from peg_on_hole_ros.monitoring.row import AT
from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.records import AngleMeasurement, Outputs, WrenchSample

# Without any orientation for so long [s] constant rates lead anywhere, and rounding does in time.
LOST = 5.0
# Orientations whose variance is found so many times the stated one are noisier than is stated.
NOISY = 2.25
# On contacts whose reactions have not been told for so long a peg is at rest [ns].
RESTS_NS = 100_000_000
_STATE = (
    "t_ns",
    "_oriented_ns",
    "_slid_ns",
    "_in_contact",
    "_touching",
    "_blind",
    "_lost",
    "_held",
)


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
    filter : HeldPeg
    reduction : WrenchReduction
    judge : Judge
    counts : Counter
        What happened, by name; `restore` takes it back.
    t_ns : int or None
        Stamp that the estimate has come to [ns]; None: not started.

    """

    def __init__(self, configuration: Configuration, make: Callable[..., HeldPeg] = make_filter):
        self.configuration = configuration
        scene, kalman, joints = configuration.scene, configuration.filter, configuration.joints
        self.reduction = WrenchReduction(configuration.wrench, scene, joints.hole_rpy)
        offsets = self.reduction.offsets(configuration)
        self.filter = make(scene, kalman, self.reduction.covariance, offsets)
        # Bias and tilt: most cells know them.
        self._offsets_open = bool(offsets.variance.any())
        self._delay_ns = max(round(joints.delay * 1e9), 0)
        self._lost_ns = round(max(LOST, kalman.max_joint_gap) * 1e9) + self._delay_ns
        # What a tare has taken, as it is published.
        self._tared: dict[str, float] = {}
        self.judge = self._new_judge()
        self._innovations = Innovations(white=not self._offsets_open)
        # Of how many wrenches each is one.
        self._fresh, self._held = Freshness(), 1
        self.counts: Counter[str] = Counter()
        # How much noisier than stated orientations were when they last were so.
        self._noise = 1.0
        self.restart()

    def _new_judge(self):
        configuration = self.configuration
        return Judge(configuration.scene, configuration.monitor, self.reduction.covariance)

    def restart(self) -> None:
        """Let go of the motion; what was learnt stays, and what was counted."""
        self.t_ns = self._oriented_ns = None
        self._slid_ns = 0
        self.filter.let_go()
        self.filter.take_noise_as_stated()
        self._in_contact = self._touching = self._blind = self._lost = False
        self._innovations.restart()
        self.judge.restart()

    def forget(self) -> None:
        """Forget what was learnt, after `restart`; the tare stays."""
        self.filter.forget()
        self.judge = self._new_judge()

    def retune(self, configuration: Configuration) -> None:
        """Take other gates and thresholds from here on; estimate, mode, flag and alarms stay."""
        self.configuration = configuration
        self.filter.options = configuration.filter
        self.judge.retune(configuration.monitor)

    def start(self, measurement: AngleMeasurement) -> None:
        """Start from an orientation."""
        self.t_ns = measurement.t_ns
        self._begin(measurement.q, measurement.covariance)

    def _begin(self, q, R):
        self.filter.start(q, R)
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
        self.reduction.take_tare(force, torque, self.filter.x[:3], self.filter.gravity)
        self.filter.tared(self.reduction.noise / len(samples))
        taken = self.reduction.taken_off
        self._tared = dict(zip(OFFSET_NAMES[:6], taken.tolist()))
        return taken

    @property
    def gravity_in_sensor(self) -> np.ndarray:
        """Gravity in sensor axes at the present estimate, shape (3,) [m/s^2]."""
        return self.reduction.in_sensor(self.filter.x[:3], self.filter.gravity)

    @property
    def bias(self) -> np.ndarray:
        """What the unloaded sensor reads, as far as it is known, shape (6,) [N], [N m]."""
        return self.reduction.taken_off + self.filter.bias

    @property
    def health(self) -> dict[str, float]:
        """State of the filter after the last wrench, for diagnostics."""
        return {
            "nis_mean": self._innovations.mean if self._innovations.any else 0.0,
            "frictions": float(self.filter.frictions),
            "joints_noise": sqrt(self.filter.orientation_noise),
            **self._innovations.told(),
        }

    @property
    def noisier(self) -> str:
        """What there is to say of orientations that are noisier than stated; empty: nothing."""
        stated = self.configuration.joints.position_stddev
        if not self.counts["joints_noisy"]:
            return ""
        return (
            f"joints.position_stddev: the noise of joint states is {self._noise:.1f} times the "
            f"stated one, {self._noise * stated:.2g} rad for {stated:g} rad: used as found"
        )

    @property
    def causes(self) -> list[str]:
        """What is wrong with the values that come, a line each."""
        return [*self._fresh.causes, *filter(None, [self.noisier])]

    @property
    def misfit(self) -> float:
        """How badly the contacts fit, see `Innovations`."""
        return self._innovations.misfit

    @property
    def model(self) -> str:
        """What is left out of the model, as one line; empty: nothing."""
        return self.judge.line

    def process(self, unit: Unit) -> Outputs | None:
        """Take the next unit; return the outputs at the stamp of its wrench, None while lost."""
        wrench = unit.wrench
        # The estimate stands where the wrench before, or the start, has left it.
        silent = (wrench.t_ns - self.t_ns) * 1e-9 > self.configuration.filter.max_gap
        self.counts["gap"] += silent
        for measurement in unit.joints:
            self._advance(measurement.t_ns)
            self.correct(measurement)
        self._advance(wrench.t_ns)
        if self._lost:
            self.counts["wrench_dropped_without_orientation"] += 1
            for measurement in unit.after:
                self.correct(measurement)
            return None
        self.counts["wrench_used"] += 1
        self._notice_no_orientation()
        self._weigh(wrench, silent)
        row = self.judge.row(wrench.t_ns, self.filter, self._innovations.misfit, self._blind)
        # Of a peg at rest friction leans one way for long, which is no wrong setting. One that is
        # wrong makes the mode doubtful as well, and is not to hide behind that.
        if not self._in_contact or row[AT.reactions_determined] > 0.0:
            self._slid_ns = wrench.t_ns
        slides = self._in_contact and wrench.t_ns - self._slid_ns < RESTS_NS
        self._touching = slides or self.judge.doubtful
        for name, value in self._beside().items():
            row[getattr(AT, name)] = value
        outputs = outputs_of(wrench.t_ns, row)
        for measurement in unit.after:
            self.correct(measurement)
        return outputs

    def _beside(self):
        """Return what is told of innovations, tare, bias and tilt, by name."""
        learnt = self.filter.learnt(self.reduction.taken_off)
        noise = {"joints_noise": sqrt(self.filter.orientation_noise)}
        return self._innovations.told() | noise | self._tared | learnt

    def _weigh(self, wrench, silent):
        u = self.reduction.on_peg(
            wrench.force, wrench.torque, self.filter.x[:3], self.filter.gravity
        )
        # What has touched before a silence need not touch after it.
        known = not (self._blind or silent)
        contacts = self.judge.contacts if known else ContactSet.UNKNOWN
        # A value that comes n times tells as much as if it came once.
        times = self._fresh.wrench(wrench)
        if times != self._held:
            self._held = times
            self.filter.wrench_noise = times * self.reduction.covariance
        self.filter.weigh(u, contacts)
        self.counts["wrench_spike"] += self.filter.took_spike
        self.filter.mark(wrench.t_ns)
        self._in_contact = contacts is ContactSet.THREE

    def _advance(self, t_ns: int):
        """Predict up to a stamp [ns]."""
        dt = (t_ns - self.t_ns) * 1e-9
        self.t_ns = t_ns
        if not self._lost and t_ns - self._oriented_ns > self._lost_ns:
            self._lose()
        if self._lost or dt <= 0:
            return
        self.filter.predict(dt)
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
        q, R = measurement.q, measurement.covariance
        if self._lost:
            turned = lateness * self.configuration.filter.initial_rate_stddev
            return self._begin(q, R + turned**2 * np.eye(3))
        if not self._fresh.orientation(measurement, x[:3], P.item(0, 0)):
            self.counts["joints_dropped_repeated_value"] += 1
            return None
        if lateness:
            q = q + lateness * x[3:]
            R = R + lateness**2 * P[3:, 3:]
        result, nis = self.filter.correct(q, R)
        if self.filter.orientation_noise > NOISY:
            self.counts["joints_noisy"] += 1
            self._noise = sqrt(self.filter.orientation_noise)
        if isfinite(nis):
            used = result is Correction.USED
            self.counts["innovations_too_large"] += self._innovations.add(
                nis, self.filter.innovation if used else None, self._in_contact, self._touching
            )
        if result is not Correction.GATED:
            self._oriented_ns, self._blind = self.t_ns, False
            R = R * self.filter.orientation_noise
            self.judge.oriented(self.t_ns, q, R, result is Correction.USED)
            if measurement.position is not None:
                self.judge.placed(measurement, self.filter)
        self.counts["joints_gated" if result is Correction.GATED else "joints_used"] += 1
        if result is Correction.RESET:
            self.counts["filter_restarted"] += 1
            self.judge.restart_mode()

    def _notice_no_orientation(self):
        """Without any orientation for long, what the peg is doing is a guess: it is not told."""
        since = (self.t_ns - self._oriented_ns - self._delay_ns) * 1e-9
        if since > self.configuration.filter.max_joint_gap or self._fresh.still:
            self.counts["joints_gap"] += not self._blind
            self._blind = True

    def snapshot(self):
        """Return everything that what follows depends on, for `restore`."""
        state = {name: getattr(self, name) for name in _STATE}
        parts = self.filter.snapshot(), self.judge.snapshot(), self._innovations.snapshot()
        return state, parts, dict(self.counts), self._fresh.snapshot()

    def restore(self, snapshot) -> None:
        """Go back to a snapshot; what follows is then bit for bit what followed it."""
        state, (kalman, judge, innovations), counts, fresh = snapshot
        vars(self).update(state)
        self._fresh.restore(fresh)
        self.filter.wrench_noise = self._held * self.reduction.covariance
        self._innovations.restore(innovations)
        self.filter.restore(kalman)
        self.judge.restore(judge)
        self.counts = Counter(counts)
