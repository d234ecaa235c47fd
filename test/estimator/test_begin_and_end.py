"""What a start, an end, and measurements that tell nothing leave of an estimate."""

from dataclasses import replace

import numpy as np
import pytest

from compiled_beside import samples, with_scene
from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator import filter_steps
from peg_on_hole_ros.estimator.contact_filter import ContactFilter, Correction
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.hole_geometry import depth_at
from peg_on_hole_ros.mechanics.scene import Scene
from simulated import truth
from under_way import placed

Q, R = np.array([0.1, 0.2, -0.3]), np.diag([1e-8] * 3)


def held_peg(count=400, **scene):
    """Return the estimate of a peg whose scene is stated otherwise, and samples of it."""
    recording = truth("closing_with_slip")
    rows, noise = samples(recording, count=count)
    return ContactFilter(replace(with_scene(recording), **scene), FilterOptions(), noise), rows


def follow(peg, rows):
    """Start a peg from the first sample, and take the others."""
    peg.start(rows[0].q, rows[0].R)
    for before, row in zip(rows, rows[1:]):
        peg.predict(row.t - before.t)
        if row.q is not None:
            peg.correct(row.q, row.R)
        peg.weigh(row.u, ContactSet.THREE)


def test_a_start_stands_in_the_record_before_any_wrench():
    peg, _ = held_peg(1)
    peg.start(Q, R)
    assert peg.record.motion.gamma == pytest.approx(Q[0])
    assert peg.record.scene.gamma0 == pytest.approx(peg.scene.gamma0)


def test_an_orientation_that_cannot_be_compared_begins_the_motion_anew():
    peg, _ = held_peg(1)
    peg.start(Q, R)
    peg.state.mixture_covariance[:] = np.nan
    result, nis = peg.correct(Q + 0.01, R)
    assert result == Correction.RESET and np.isnan(nis)
    assert peg.x[:3] == pytest.approx(Q + 0.01)
    assert np.linalg.eigvalsh(peg.P).min() > 0.0


@pytest.mark.parametrize(("stddev", "kept"), [(0.1, True), (0.0, False)])
def test_a_friction_that_was_learnt_begins_the_next_motion(stddev, kept):
    true = truth("closing_with_slip").plan.configuration.scene.friction
    peg, rows = held_peg(friction=true + 0.08, friction_stddev=stddev)
    follow(peg, rows)
    learnt = peg.record.scene.f
    assert (abs(learnt - true) < 0.02) == kept
    peg.end_estimate()
    peg.start(Q, R)
    assert peg.record.scene.f == pytest.approx(learnt if kept else true + 0.08, rel=0.02)


@pytest.mark.parametrize("known", [True, False])
def test_a_measured_depth_corrects_nothing_where_the_clearance_is_known(known):
    scene = Scene() if known else replace(Scene(), clearance_stddev=1e-5)
    peg = placed([0.5 * scene.gamma0, 0.2, 0.1], (-0.05, 0.5, 0.2), scene)
    # As after a wrench that two points surely carry.
    state, n = peg.state, int(peg.places.reactions)
    state.contact_set = ContactSet.TWO
    state.mixture_mean[n : n + 3] = 100.0, 50.0, 50.0
    state.mixture_covariance[n : n + 3, n : n + 3] = np.eye(3)
    before = peg.state.tobytes()
    depth = depth_at(scene.peg_diameter, scene.hole_diameter, peg.x[0])[0]
    filter_steps.update_from_depth(peg.memory, depth, 1e-8, 1e-3)
    assert (peg.state.tobytes() == before) == known
