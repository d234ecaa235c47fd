"""The compiled estimator and the one on filterpy over the same samples."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimator import mixture
from peg_on_hole_ros.estimator.bias_in_air import corrects_bias, update_bias_in_air
from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.orientation_noise import track_orientation_noise
from peg_on_hole_ros.estimator.orientation_update import (
    orientation_nis,
    pass_time,
    release_still_turns,
    update_from_orientation,
)
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.estimator.start import forget_air, start_mixture
from peg_on_hole_ros.estimator.state import (
    FRICTION,
    OPEN_BEGIN,
    OPENABLE_QUANTITIES,
    begin_state,
    mixture_of,
    places_of,
)
from peg_on_hole_ros.estimator.wrench_update import update_from_wrench
from peg_on_hole_ros.measurements.orientation import PegJoints
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.mechanics.scene import scene_scalars
from peg_on_hole_ros.records import JointSample
from peg_on_hole_ros.sim.measure import measure
from peg_on_hole_ros.typed_record import new
from reference_equations import Cell
from reference_estimator import ReferenceEstimator

RATE_STDDEV = 1.0
ONE_LEVEL = {
    "mode_stddev": (30.0,), "mode_time": (0.05,), "mode_rate": (0.0,), "friction_hypotheses": 1,
}  # fmt: skip
# What is stated of each quantity that may be open.
STATED = {
    "clearance": [0.1],
    "friction_k": [0.05],
    "bias": [1.0] * 3 + [0.02] * 3,
    "tilt": [5e-4] * 2,
    "delay": [2e-4],
    "compliance": [2e-7],
}


class Wrench(NamedTuple):
    """A wrench on the peg, its stamp [s], and an orientation with covariance of that time."""

    t: float
    u: np.ndarray
    q: np.ndarray | None
    R: np.ndarray | None


def samples(truth, seed=None, count=None):
    """Return what the sensors say of a truth, one row a wrench."""
    configuration = truth.plan.configuration
    reduction = WrenchReduction(configuration.wrench, configuration.scene)
    joints, rows, begin, last = PegJoints(configuration.joints), [], None, None
    for sample in measure(truth, seed):
        begin = sample.t_ns if begin is None else begin
        if isinstance(sample, JointSample):
            last = joints(sample)
            continue
        now = last if last is not None and last.t_ns == sample.t_ns else None
        q, R = (None, None) if now is None else (now.q, now.covariance)
        u = reduction.on_peg(sample.force, sample.torque, None)
        rows.append(Wrench((sample.t_ns - begin) * 1e-9, u, q, R))
    return rows[:count], reduction.covariance


def cell_of(scene, noise, open_quantities=(), considered=(), friction_learnt=True, **settings):
    """Return a cell whose open quantities are as STATED."""
    places = places_of(open_quantities)
    n = int(places.reactions)
    walk, learnt = np.zeros(n), np.ones(n + 3)
    walk[FRICTION] = 5e-4**2 if scene.friction_stddev else 0.0
    learnt[FRICTION] = friction_learnt
    for name, width in OPENABLE_QUANTITIES.items():
        first = getattr(places, name)
        if name in open_quantities:
            walk[first : first + width] = (0.1 * np.array(STATED[name])) ** 2
            learnt[first : first + width] = name not in considered
    # A bias of the sensor comes with the lever of the sensor.
    bias_map = np.eye(6)
    bias_map[3, 1], bias_map[4, 0] = -0.035, 0.035
    return Cell(
        scene, default_settings(**settings), open_quantities, noise, bias_map, walk, learnt
    )


class Compiled:
    """The compiled step with its memory, on the interface of the reference."""

    def __init__(self, cell, frictions):
        self.cell = cell
        self.memory = kalman = new(FilterRecord)
        kalman.settings, kalman.scene[:] = cell.settings, scene_scalars(cell.scene)
        kalman.places = places_of(cell.open_quantities)
        kalman.walk[: cell.n], kalman.estimated[: cell.n + 3] = cell.walk, cell.learnt
        kalman.friction_open = bool(cell.scene.friction_stddev)
        kalman.bias_map[:], kalman.noise[:] = cell.bias_map, cell.wrench_noise
        self.state, self.scratch = kalman.state, kalman.scratch
        begin_state(self.state, cell.n + 3, frictions, int(cell.settings.modes))
        self.mixture = mixture_of(self.state)

    def start(self, q, R, rate_stddev, friction, friction_stddev, open_mean, open_stddev):
        kalman, count = self.memory, self.cell.n - OPEN_BEGIN
        kalman.start_friction, kalman.start_friction_stddev = friction, friction_stddev
        kalman.open_mean[:count], kalman.open_stddev[:count] = open_mean, open_stddev
        start_mixture(kalman, q, R, rate_stddev)

    def predict(self, dt):
        mixture.predict(self.memory, dt)
        pass_time(self.state, dt)
        mixture.combine(self.state)

    def correct(self, q, R):
        release_still_turns(self.memory)
        orientation_nis(self.memory, q, R)
        track_orientation_noise(self.memory, q, R)
        update_from_orientation(self.memory, q, R)
        mixture.combine(self.state)

    def weigh(self, u, contacts=3):
        self.memory.wrench[:] = u
        if corrects_bias(self.memory, contacts):
            update_bias_in_air(self.memory)
        else:
            forget_air(self.state)
        update_from_wrench(self.memory, contacts)

    @property
    def mean(self):
        return self.mixture.mean

    @property
    def covariance(self):
        return self.mixture.covariance

    @property
    def weight(self):
        return self.mixture.weight.reshape(len(self.mixture.alive), -1)


def stated(cell):
    """Return what both are started with beside an orientation."""
    values = [
        v for name in OPENABLE_QUANTITIES if name in cell.open_quantities for v in STATED[name]
    ]
    scene = cell.scene
    mean = np.zeros(cell.n - OPEN_BEGIN)
    return RATE_STDDEV, scene.friction, max(scene.friction_stddev, 1e-6), mean, np.array(values)


def run(estimator, rows, contacts=lambda k: 3):
    """Run an estimator over samples, and yield it after each wrench."""
    last = None
    for k, row in enumerate(rows):
        if last is None:
            if row.q is None:
                continue
            estimator.start(row.q, row.R, *stated(estimator.cell))
        else:
            estimator.predict(row.t - last)
            if row.q is not None:
                estimator.correct(row.q, row.R)
        last = row.t
        estimator.weigh(row.u, contacts(k))
        yield estimator


def differences(cell, frictions, rows, contacts=lambda k: 3):
    """
    Return how far the two are apart after each wrench, shape (wrenches, 3).

    Means over standard deviations, covariances over both standard deviations, and weights; before
    the first contact those of the modes, whatever frictions stand for them.
    """
    pairs = zip(
        run(Compiled(cell, frictions), rows, contacts),
        run(ReferenceEstimator(cell, frictions), rows, contacts),
    )
    found = []
    for compiled, reference in pairs:
        over = 1 / np.sqrt(np.maximum(np.diagonal(reference.covariance), 1e-30))
        apart = (compiled.covariance - reference.covariance) * np.outer(over, over)
        found.append(
            [
                np.abs((compiled.mean - reference.mean) * over).max(),
                np.abs(apart).max(),
                np.abs(_weights(compiled, compiled) - _weights(reference, compiled)).max(),
            ]
        )
    return np.array(found)


def _weights(estimator, compiled):
    """Return the weights of all components; while one friction stands for all, of the modes."""
    weight = np.asarray(estimator.weight)
    return weight.sum(axis=0) if compiled.state.gathered else weight


def with_scene(truth, **scene):
    """Return the scene of a truth, changed."""
    return replace(truth.plan.configuration.scene, **scene)
