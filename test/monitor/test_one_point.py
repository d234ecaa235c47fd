"""Which of K and B carry a peg below gamma0: one alone is told from both by its load."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from insertions import inserted
from peg_on_hole_ros.config.options import Configuration, WrenchInput
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitor.one_point import absence, forget_points, weigh_points
from peg_on_hole_ros.monitor.tuned import ONE_POINT
from peg_on_hole_ros.sim.measure import START_NS, measure
from peg_on_hole_ros.typed_record import new
from two_points import samples, tilt_at

NAMES = ("mode_probability_K_alone", "mode_probability_B_alone", "mode_probability_two_point")


def shares_of(rows):
    """Return which share of *touches below gamma0* each of K and B alone has, NaN where untold."""
    K, B, both = np.array([[row.monitor.get(name, np.nan) for name in NAMES] for row in rows]).T
    return K / both, B / both


@pytest.mark.parametrize("stated", [0.75, 1.5])
@pytest.mark.parametrize("loads", [(30.0, 0.0), (0.0, 30.0), (30.0, 5.0), (5.0, 30.0)])
def test_one_that_carries_alone_is_told(loads, stated):
    scene = Scene(hole_diameter=0.050, peg_diameter=0.0499, friction=0.2)
    told = Configuration(
        scene=replace(scene, friction=stated * scene.friction),
        wrench=WrenchInput(sensor_xyz=(0.0, 0.0, 0.12)),
    )
    tilts = [tilt_at(scene, 0.0155 + 1e-5 * i) for i in range(300)]
    rows = list(Pipeline(told).play(samples(told, tilts, loads, scene.friction)))[100:]
    alone = {"K": loads[1] == 0.0, "B": loads[0] == 0.0}
    for share, is_alone in zip(shares_of(rows), alone.values(), strict=True):
        assert np.isfinite(share).all()
        # A contact without a load looks like one of the sensor's noise at times, and a friction
        # that is stated wrongly makes up a load of its own until it is learnt.
        told = share[-50:] > 0.5 if is_alone else share < 0.5
        assert np.mean(told) > 0.95


@pytest.mark.parametrize("kind", ["goes_on", "jams"])
def test_two_that_carry_are_not_told_as_one(kind):
    """The simulation's contacts give, and its loads come and go."""
    truth = inserted(kind)
    rows = list(Pipeline(truth.plan.configuration).play(measure(truth, 4)))
    at = np.searchsorted(truth.t_ns, [row.t_ns - START_NS for row in rows])
    K, B = shares_of(rows)
    told = np.isfinite(K)
    # Both stand for less than what is told as a touch.
    loads = np.column_stack([truth.normal[at, 0], truth.normal[at, 1:].sum(axis=1)])
    both = told & (loads.min(axis=1) > 1.0)
    assert both.sum() > 200
    assert np.mean((K + B)[both] < 0.5) > 0.98
    assert not told[truth.mode[at] == "open"].any()


@pytest.mark.parametrize(("normal", "stddev"), [(0.3, 0.5), (1.0, 0.4), (-0.2, 0.3), (-3.0, 0.5)])
def test_absence_is_the_ratio_of_likelihoods(normal, stddev):
    """By quadrature over what pushes, as wide as it may be before it is looked at."""
    wide = np.hypot(ONE_POINT.reaction, stddev)
    # What measured the reaction, freed of the prior that its posterior has in it.
    variance = 1.0 / (1.0 / stddev**2 - 1.0 / wide**2)
    measured = normal / stddev**2 * variance

    def joint(x):
        return 2.0 * norm.pdf(x, 0.0, wide) * norm.pdf(measured, x, np.sqrt(variance))

    pushes = quad(joint, 0.0, 20.0 * stddev, limit=200)[0]
    expected = np.log(norm.pdf(measured, 0.0, np.sqrt(variance)) / pushes)
    # A single piece of evidence is bounded; 2 % are the prior's curvature over the posterior.
    assert absence(normal, stddev**2) == pytest.approx(np.clip(expected, -3.0, 3.0), abs=0.02)


@pytest.mark.parametrize(("since", "share"), [(0.002, 0.1), (0.02, 1.0), (0.06, 1.0)])
def test_wrenches_within_one_correlation_time_are_one_piece_of_evidence(since, share):
    """Correlated for 0.02 s, a load at K of 4 N and none at B."""
    estimate, before = new(Estimate), np.zeros(3)
    estimate.reactions.normal[:] = 4.0, 0.1, 0.1
    estimate.reactions.covariance[:] = np.diag([0.5, 0.1, 0.1]) ** 2
    forget_points(before)
    after = before.copy()
    weigh_points(after, estimate, since, 0.0, 0.02)
    gained = np.log(after / before) - np.log(after / before)[2]
    of_B = absence(0.2, 2 * 0.1**2)
    assert of_B > 0.5
    assert gained[:2] == pytest.approx([share * of_B, share * absence(4.0, 0.25)], rel=1e-9)
    assert after.sum() == pytest.approx(1.0, rel=1e-12)
