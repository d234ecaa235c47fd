"""After a reset a pipeline is a new one, and what a gate refuses leaves nothing behind."""

from dataclasses import replace
from functools import cache
from itertools import islice

import numpy as np
import pytest

from benchmarks.grid.cells import Motion, first_samples, truth_of, with_noise
from benchmarks.harness.errors import run_seeds
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.estimator.methods.registry import METHODS
from peg_on_hole_ros.records import JointSample
from peg_on_hole_ros.sim.measure import measure
from peg_on_hole_ros.study import scenes
from tiers import at_push


@cache
def reversing():
    """Return a peg that closes with reversals."""
    case = next(case for case in scenes.CASES if case.name == "reversals")
    return scenes.truth_of(case, Configuration())


def sliding(count=300, seed=3):
    """Return the configuration and the first samples of a peg that closes with reversals."""
    truth = reversing()
    return truth.plan.configuration, list(islice(measure(truth, seed), count))


def numbers(pipeline, samples):
    return [
        np.concatenate([o.state, o.state_covariance.ravel(), o.normal, o.normal_stddev])
        for o in pipeline.play(samples)
    ]


@pytest.mark.parametrize(
    ("method", "offsets"),
    [
        pytest.param("mixture", False, marks=pytest.mark.nightly),
        ("mixture", True),
        pytest.param("quasi_static", False, marks=pytest.mark.nightly),
    ],
)
def test_after_a_reset_the_same_samples_give_the_same_numbers(method, offsets):
    configuration, samples = sliding()
    options = replace(configuration.filter, method=method)
    configuration = replace(configuration, filter=options)
    if offsets:
        wrench = replace(configuration.wrench, bias_force_stddev=0.5)
        configuration = replace(configuration, wrench=wrench)
    pipeline = Pipeline(configuration)
    expected = numbers(pipeline, samples)
    pipeline.reset()
    found = numbers(pipeline, samples)
    assert len(found) == len(expected) > 100
    np.testing.assert_array_equal(found, expected)


def test_what_waits_at_a_reset_is_counted_and_no_stamp_is_told_of_twice():
    configuration, samples = sliding(60)
    pipeline = Pipeline(configuration)
    numbers(pipeline, samples)
    last = [each for each in samples if not isinstance(each, JointSample)][-1]
    ahead = [each for each in samples if isinstance(each, JointSample)][-1]
    for k in range(1, 4):
        pipeline.on_joints(ahead._replace(t_ns=last.t_ns + k * 10**6))
    pipeline.reset()
    assert pipeline.counts["joints_dropped_restart"] == 3
    pipeline.on_joints(ahead._replace(t_ns=last.t_ns))
    assert pipeline.on_wrench(last) is None
    assert pipeline.counts["wrench_dropped_repeated_stamp"] == 1
    assert pipeline.on_wrench(last._replace(t_ns=last.t_ns + 10**6)) is not None


@pytest.mark.parametrize("method", at_push(["mixture"], METHODS))
def test_an_outlier_is_refused_and_leaves_nothing_behind(method):
    """It was let in, by rates that were widened until it fitted: psi 600 deviations off."""
    configuration, samples = sliding()
    configuration = replace(configuration, filter=replace(configuration.filter, method=method))
    plain, struck = Pipeline(configuration), Pipeline(configuration)
    place = [i for i, each in enumerate(samples) if isinstance(each, JointSample)][-40]
    gamma, psi, phi = samples[place].position
    moved = samples[place]._replace(position=(gamma, psi + 0.5, phi))
    without, gone = samples[:place] + samples[place + 1 :], samples[:place]
    numbers(plain, gone), numbers(struck, gone)
    expected = numbers(plain, without[place:])
    found = numbers(struck, [moved, *without[place:]])
    assert struck.counts["joints_gated"] == plain.counts["joints_gated"] + 1
    np.testing.assert_array_equal(found[0][:6], expected[0][:6])
    # A walk of bridged rates may have followed the surprise; reactions stay as well known.
    ratio = np.array([row[-3:] for row in found]) / [row[-3:] for row in expected]
    assert ratio.max() < 1.5


def test_outliers_in_a_row_are_no_jump():
    """As far off as a motion may jump, but not the same way."""
    configuration, samples = sliding()
    plain, struck = Pipeline(configuration), Pipeline(configuration)
    places = [i for i, each in enumerate(samples) if isinstance(each, JointSample)][-40:-38]
    moved = list(samples)
    for i, off in zip(places, [(0.004, -0.002, 0.003), (-0.005, 0.003, 0.002)]):
        moved[i] = samples[i]._replace(position=tuple(np.add(samples[i].position[:3], off)))
    expected = list(plain.play(each for i, each in enumerate(samples) if i not in places))
    found = list(struck.play(moved))
    assert struck.counts["joints_gated"] == 2 and struck.counts["filter_restarted"] == 0
    spread = np.sqrt(np.diagonal(expected[-1].state_covariance))
    assert np.all(np.abs(found[-1].state - expected[-1].state) < 0.5 * spread)


@pytest.mark.parametrize(
    ("motion", "noise"),
    [
        pytest.param(Motion(1e-4, 0.5, 1.0, "reversals"), "low", marks=pytest.mark.nightly),
        pytest.param(Motion(1e-4, 0.5, 0.16, "reversals"), "low", marks=pytest.mark.nightly),
        pytest.param(Motion(2e-5, 0.5, 1.0, "reversals"), "high", marks=pytest.mark.nightly),
        (Motion(2e-3, 0.5, 1.0, "reversals"), "low"),
    ],
    ids=str,
)
def test_a_motion_that_friction_turns_round_is_followed_without_a_restart(motion, noise):
    """Slips come to rest, and accelerations jump by hundreds of rad/s^2 between two wrenches."""
    truth = with_noise(truth_of(motion)[0], noise, 0.05)
    runs = run_seeds(truth, range(660_000, 660_004))
    assert runs.restarts == 0
    off = np.sqrt(np.nanmean(runs.error[:, 50:, 6:] ** 2, axis=(0, 1)))
    assert (off < 0.1 * truth.normal[50:].mean(axis=0)).all()


def test_where_all_orientations_are_far_the_filter_begins_anew_with_its_mode():
    """Another zero of psi, by a radian: the wrench, in the axes of the peg, is the same."""
    configuration, samples = sliding()
    pipeline = Pipeline(configuration)
    place = [i for i, each in enumerate(samples) if isinstance(each, JointSample)][-40]
    before = list(pipeline.play(samples[:place]))
    assert before[-1].contact_mode == "three_point"
    restarted, found = [], []
    for each in samples[place:]:
        if isinstance(each, JointSample):
            gamma, psi, phi = each.position
            each = each._replace(position=(gamma, psi + 1.0, phi))
        found += pipeline.play([each])
        restarted.append(pipeline.counts["filter_restarted"])
    # Once: from then on they are where they are foreseen.
    assert restarted[-1] == 1
    assert pipeline.counts["joints_gated"] == configuration.filter.gate_reset_count
    states = np.array([outputs.state for outputs in found])
    (begin,) = np.flatnonzero(np.diff(states[:, 1]) > 0.5)
    assert np.abs(states[: begin + 1, 1] - before[-1].state[1]).max() < 0.1
    told = [outputs.contact_mode for outputs in found]
    assert set(told[: begin + 1]) == {"three_point"}
    assert told[begin + 1] == "unknown" and told[-1] == "three_point"


@pytest.mark.nightly
def test_rates_that_are_known_wrongly_are_followed_again_without_a_restart():
    """The noise of a wrench has stopped the peg, within a step that was believed."""
    truth = with_noise(truth_of(Motion(2e-3, 0.2, 0.01, "slip"))[0], "low", 0.05)
    runs = run_seeds(first_samples(truth, 300), [40_028])
    assert runs.restarts == 0
    # Restarted, the mode is unknown for 20 ms, and reactions are not told.
    assert runs.contact[0, 216:].all()
