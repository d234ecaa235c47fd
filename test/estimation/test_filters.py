"""The filters on one interface agree where the motion is nearly linear; the smoother is better."""

from dataclasses import replace
from itertools import takewhile

import numpy as np
import pytest
from peg_on_hole_ros.estimation.filters.contact import Correction, Prediction
from peg_on_hole_ros.estimation.filters.methods import FILTERS
from peg_on_hole_ros.estimation.filters.smoother import SmoothingFilter

from late_samples import ordered, shuffled
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.records import JointSample
from peg_on_hole_ros.simulation.measure import START_NS, measure
from simulated import truth
from sliding_filter import SCENE as SLIDING
from sliding_filter import WRENCH_NOISE, balanced

SCENE = "closing_with_slip"
SECONDS = 0.25


# Friction learnt as by default and the clearance considered, both learnt, both known.
PARAMETERS = {
    "default": {"clearance_stddev": 2e-6},
    "learnt": {"clearance_stddev": 2e-6},
    "known": {"friction_stddev": 0.0},
}


def run(method, parameters="default", make=None, seed=11, samples=None):
    """Return the pipeline and its outputs over steady sliding."""
    configuration = truth(SCENE).plan.configuration
    scene = replace(configuration.scene, **PARAMETERS[parameters])
    clearance = "estimated" if parameters == "learnt" else "considered"
    options = replace(configuration.filter, method=method, clearance=clearance)
    more = {} if make is None else {"make": make}
    pipeline = Pipeline(replace(configuration, scene=scene, filter=options), **more)
    if samples is None:
        measured = measure(truth(SCENE), seed)
        samples = takewhile(lambda sample: sample.t_ns - START_NS <= SECONDS * 1e9, measured)
    return pipeline, list(pipeline.play(samples))


@pytest.fixture(scope="module")
def extended():
    return {parameters: run("extended", parameters)[1] for parameters in PARAMETERS}


def differences(outputs, extended, settled=100):
    """Return states in standard deviations, ratio of these, reactions in theirs, once settled."""
    states, ratios, reactions = [], [], []
    for found, expected in list(zip(outputs, extended, strict=True))[settled:]:
        assert found.t_ns == expected.t_ns
        stddev = np.sqrt(np.diagonal(expected.state_covariance))
        states.append((found.state - expected.state) / stddev)
        ratios.append(np.sqrt(np.diagonal(found.state_covariance)) / stddev)
        reactions.append((found.normal - expected.normal) / expected.normal_stddev)
    return np.array(states), np.array(ratios), np.array(reactions)


@pytest.mark.parametrize("parameters", list(PARAMETERS))
def test_square_root_is_the_extended_filter_to_rounding(extended, parameters):
    pipeline, outputs = run("square_root", parameters)
    states, ratios, reactions = differences(outputs, extended[parameters])
    # Some 1e-16 times the condition of the joint covariance, over 250 steps.
    assert np.abs(states).max() < 1e-6
    assert np.abs(ratios - 1).max() < 1e-6
    assert np.abs(reactions).max() < 1e-6
    monitor, expected = outputs[-1].monitor, extended[parameters][-1].monitor
    for name in ("friction", "friction_stddev"):
        assert monitor[name] == pytest.approx(expected[name], rel=1e-7)
    learnt = pipeline.filter.peg_diameter[0] != pipeline.scene.peg_diameter
    assert learnt == (parameters == "learnt")


# In sliding a standard deviation of the rates turns friction little. The unscented filter averages
# over that, while the iterated one takes its slopes at what each measurement says. Where friction
# and clearance are far from known they do differ, by up to 1.5 standard deviations: these are
# learnt within the first 50 to 100 ms of sliding.
@pytest.mark.parametrize("parameters", list(PARAMETERS))
@pytest.mark.parametrize("method, bound", [("iterated", 0.1), ("unscented", 0.02)])
def test_filters_agree_on_a_nearly_linear_stretch(extended, method, bound, parameters):
    pipeline, outputs = run(method, parameters)
    settled = {"known": 100, "default": 160, "learnt": 200}[parameters]
    states, ratios, reactions = differences(outputs, extended[parameters], settled)
    assert np.abs(states).max() > 1e-9, "the method is not the extended filter"
    near, alike = 0.1, 0.01
    if (method, parameters) == ("unscented", "learnt"):
        # The extended filter then has its tangents at the mean rates of late, not at those of now
        # that sigma points lie about.
        near, alike, bound = 0.2, 0.02, 0.15
    assert np.abs(states).max() < near
    assert np.abs(ratios - 1).max() < bound
    assert np.abs(ratios.mean(axis=0) - 1).max() < alike
    assert np.abs(reactions).max() < near
    found, expected = outputs[-1].monitor, extended[parameters][-1].monitor
    assert abs(found["friction"] - expected["friction"]) <= near * expected["friction_stddev"]
    assert found["friction_stddev"] == pytest.approx(expected["friction_stddev"], rel=0.05)


@pytest.mark.parametrize("method", list(FILTERS))
def test_every_filter_goes_back_to_the_bit(method):
    samples = ordered(120)
    first, _ = run(method, samples=samples)
    second, _ = run(method, samples=shuffled(samples, 10_000_000))
    assert second.counts["went_back"] > 3
    np.testing.assert_array_equal(second.filter.x, first.filter.x)
    np.testing.assert_array_equal(second.filter.Z, first.filter.Z)


@pytest.mark.parametrize("method", list(FILTERS))
def test_every_filter_widens_gates_and_restarts(method):
    pipeline, _ = run(method)
    kalman, x = pipeline.filter, pipeline.filter.x.copy()
    R = 1e-8 * np.eye(3)
    before = kalman.Z.copy()
    kalman.predict(1e-3, True)
    result, nis = kalman.correct(x[:3] + [6e-4, 0, 0], R)
    assert result is Correction.INFLATED and nis > 14
    assert kalman.Z[3, 3] > 0.5 * before[3, 3] and np.linalg.eigvalsh(kalman.P)[0] > 0
    kalman.options = replace(kalman.options, inflation_threshold=1e12)
    for expected in (Correction.GATED, Correction.GATED, Correction.RESET):
        kalman.predict(1e-3, False)
        result, _ = kalman.correct(x[:3] + [0.5, 0, 0], R)
        assert result is expected
    assert np.isfinite(kalman.Z).all() and kalman.x[0] == x[0] + 0.5


@pytest.mark.parametrize("method", list(FILTERS))
def test_no_innovation_below_what_is_expected_narrows_the_rates(method):
    def rates(threshold):
        pipeline, _ = run(method, samples=ordered(60))
        kalman, x = pipeline.filter, pipeline.filter.x.copy()
        kalman.options = replace(kalman.options, inflation_threshold=threshold)
        kalman.predict(1e-3, False)
        result, nis = kalman.correct(x[:3] + 1e-3 * x[3:] + [1.8e-4, 0, 0], 1e-8 * np.eye(3))
        assert result is Correction.USED and 1.0 < nis < 3.0
        return kalman.P.copy()

    # It was used with variances of a third and more of what they were.
    np.testing.assert_array_equal(rates(1.0), rates(14.0))


@pytest.mark.parametrize("method", list(FILTERS))
def test_a_covariance_that_is_lost_takes_nothing_of_what_follows(method):
    pipeline, _ = run(method)
    kalman = pipeline.filter
    for place in (kalman.Z, kalman.spread, kalman.scene_values[7:8]):
        place[:] = np.nan
    result, _ = kalman.correct(np.array([0.2, 0.0, 0.0]), 1e-8 * np.eye(3))
    assert result is Correction.RESET
    assert kalman.friction == (kalman.scalars.f, pytest.approx(0.05))
    kalman.predict(1e-3, True)
    result, nis = kalman.correct(np.array([0.2, 0.0, 0.0]), 1e-8 * np.eye(3))
    assert result is Correction.USED and nis < 1.0
    assert np.isfinite(kalman.joint_covariance()).all()


@pytest.mark.parametrize("method", list(FILTERS))
def test_friction_and_diameter_are_as_stated_before_there_is_any_motion(method):
    configuration = Configuration()
    scene = replace(configuration.scene, friction_stddev=0.03, clearance_stddev=1e-6)
    options = replace(configuration.filter, method=method)
    kalman = FILTERS[method](scene, options, np.eye(6))
    for _ in range(2):
        assert kalman.friction == pytest.approx((scene.friction, 0.03))
        assert kalman.peg_diameter == pytest.approx((scene.peg_diameter, 1e-6))
        # Nor does a wrench change that, or the begin of a motion.
        kalman.hold(np.ones(6))
        kalman.start(np.array([0.2, 0.1, -0.3]), 1e-8 * np.eye(3))


def test_the_smoother_forwards_is_the_extended_filter(extended):
    _, outputs = run("extended", make=SmoothingFilter)
    for found, expected in zip(outputs, extended["default"], strict=True):
        np.testing.assert_array_equal(found.state, expected.state)
        np.testing.assert_array_equal(found.state_covariance, expected.state_covariance)


def errors(t_ns, x):
    result = truth(SCENE)
    rows = np.searchsorted(result.t_ns, np.array(t_ns) - START_NS)
    error = np.hstack([x[:, :3] - result.q[rows], x[:, 3:] - result.rates[rows]])
    error[:, 1:3] -= 2 * np.pi * np.round(error[:, 1:3] / (2 * np.pi))
    return error


@pytest.mark.parametrize("parameters", ["default", "known"])
def test_smoothed_errors_are_as_small_as_their_covariance_says(parameters):
    squares, filtered, smoothed = [], [], []
    for seed in range(20, 32):
        pipeline, outputs = run("extended", parameters, SmoothingFilter, seed)
        t_ns, x, P = pipeline.filter.smooth()
        assert t_ns == [found.t_ns for found in outputs]
        error = errors(t_ns, x)
        squares.append(np.einsum("ni,nij,nj->n", error, np.linalg.inv(P), error)[20:-20])
        own = np.array([found.state for found in outputs])
        filtered.append(errors(t_ns, own)[20:-20])
        smoothed.append(error[20:-20])
        covariance = np.array([found.state_covariance for found in outputs])
        variance = np.diagonal(P, axis1=1, axis2=2)
        own = np.diagonal(covariance, axis1=1, axis2=2)
        # Rounding aside, a smoother never knows less.
        assert (variance <= own * (1 + 1e-6)).all()
        # At the end there is nothing more to know.
        np.testing.assert_allclose(variance[-1], own[-1], rtol=1e-9)
    nees = np.mean(squares)
    # 6 degrees of freedom; 12 seeds of some 20 independent stretches each, known to 4 %.
    assert 6 * 0.8 < nees < 6 * 1.2, nees
    ratio = np.sqrt(np.mean(np.square(smoothed), (0, 1)) / np.mean(np.square(filtered), (0, 1)))
    assert (ratio < 0.9).all(), ratio


def test_nothing_is_smoothed_across_a_restart():
    pipeline, _ = run("extended", make=SmoothingFilter)
    kalman = pipeline.filter
    _, before, P_before = kalman.smooth()
    kalman.start(np.array([0.3, 1.0, -1.0]), 1e-8 * np.eye(3))
    kalman.hold(kalman.u.copy())
    kalman.predict(1e-3, False)
    kalman.mark(1)
    _, x, P = kalman.smooth()
    np.testing.assert_array_equal(x[:-1], before)
    np.testing.assert_array_equal(P[:-1], P_before)
    assert x[-1][0] == pytest.approx(0.3, abs=1e-3)


def test_the_last_stamp_before_a_reset_keeps_what_is_known_there():
    """It was given the state that the filter begins anew with, some other time and place."""
    samples = ordered(240)
    pipeline, before = run("extended", make=SmoothingFilter, samples=samples[:180])
    assert pipeline.reset().success
    after = list(pipeline.play(samples[240:]))
    t_ns, x, P = pipeline.filter.smooth()
    assert t_ns == [found.t_ns for found in before + after]
    last = len(before) - 1
    # Nothing later tells of it, so that the filter's own is all there is, to rounding of turns.
    np.testing.assert_allclose(x[last], before[last].state, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(P[last], before[last].state_covariance)
    # What was before is smoothed up to there.
    error, own = errors(t_ns[50:last], x[50:last]), [found.state for found in before[50:last]]
    assert (np.std(error, 0) < np.std(errors(t_ns[50:last], np.array(own)), 0)).all()


def test_joint_states_that_correct_the_present_late_leave_covariances():
    """A widening after a first correction took that for a part of the prediction before it."""
    samples = list(takewhile(lambda s: s.t_ns - START_NS <= 0.3e9, measure(truth(SCENE), 11)))
    rng, configuration = np.random.default_rng(1), truth(SCENE).plan.configuration
    late = [
        s.t_ns + (rng.integers(0, 8_000_000) if isinstance(s, JointSample) else 0) for s in samples
    ]
    options = replace(configuration.filter, late_window=0.0, late_tolerance=0.02)
    pipeline = Pipeline(replace(configuration, filter=options), make=SmoothingFilter)
    outputs = list(pipeline.play(samples[i] for i in np.argsort(late, kind="stable")))
    assert pipeline.counts["joints_late"] > 30 and pipeline.counts["rates_widened"] > 1
    t_ns, x, P = pipeline.filter.smooth()
    scale = np.sqrt(np.diagonal(P, axis1=1, axis2=2))
    assert np.isfinite(scale).all() and (scale > 0).all()
    assert np.linalg.eigvalsh(P / (scale[:, :, None] * scale[:, None, :])).min() > 0.0
    own = errors(t_ns, np.array([found.state for found in outputs]))
    assert (np.std(errors(t_ns, x), 0) < np.std(own, 0)).all()


def test_friction_that_is_taken_for_another_tells_nothing_of_what_was_before():
    pipeline, _ = run("extended", make=SmoothingFilter)
    kalman = pipeline.filter
    _, x, P = kalman.smooth()
    assert np.abs(kalman.joint_covariance()[12, :6]).max() > 0.0
    kalman.take_friction(0.3, 0.05**2)
    # As if it had been learnt since, to a thousandth and elsewhere.
    kalman.scene_values[7], kalman.spread[0, 0] = 0.35, 1e-6
    _, again, P_again = kalman.smooth()
    np.testing.assert_allclose(again, x, rtol=1e-9)
    np.testing.assert_allclose(P_again, P, rtol=1e-6, atol=1e-20)


def test_an_unknown_method_is_refused_with_those_there_are():
    from peg_on_hole_ros.configuration import from_parameters

    with pytest.raises(PegOnHoleError, match="extended, iterated, unscented, square_root"):
        from_parameters({"filter.method": "particle"})


def test_a_covariance_that_is_singular_to_rounding_has_a_root():
    """It ended the square-root filter: angles at 1e-9 rad whose stamps are off by milliseconds."""
    rate = np.array([0.1, -0.7, 0.3])
    covariance = 1e-24 * np.eye(3) + 1e-4 * np.outer(rate, rate)
    with pytest.raises(np.linalg.LinAlgError):
        np.linalg.cholesky(covariance)
    configuration = Configuration()
    options = replace(configuration.filter, method="square_root")
    kalman = FILTERS["square_root"](configuration.scene, options, np.eye(6))
    kalman.start(np.array([0.2, 0.1, -0.3]), covariance)
    kalman.hold(np.zeros(6))
    kalman.predict(1e-3, in_contact=False)
    # The rates have made it regular.
    result, nis = kalman.correct(np.array([0.2, 0.1, -0.3]), covariance)
    assert result is Correction.USED and np.isfinite(nis) and np.isfinite(kalman.P).all()


def test_friction_walks_at_constant_rates_in_the_root_as_in_the_covariance():
    """With a model without inertia it stood still in the root."""
    found = {}
    for method in ("extended", "square_root"):
        options = replace(Configuration().filter, method=method, model="quasi_static")
        kalman = FILTERS[method](replace(SLIDING, friction_stddev=1e-3), options, WRENCH_NOISE)
        x = np.array([0.15, 0.3, -0.4, -0.16, 0.4, 2.0])
        kalman.start(x[:3], 1e-8 * np.eye(3))
        kalman.x[3:], kalman.Z[range(3, 6), range(3, 6)] = x[3:], 1e-6
        if method == "square_root":
            kalman._set_anew()
        kalman.hold(balanced(x))
        for _ in range(50):
            assert kalman.predict(1e-3, True) is Prediction.HELD
        found[method] = kalman.joint_covariance()
    walk = 50e-3 * options.friction_noise**2
    assert found["extended"][12, 12] == pytest.approx(1e-6 + walk, rel=1e-9)
    np.testing.assert_allclose(found["square_root"], found["extended"], rtol=1e-9, atol=1e-20)
