"""Integrators of the study: measured orders, the stiff limit of friction, and the yardsticks."""

import numpy as np
import pytest
from peg_on_hole_ros.study.steps import METHODS

from peg_on_hole_ros.mechanics.reference import solve_contact
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.study import problems, regularisation

SCENE = Scene()
STATE = np.array([0.3, 0.1, 0.2, -0.3, 0.2, 2.0])
# Friction smooth enough that the steps resolve it: order is a limit for small steps.
SMOOTH, DURATION = 1e-2, 0.05
ORDERS = {
    "explicit Euler": 1,
    "semi-implicit Euler": 1,
    "RK4": 4,
    "linearly implicit Euler": 1,
    "ROS2": 2,
    "ROS3P": 3,
    "implicit Euler": 1,
    "implicit Euler, halved": 1,
}


@pytest.fixture(scope="module")
def smooth():
    """A motion with a reversal under a wrench that changes in time, and its end."""
    wrench = problems.balancing_wrench(SCENE, STATE, (20, 20, 20), scale=SMOOTH)
    problem = problems.held(SCENE, STATE, wrench, DURATION, SMOOTH)
    slope = np.array([30.0, -20.0, 40.0, 1.0, 0.5, -2.0])
    coefficients = np.stack([wrench, slope, 5 * slope, 30 * slope])[None]
    problem = problem._replace(coefficients=coefficients, interval=DURATION)
    return problem, problems.by_scipy(problem, "Radau", 1e-12).state


@pytest.mark.parametrize("method", METHODS)
def test_order_of_convergence_is_the_methods_own(smooth, method):
    problem, end = smooth
    errors = []
    for steps in (80, 160, 320):
        solution = problems.solve(problem, method, DURATION / steps)
        errors.append(np.abs(solution.state - end).max())
    measured = np.log2(np.divide(errors[:-1], errors[1:]))
    # The next term of the expansion is some 15 % at 80 steps, and halves at each refinement; a
    # wrong order is off by 1.
    assert measured == pytest.approx(ORDERS[method], abs=0.25)
    assert abs(measured[1] - ORDERS[method]) < 0.2


def test_rosenbrock_loses_its_order_without_the_wrench_in_time(smooth):
    # Guards the term with the wrench's rate: a problem whose wrench is held has none to find.
    problem, end = smooth
    coarse = problem._replace(coefficients=problem.coefficients * [[[1], [0], [0], [0]]])
    moved = problems.solve(coarse, "ROS2", DURATION / 160).state
    assert (
        np.abs(moved - end).max()
        > 100 * np.abs(problems.solve(problem, "ROS2", DURATION / 160).state - end).max()
    )


@pytest.mark.parametrize("name, rtol", [("LSODA", 1e-8), ("DOP853", 1e-8), ("Radau", 1e-8)])
def test_yardsticks_agree(smooth, name, rtol):
    problem, end = smooth
    found = problems.by_scipy(problem, name, rtol)
    # Their tolerance is per step; rates are of the order of 1.
    np.testing.assert_allclose(found.state, end, atol=100 * rtol)


def test_balancing_wrench_gives_what_was_asked_for():
    normal, acceleration = (12.0, 7.0, 9.0), (3.0, -2.0, 5.0)
    wrench = problems.balancing_wrench(SCENE, STATE, normal, acceleration)
    from peg_on_hole_ros.mechanics.reference import peg_axes

    R = peg_axes(STATE[:3])
    found = solve_contact(SCENE, STATE[:3], STATE[3:], R @ wrench[:3], R @ wrench[3:])
    np.testing.assert_allclose(found.normal, normal, rtol=1e-9)
    np.testing.assert_allclose(found.acceleration, acceleration, rtol=1e-8)


@pytest.fixture(scope="module")
def effects():
    scales = (1e-6, 1e-5, 1e-4, 1e-3)
    return regularisation.effects(Configuration(), scales)


def test_stiff_limit_of_friction(effects):
    # The rate of the linearised motion goes as one over the scale.
    rates = [effect.stiffness * effect.scale for effect in effects]
    assert rates == pytest.approx([rates[0]] * 4, rel=0.15)
    assert effects[0].stiffness > 5e5
    # A stopped peg: implicit Euler gets better with the scale, at no more solutions a step.
    implicit = [effect.implicit_error for effect in effects]
    assert implicit == sorted(implicit) and implicit[0] < 1e-6
    assert effects[0].evaluations_per_step < 1.5 * effects[-1].evaluations_per_step
    # One Newton iteration overshoots the kink into a wrong speed, explicit steps never settle.
    assert effects[0].linearly_implicit_error > 1000 * implicit[0]
    assert effects[0].explicit_error > 1e5 * implicit[0]
    # Where friction is smooth on the scale of the step they are all alike.
    assert effects[-1].explicit_error == pytest.approx(implicit[-1], rel=0.5)


def test_default_velocity_scale_is_justified(effects):
    configuration = Configuration()
    default = configuration.filter.slip_velocity_scale
    (at_default,) = regularisation.effects(configuration, (default,))
    # What it spoils stays below what is measured: a stop within one standard deviation of an
    # orientation, the slowest sliding reaction to 1 %, far below its 2 to 5 % of noise.
    assert at_default.stop_angle_error < configuration.joints.position_stddev
    assert at_default.slow_reaction_error < 0.01
    # Five times more would not.
    (five,) = regularisation.effects(configuration, (5 * default,))
    assert five.stop_angle_error > configuration.joints.position_stddev
    # Ten times less gains nothing that is seen, and fails the cheaper linearly implicit step.
    (tenth,) = regularisation.effects(configuration, (default / 10,))
    assert at_default.linearly_implicit_error < 1e-5 < 1e-2 < tenth.linearly_implicit_error
