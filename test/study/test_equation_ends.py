"""Where the equations end: wedging as published, and steps beside an integrator of scipy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.mechanics.reference import solve_contact
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.study.equation_ends import MOST_FRICTION, wedging
from peg_on_hole_ros.study.fixed_steps import (
    EULER,
    LASTS,
    ROSENBROCK,
    RUNGE_KUTTA,
    angles_of,
    longest_steps,
)
from peg_on_hole_ros.study.map_places import USUAL, truth_at

# The paper's scene: 50 mm, 0.1 mm of clearance, friction 0.2.
PAPER = Scene(peg_diameter=0.0499, hole_diameter=0.05, friction=0.2)
SHARP = 1e-5


@pytest.fixture(scope="module")
def usual():
    return truth_at(USUAL, Configuration())


def wedged(motion, friction):
    """Return the first and the last tilt at which a motion wedges with a friction."""
    found = wedging(PAPER, motion)
    tilts = found.tilt[found.friction <= friction]
    return (tilts[0], tilts[-1]) if len(tilts) else None


def test_wedging_is_where_the_determinant_is_known_to_vanish():
    # Tilts are 2 % apart.
    low, high = wedged("closing", 0.2)
    assert low == pytest.approx(PAPER.gamma0, rel=1e-3)
    assert high == pytest.approx(0.0652, rel=0.02)
    assert wedged("opening", 0.2) == pytest.approx((0.11, 0.165), rel=0.04)


@pytest.mark.parametrize("motion", ["closing with spin", "turning about the hole's axis"])
def test_slip_across_takes_wedging_away(motion):
    assert wedged(motion, MOST_FRICTION) is None


def test_an_integration_is_that_of_scipy(usual):
    """Radau with the equations of the readable reference, beside Rosenbrock in short steps."""
    scene = usual.plan.configuration.scene
    # A fifth of it: the reference takes some 0.2 ms for each of the thousands of states.
    count = 1 + round(LASTS * usual.plan.wrench_rate) // 5
    times = np.arange(count) / usual.plan.wrench_rate
    loads = np.hstack([usual.force, usual.moment])

    def rate(t, state):
        load = np.array([np.interp(t, times, loads[:count, k]) for k in range(6)])
        found = solve_contact(scene, state[:3], state[3:], load[:3], load[3:], SHARP)
        return np.hstack([state[3:], found.acceleration])

    start = np.hstack([usual.q[0], usual.rates[0]])
    exact = solve_ivp(
        rate, (0.0, times[-1]), start, method="Radau", t_eval=times, rtol=1e-8, atol=1e-10
    )
    found = angles_of(usual, ROSENBROCK, SHARP, 64)[:count]
    # The order is 2: in steps of 16 us angles are within some 1e-7 of their way of 0.06 rad.
    assert np.abs(found - exact.y[:3].T).max() < 1e-7


def test_explicit_steps_lose_sharp_friction_and_implicit_ones_do_not(usual):
    sharp = longest_steps(usual, SHARP)
    sample = 1.0 / usual.plan.wrench_rate
    # Explicit steps of any order are bounded by the stiffness, not by the motion.
    assert sharp.longest[EULER] < sample / 16
    assert sharp.longest[RUNGE_KUTTA] < sample / 16
    assert sharp.longest[ROSENBROCK] >= sample / 4


def test_a_law_that_lets_long_steps_live_is_another_law(usual):
    sharp, smooth = longest_steps(usual, SHARP), longest_steps(usual, 1e-3)
    assert smooth.longest[RUNGE_KUTTA] > 1.5 * sharp.longest[RUNGE_KUTTA]
    assert smooth.law_off > 0.1 > 2 * sharp.law_off
