"""One filter step in each of its implementations: cost, and how far the results are apart."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimation.filters.contact import ContactFilter
from peg_on_hole_ros.estimation.kernel.memory import part
from peg_on_hole_ros.estimation.measurement import WrenchReduction
from peg_on_hole_ros.estimation.reference.kalman import ReferenceFilter
from peg_on_hole_ros.mechanics.kernel import WIDTH
from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.simulation.measure import measure
from peg_on_hole_ros.study.scenes import Recording
from peg_on_hole_ros.study.step_loop import run_steps

C, KERNEL, CALLED, PIPELINE, FILTERPY = (
    "the same step as C",
    "kernel",
    "kernel, called from Python",
    "pipeline, messages to outputs",
    "numpy model, filterpy's EKF",
)
DEFAULT = KERNEL
# The first steps find the rates; what is timed is the filter under way.
_WARM = 25
_REFERENCE_STEPS = 25


class Cost(NamedTuple):
    """
    One implementation.

    Attributes
    ----------
    name : str
    microseconds, least : float
        A step: median over the repetitions, and the least.
    over_c : float
        Median of the ratio to C within a repetition; NaN where there is no C.
    difference : float
        Largest difference of state and reactions to the kernel at the last step, over the stated
        standard deviations; NaN for the pipeline, which takes its steps at other times.

    """

    name: str
    microseconds: float
    least: float
    over_c: float
    difference: float


class _Run:
    def __init__(self, configuration: Configuration, truth, recording: Recording):
        self.configuration, self.truth = configuration, truth
        rows = np.flatnonzero(np.isfinite(recording.angles).all(axis=1))
        self.wrench = np.ascontiguousarray(recording.wrench[rows])
        self.angles = np.ascontiguousarray(recording.angles[rows])
        self.covariances = np.ascontiguousarray(recording.covariances[rows])
        self.dt = recording.dt * int(rows[1] - rows[0])
        self.noise = WrenchReduction(configuration.wrench, configuration.scene).covariance
        kalman = ContactFilter(configuration.scene, configuration.filter, self.noise)
        kalman.start(self.angles[0], self.covariances[0])
        self.kalman = kalman
        for k in range(1, _WARM):
            self._step(k)
        self.memory, self.joint = kalman._memory.copy(), kalman.joint_covariance()
        self.count = len(rows) - _WARM
        self.samples = list(measure(truth, 1))

    def _step(self, k):
        kalman = self.kalman
        kalman.hold(self.wrench[k])
        kalman.predict(self.dt, True)
        kalman.correct(self.angles[k], self.covariances[k])
        return kalman.reactions()

    def loop(self, function, clock, count=None):
        self.kalman._memory[:] = self.memory
        count, part = count or self.count, slice(_WARM, None)
        options = self.configuration.filter
        arguments = (
            self.kalman._memory, np.zeros((6, WIDTH)), np.zeros((6, WIDTH)), self.dt, count,
            self.wrench[part].ravel(), self.angles[part].ravel(), self.covariances[part].ravel(),
            options.acceleration_stddev, options.free_rate_noise,
        )  # fmt: skip
        begun = clock()
        function(*arguments)
        seconds = (clock() - begun) / count
        return seconds, np.concatenate([self.kalman.x, self.kalman._normal])

    def called(self, clock):
        self.kalman._memory[:] = self.memory
        begun = clock()
        for k in range(_WARM, _WARM + self.count):
            found = self._step(k)
        return (clock() - begun) / self.count, np.concatenate([self.kalman.x, found.normal])

    def pipeline(self, clock):
        pipeline = Pipeline(self.configuration)
        begun = clock()
        wrenches = sum(1 for _ in pipeline.play(self.samples))
        return (clock() - begun) / wrenches, None

    def reference(self, clock):
        kalman = self.kalman
        kalman._memory[:] = self.memory
        slow = []
        for k in range(_WARM, _WARM + _REFERENCE_STEPS):
            self._step(k)
            slow.append(kalman._slow[0] > 0)
        kalman._memory[:] = self.memory
        reference = ReferenceFilter(self.configuration.scene, kalman.process, self.noise)
        learnt = kalman.friction[0], kalman.peg_diameter[0]
        reference.x = np.concatenate([kalman.x, kalman.u, learnt])
        reference.P = self.joint.copy()
        reference.stopped = part(kalman._memory, "STOPPED").item()
        _take_bridging(reference.rate_noise, reference.acceleration, kalman.memory)
        gain, share = part(kalman._memory, "TOLD_GAIN"), part(kalman._memory, "TOLD_SHARE").item()
        reference.balance = (gain.copy(), share) if share > 0 else None
        lag = reference.friction_lag
        lag.value, lag.variance, lag.lag = part(kalman.memory, "FRICTION_LAG").tolist()
        reference.begin_beside()
        beside = reference.beside
        beside.x = part(kalman.memory, "BESIDE_X").copy()
        beside.P = part(kalman.memory, "BESIDE_P", (6, 6)).copy()
        _take_bridging(beside.noise, beside.acceleration, kalman.memory, "BESIDE_")
        begun = clock()
        for k in range(_WARM, _WARM + _REFERENCE_STEPS):
            reference.hold(self.wrench[k])
            reference.learn_from_balance(self.dt, self.configuration.filter.acceleration_stddev)
            if slow[k - _WARM]:
                reference.predict_slow(self.dt)
            else:
                reference.predict_contact(self.dt)
            reference.correct(self.angles[k], self.covariances[k])
            normal, _ = reference.reactions(self.configuration.filter.acceleration_stddev)
        seconds = (clock() - begun) / _REFERENCE_STEPS
        return seconds, np.concatenate([reference.x[:6], normal])


def _take_bridging(rate_noise, acceleration, memory, whose=""):
    """Take what is followed for constant rates, of the estimate or of those BESIDE_ it."""
    copy = {
        name: part(memory, whose + name).copy()
        for name in ("RATE_NOISE", "LEAN", "ACCELERATION", "RATES_BEFORE", "ACCELERATION_BEFORE",
                     "CHANGES", "CHANGES_SEEN")
    }  # fmt: skip
    rate_noise.value, rate_noise.lean = copy["RATE_NOISE"].item(), copy["LEAN"]
    acceleration.mean, acceleration.rates = copy["ACCELERATION"], copy["RATES_BEFORE"]
    acceleration.before, acceleration.changes = copy["ACCELERATION_BEFORE"], copy["CHANGES"]
    acceleration.seen = copy["CHANGES_SEEN"].item()


def costs(configuration, truth, recording, c_step, clock: Callable[[], float], repeats: int):
    """
    Return the Cost of each implementation, each repetition running them in turn.

    Parameters
    ----------
    configuration : Configuration
    truth, recording
        A motion and its measurement.
    c_step : callable or None
        `run_steps` as C.
    clock : callable
        Returns a time [s].
    repeats : int

    """
    run = _Run(configuration, truth, recording)
    ways = {KERNEL: lambda: run.loop(run_steps, clock), CALLED: lambda: run.called(clock)}
    if c_step is not None:
        ways[C] = lambda: run.loop(c_step, clock)
    ways[PIPELINE] = lambda: run.pipeline(clock)
    for way in ways.values():
        way()
    seconds = {name: [] for name in ways}
    ends = {}
    for _ in range(repeats):
        for name, way in ways.items():
            spent, ends[name] = way()
            seconds[name].append(spent)
    _, at_reference = run.loop(run_steps, clock, _REFERENCE_STEPS)
    spent, reference_end = run.reference(clock)
    _, kernel_end = run.loop(run_steps, clock)
    stddev = np.sqrt(np.concatenate([run.kalman.P.diagonal(), run.kalman._normal_variance]))
    found = []
    for name, spans in seconds.items():
        difference = float("nan")
        if ends[name] is not None:
            difference = float(np.abs((ends[name] - kernel_end) / stddev).max())
        ratio = np.median(np.divide(spans, seconds[C])) if C in seconds else float("nan")
        found.append(
            Cost(name, 1e6 * float(np.median(spans)), 1e6 * min(spans), float(ratio), difference)
        )
    difference = float(np.abs((reference_end - at_reference) / stddev).max())
    ratio = spent / np.median(seconds[C]) if C in seconds else float("nan")
    found.append(Cost(FILTERPY, 1e6 * spent, 1e6 * spent, float(ratio), difference))
    return sorted(found, key=lambda cost: cost.microseconds)
