"""A peg that is exactly upright, leans to the other side, or whose angles are no orientation."""

from dataclasses import replace

import numpy as np
import pytest

from peg_on_hole_ros.config.options import Configuration, FilterOptions, JointInput, MonitorOptions
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.measurements.angles import angle_covariance
from peg_on_hole_ros.measurements.orientation import PegJoints
from peg_on_hole_ros.measurements.tuned import ANGLE_FLOOR
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.records import ANGLES, JointSample, WrenchSample
from under_way import placed, press

# Methods with fewer degrees of freedom take rates for known, and few particles may agree: their
# covariance has no inverse.
METHODS = (
    "mixture", "one_level", "dde_driven", "quasi_static", "balance", "small_angle", "unscented",
)  # fmt: skip


def outputs(position, method="mixture", modes=True, count=60):
    """Return the outputs of a pipeline that is given one orientation, and its counts."""
    configuration = replace(
        Configuration(),
        filter=FilterOptions(method=method),
        monitor=MonitorOptions(modes=modes),
    )
    pipeline, found = Pipeline(configuration), []
    for k in range(count):
        t_ns = 10**9 + k * 10**6
        pipeline.on_sample(JointSample(t_ns, ANGLES, position))
        found.append(pipeline.on_sample(WrenchSample(t_ns, (0.3, 0.0, -10.0), (0.0, 0.01, 0.0))))
    return [each for each in found if each is not None], pipeline.counts


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("modes", [True, False])
@pytest.mark.parametrize("gamma", [0.0, -0.0, 1e-300, 1e-9])
def test_upright_peg_is_estimated_by_every_filter(method, modes, gamma):
    # Drivers that have just started publish zeros.
    found, _ = outputs((gamma, 1.0, 2.0), method, modes)
    assert len(found) == 60
    for each in found:
        assert np.isfinite(each.state).all() and np.isfinite(each.state_covariance).all()
        assert np.linalg.eigvalsh(each.state_covariance).min() > 0.0
    assert found[-1].contact_mode == ("two_point" if modes else "unknown")


def test_tilt_below_zero_is_one_to_the_other_side():
    measured = PegJoints(JointInput())(JointSample(0, ANGLES, (-0.2, 0.4, 1.3)))
    assert measured.q[0] == 0.2
    np.testing.assert_allclose(peg_axes(measured.q), peg_axes((-0.2, 0.4, 1.3)), atol=1e-15)
    found, _ = outputs((-0.2, 0.4, 1.3))
    assert found[-1].contact_mode == "three_point"


@pytest.mark.parametrize(
    "position", [(2.0, 0, 0), (-1.6, 0, 0), (np.pi / 2, 0, 0), (0.2, 0, -1e300), (0.2, 2e6, 0)]
)
def test_angles_that_are_no_orientation_are_counted(position):
    found, counts = outputs(position, count=5)
    assert not found and counts["joints_dropped_out_of_range"] == 5


@pytest.mark.parametrize("gamma", [0.0, 1e-9, 1e-6, 1e-3, 0.3])
def test_sum_of_turns_is_known_at_any_tilt(gamma):
    # Of an upright peg psi and phi are nothing, and their sum is a rotation about the axis.
    covariance = angle_covariance(gamma, 1e-4)
    total = np.array([0.0, 1.0, 1.0])
    # Below the least sine an ulp of the cosine is 2e-4 of what it differs from 1 by.
    tolerance = 1e-3 if gamma <= ANGLE_FLOOR.least_sine else 1e-7
    expected = 2e-8 / (1 + np.cos(gamma))
    assert total @ covariance @ total == pytest.approx(expected, rel=tolerance)
    assert np.linalg.cholesky(covariance)[2, 2] > 0.0


@pytest.mark.parametrize("tilt", [1.55, 1.6, 3.0])
def test_the_record_of_a_peg_that_lies_contains_numbers(tilt):
    """Closed forms of three contacts end at pi/2; the steepest tilt they are used at is 1.5."""

    def recorded(gamma):
        estimate = placed([gamma, 0.3, 0.2], (-0.1, 0.2, 0.3))
        return press(estimate, [1.0, 0.0, -20.0, 0.0, 0.1, 0.0])

    lying, steepest = recorded(tilt), recorded(1.5)
    assert is_finite(lying)
    assert lying.determinant == pytest.approx(steepest.determinant, rel=1e-9)
    assert lying.friction_scales == pytest.approx(steepest.friction_scales, rel=1e-9)


def is_finite(record):
    """Return whether all numbers of a record are finite, but for its scratch."""
    return all(
        all(map(is_finite, np.atleast_1d(record[name])))
        if record.dtype[name].base.names
        else np.isfinite(record[name]).all()
        for name in record.dtype.names
        if name != "work"
    )
