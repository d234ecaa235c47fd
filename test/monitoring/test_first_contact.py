"""A contact that would pull soon after the peg was set down: friction is stated too high."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from peg_on_hole_ros.estimation.filters.contact import ContactFilter
from peg_on_hole_ros.estimation.filters.square_root import SquareRootFilter
from peg_on_hole_ros.monitoring.first_contact import SETTLED, FirstContact

from grid_cells import Motion, truth_of, with_noise
from peg_on_hole_ros.mechanics.reference import solve_contact
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.options import FilterOptions
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.simulation.measure import measure


@cache
def closing():
    return with_noise(truth_of(Motion(1e-4, 0.05, 1.0, "align"))[0], "low", 0.05)


def told(coefficient, **filter_options):
    configuration = closing().plan.configuration
    return replace(
        configuration,
        scene=replace(configuration.scene, friction=coefficient),
        filter=replace(configuration.filter, **filter_options),
    )


# Beyond some friction more of it holds a peg less: from there the estimate ran to where K pulls.
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_friction_stated_far_too_high_opens_no_contact(seed, monkeypatch):
    def run():
        pipeline = Pipeline(told(0.2))
        modes = [outputs.contact_mode for outputs in pipeline.play(measure(closing(), seed))]
        return pipeline, modes

    pipeline, modes = run()
    assert pipeline.counts["friction_sought"] == 1
    # After the restart the rates and the mode are told within some 20 ms.
    assert set(modes[60:]) == {"three_point"}
    friction, stddev = pipeline.filter.friction
    assert abs(friction - 0.05) < 3 * stddev < 0.002
    monkeypatch.setattr(FirstContact, "update", lambda *arguments: None)
    pipeline, modes = run()
    assert not pipeline.counts["friction_sought"] and modes[60:].count("unknown") > 40


def test_a_friction_that_is_not_learnt_is_not_sought():
    pipeline = Pipeline(told(0.165, friction="considered"))
    for _ in pipeline.play(measure(closing(), 0)):
        pass
    assert not pipeline.counts["friction_sought"]
    # It may wander meanwhile.
    assert pipeline.filter.friction == pytest.approx((0.165, 0.05), abs=1e-5)


def test_one_motion_fits_two_frictions_and_a_contact_pulls_by_the_greater():
    truth = closing()
    scene = truth.plan.configuration.scene
    k = 80
    # The loads on a peg that moves so, and what other frictions make of them.
    frictions = np.linspace(0.02, 0.5, 97)
    found = [
        solve_contact(
            replace(scene, friction=float(friction)), truth.q[k], truth.rates[k],
            truth.force[k], truth.moment[k], 5e-6,
        )
        for friction in frictions
    ]  # fmt: skip
    braking = np.array([solution.acceleration[0] for solution in found])
    most = int(np.argmax(braking))
    assert 0 < most < len(frictions) - 1
    assert (np.diff(braking[: most + 1]) > 0).all() and (np.diff(braking[most:]) < 0).all()
    near = int(np.argmin(abs(frictions - scene.friction)))
    other = most + int(np.argmin(abs(braking[most:] - braking[near])))
    assert other < len(frictions) - 1
    assert found[other].normal.min() < 0 < found[near].normal.min()


@pytest.mark.parametrize("method", [ContactFilter, SquareRootFilter])
def test_a_friction_that_is_sought_begins_low_and_open(method):
    scene = Scene(friction=0.3, friction_stddev=0.05, clearance_stddev=2e-6)
    kalman = method(scene, FilterOptions(), np.eye(6))
    kalman.start(np.array([0.1, 0.2, 0.3]), 1e-6 * np.eye(3))
    assert kalman.friction_is_open
    kalman.spread[0, 0] = 0.49 * 0.05**2
    assert not kalman.friction_is_open
    q = np.array([0.11, 0.2, 0.3])
    kalman.seek_friction(q, 4e-6 * np.eye(3))
    assert kalman.friction == pytest.approx((0.2, 0.05)) and kalman.friction_is_open
    assert (kalman.x[:3] == q).all() and not kalman.x[3:].any()
    assert kalman.P[0, 0] == pytest.approx(4e-6)
    if method is SquareRootFilter:
        np.testing.assert_allclose(
            kalman._root @ kalman._root.T, kalman.joint_covariance(), atol=1e-18
        )
    known = method(Scene(friction_stddev=0.0), FilterOptions(), np.eye(6))
    known.start(q, 1e-6 * np.eye(3))
    assert not known.friction_is_open


def seen(*samples):
    watch = FirstContact()
    for sample in samples:
        watch.update(*sample)
    return watch


def test_a_contact_that_would_pull_at_first_says_that_friction_seems_high():
    watch = seen((0.0, "unknown", 0.2, True), (0.01, "unknown", 0.6, True))
    assert watch.friction_seems_high
    watch.sought()
    assert not watch.friction_seems_high
    # Once is enough.
    watch.update(0.02, "unknown", 0.9, True)
    assert not watch.friction_seems_high
    # Not so for a peg that is set down again.
    watch.update(0.5, "open", 0.0, True)
    watch.update(0.6, "unknown", 0.9, True)
    assert watch.friction_seems_high


def test_a_peg_that_has_settled_opens_contacts():
    early = (0.01, "three_point", 0.1, True)
    assert seen(early, (0.01 + 0.9 * SETTLED, "unknown", 0.6, True)).friction_seems_high
    assert not seen(early, (0.01 + 1.1 * SETTLED, "unknown", 0.6, True)).friction_seems_high


def test_a_friction_that_was_learnt_is_not_stated_too_high():
    assert not seen(
        (0.01, "unknown", 0.1, False), (0.02, "unknown", 0.6, True)
    ).friction_seems_high
