"""The smoother with a lag: what is told later, by what comes until then alone."""

import numpy as np
import pytest

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.sim.measure import measure
from peg_on_hole_ros.study import runs, scenes
from peg_on_hole_ros.study.smoothed import LAG_NS, make_fixed_lag, make_smoothed

COUNT = 260


@pytest.fixture(scope="module")
def motion():
    truth = scenes.truth_of(scenes.CASES[0], Configuration())
    return scenes.first_samples(truth, COUNT)


@pytest.fixture(scope="module")
def smoothed(motion):
    configuration = runs.always_in_contact(motion.plan.configuration)
    pipeline = Pipeline(configuration, make=make_smoothed)
    for _ in pipeline.play(measure(motion, 1)):
        pass
    return pipeline.filter


def test_a_lag_beyond_the_recording_is_none(smoothed):
    whole, late = smoothed.smooth_all(), smoothed.smooth_all(10**9)
    for one, other in zip(whole, late):
        np.testing.assert_array_equal(one, other)


def test_it_is_between_the_estimate_and_the_whole_recording(smoothed, motion):
    """Of what comes later the most is told by the first tenths of a second."""
    t_ns, state, covariance = smoothed.smooth_all(LAG_NS)
    _, whole, least = smoothed.smooth_all()
    assert len(t_ns) == len(state) and np.isfinite(state).all()
    rates = slice(3, 6)
    own, best = (np.diagonal(each, axis1=1, axis2=2)[:, rates] for each in (covariance, least))
    # Never surer than the whole recording, but for rounding.
    assert (own > (1.0 - 1e-6) * best).all()
    # The last two stretches are told by all there is.
    last = np.flatnonzero(t_ns >= t_ns[0] + ((t_ns[-1] - t_ns[0]) // LAG_NS - 1) * LAG_NS)
    np.testing.assert_array_equal(state[last], whole[last])


def test_it_knows_rates_better_than_the_estimate(motion):
    configuration = runs.always_in_contact(motion.plan.configuration)
    samples = list(measure(motion, 1))
    late = runs.errors(motion, runs.run(configuration, samples, lambda: 0.0, make_fixed_lag))
    now = runs.errors(motion, runs.run(configuration, samples, lambda: 0.0))
    assert late.tilt_rate < 0.8 * now.tilt_rate and late.reactions_inside > 0.9
