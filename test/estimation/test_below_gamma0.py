"""Predictions that end where there are no three contacts: what is told of these are numbers."""

import numpy as np
import pytest
from peg_on_hole_ros.estimation.filters.contact import ContactFilter, Prediction
from peg_on_hole_ros.estimation.kernel.forces import contact_forces
from peg_on_hole_ros.estimation.kernel.memory import part
from peg_on_hole_ros.estimation.reference.kalman import ReferenceFilter
from peg_on_hole_ros.ladder.rungs import QUASI_STATIC

from peg_on_hole_ros.mechanics.kernel import scene_of
from peg_on_hole_ros.options import FilterOptions
from sliding_filter import SCENE, WRENCH_NOISE

SMALLEST = FilterOptions().slip_velocity_scale


def slow_filter(above, rates, **options):
    """Return a filter at a tilt above gamma0 [rad], at rates known to 0.1 rad/s."""
    found = ContactFilter(SCENE, FilterOptions(**options), WRENCH_NOISE)
    found.start(np.array([SCENE.gamma0 + above, 0.1, 0.2]), np.diag([1e-8, 1e-6, 1e-6]))
    found.x[3:6] = rates
    found.P[range(3, 6), range(3, 6)] = 1e-2
    return found


@pytest.mark.parametrize("above", [1e-5, -1e-5])
def test_scales_of_a_bridged_interval_that_ends_below_gamma0_are_the_smallest(above):
    kalman = slow_filter(above, [-0.05, 0.0, 0.0])
    kalman.hold(np.array([0.0, 0.0, -4.0, 0.0, 0.05, 0.0]))
    assert kalman.predict(1e-3, True) is Prediction.SLOW
    assert kalman.x[0] < SCENE.gamma0
    np.testing.assert_array_equal(part(kalman.memory, "SCALES"), SMALLEST)
    told = kalman.describe(False, 1.0)
    assert all(np.isfinite(each).all() for each in told)
    assert not told.contact_force.any()


def test_the_reference_filter_has_the_same_scales_there():
    kalman = slow_filter(1e-5, [-0.05, 0.0, 0.0])
    reference = ReferenceFilter(SCENE, kalman.process, WRENCH_NOISE)
    reference.x[:6], reference.P[:6, :6] = kalman.x, kalman.P
    u = np.array([0.0, 0.0, -4.0, 0.0, 0.05, 0.0])
    kalman.hold(u)
    reference.hold(u)
    kalman.predict(1e-3, True)
    reference.predict_slow(1e-3)
    np.testing.assert_allclose(reference.x[:6], kalman.x, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(reference.scales, part(kalman.memory, "SCALES"))


def test_so_are_those_of_a_model_that_goes_on_there():
    """The model is looked at once for each wrench; an orientation within may lie below gamma0."""
    kalman = slow_filter(1e-4, [0.0, 0.0, 3.0], model="quasi_static")
    kalman.P[range(3, 6), range(3, 6)] = 1e-6
    kalman.hold(np.array([0.0, 0.0, -4.0, 0.0, 0.05, 0.0]))
    assert kalman.predict(1e-3, True) is Prediction.HELD
    assert kalman.model.rung == QUASI_STATIC
    kalman.x[0] = SCENE.gamma0 - 1e-4
    kalman.predict(1e-3, True)
    np.testing.assert_array_equal(part(kalman.memory, "SCALES"), SMALLEST)
    assert all(np.isfinite(each).all() for each in kalman.describe(False, 1.0))


def test_what_carries_nothing_exerts_nothing_whatever_its_friction_would_be():
    kalman = slow_filter(0.05, [-0.1, 0.3, 0.5])
    part(kalman.memory, "SCALES")[:] = np.nan, np.nan, 1e-5
    out = np.r_[0.0, -0.0, 7.0, np.full(18, np.nan)]
    contact_forces(scene_of(kalman.memory), kalman.memory, SCENE.gamma0 + 0.05, out, 0, 3, 12)
    np.testing.assert_array_equal(out[3:9], 0.0)
    assert not np.signbit(out[3:9]).any()
    # Friction is Coulomb's.
    assert np.linalg.norm(out[9:12]) == pytest.approx(7.0 * np.hypot(1.0, SCENE.friction))
