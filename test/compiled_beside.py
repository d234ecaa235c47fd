"""The compiled estimator and the one on filterpy over the same samples."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimator import free, mixture, step
from peg_on_hole_ros.estimator.held import SETTINGS, fill_settings
from peg_on_hole_ros.estimator.noise import follow_noise
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.estimator.state import (
    BIAS,
    FRICTION,
    OPEN,
    QUANTITIES,
    SCRATCH,
    STATE,
    WIDTHS,
    begin_state,
    named,
    places,
)
from peg_on_hole_ros.measurements.measurement import WrenchReduction
from peg_on_hole_ros.measurements.orientation import PegJoints
from peg_on_hole_ros.mechanics.kernel import scene_scalars
from peg_on_hole_ros.records import JointSample
from peg_on_hole_ros.sim.measure import measure
from reference_equations import Cell
from reference_estimator import ReferenceEstimator

RATE_STDDEV = 1.0
ONE_LEVEL = {"level": (30.0,), "time": (0.05,), "up": (0.0,), "frictions": 1}
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
    _, n = places(open_quantities)
    walk, learnt = np.zeros(n), np.ones(n + 3)
    walk[FRICTION] = 5e-4**2 if scene.friction_stddev else 0.0
    learnt[FRICTION] = friction_learnt
    at, _ = places(open_quantities)
    for name, first, width in zip(QUANTITIES, at, WIDTHS):
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
        self.cell, self.scalars = cell, scene_scalars(cell.scene)
        self.at, self.n = places(cell.open_quantities)
        sizes = self.n, frictions, len(cell.settings.level)
        self.memory, self.scratch = np.zeros(1, STATE), np.zeros(1, SCRATCH)[0]
        self.record = self.memory[0]
        begin_state(self.record, *sizes)
        self.state, self.settings = named(self.record), np.zeros(1, SETTINGS)[0]
        fill_settings(self.settings, cell.settings)

    def start(self, q, R, *stated):
        step.start(self.record, self.scratch, self.settings, self.at, self.n, q, R, *stated)

    def predict(self, dt):
        cell = self.cell
        mixture.predict(self.record, self.scratch, self.settings, cell.walk, self.n, dt)
        step.pass_time(self.record, dt)
        mixture.combine(self.record, self.n)

    def correct(self, q, R):
        cell = self.cell
        step.expect(self.record, self.scratch, self.at, q, R)
        follow_noise(self.record, self.settings, q, R)
        step.orient(self.record, self.scratch, self.settings, self.at, self.n, cell.learnt, q, R)
        mixture.combine(self.record, self.n)

    def weigh(self, u, contacts=3):
        cell, first = self.cell, self.at[BIAS]
        if contacts == 0 and first >= 0:
            free.hang(
                self.record, self.scratch, self.settings, self.scalars, self.at, self.n,
                cell.learnt, u, cell.wrench_noise, cell.bias_map, cell.walk[first : first + 6],
            )  # fmt: skip
        else:
            self.state.air[:] = 0.0
        step.weigh(
            self.record, self.scratch, self.settings, self.scalars, self.at, self.n, cell.learnt,
            u, cell.wrench_noise, cell.bias_map, contacts,
        )  # fmt: skip

    @property
    def mean(self):
        return self.state.mean

    @property
    def covariance(self):
        return self.state.covariance

    @property
    def weight(self):
        return self.state.weight.reshape(len(self.state.alive), -1)


def stated(cell):
    """Return what both are started with beside an orientation."""
    values = [v for name in QUANTITIES if name in cell.open_quantities for v in STATED[name]]
    scene = cell.scene
    mean = np.zeros(cell.n - OPEN)
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

    Means over standard deviations, covariances over both standard deviations, and weights.
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
                np.abs(compiled.weight - reference.weight).max(),
            ]
        )
    return np.array(found)


def with_scene(truth, **scene):
    """Return the scene of a truth, changed."""
    return replace(truth.plan.configuration.scene, **scene)
