"""Which contacts count as at rest, which of several motions is told first, how wide a range is."""

import numpy as np
import pytest

from peg_on_hole_ros.mechanics import reference
from peg_on_hole_ros.mechanics.free_body import free_body, wrench_of
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.mechanics.stick_slip import Motion, solve_stick_slip
from peg_on_hole_ros.mechanics.undetermined import Determination, reaction_ranges
from peg_on_hole_ros.mechanics.unilateral import Existence, solve_unilateral

SCENE = Scene()
WEIGHT = SCENE.peg_mass * 9.80665
CLOSING = np.array([-0.16, 0.0, 0.0])


def test_a_peg_of_which_one_contact_rests_still_moves():
    # K is at rest where D psi' + d phi' = 0 and gamma' = 0; B1 and B2 slide.
    q, rates = [0.3, 0, 0], np.array([0.0, 1.0, -SCENE.hole_diameter / SCENE.peg_diameter])
    force = np.array([-5.0, 1.0, -10.0])
    found = solve_stick_slip(SCENE, q, rates, force, np.zeros(3))
    assert found.converged and Motion.OPENS not in found.motion
    assert np.linalg.norm(found.acceleration[:3]) > 1.0
    # The reactions of that motion, which accelerates, are among those that are possible.
    body = free_body(SCENE, q, rates, force, np.zeros(3))
    normal = np.einsum("ic,ic->i", found.reaction, body.normals)
    ranges = reaction_ranges(SCENE, q, rates, force, np.zeros(3))
    assert ranges.determination is not Determination.IMPOSSIBLE
    assert np.all(ranges.low - 1e-6 * WEIGHT <= normal)
    assert np.all(normal <= ranges.high + 1e-6 * WEIGHT)


def test_a_tolerance_widens_the_range_by_all_that_forces_and_moments_may_be_off():
    q, rates, tolerance = np.array([0.12, 0, 0]), CLOSING + [0, 0.3, 2.0], 0.05
    force = np.array([0.0, 0.0, -20.0])

    def normal(load):
        return reference.solve_contact(SCENE, q, rates, force + load[:3], load[3:]).normal

    off = tolerance * np.array([1, 1, 1, *np.full(3, SCENE.hole_diameter / 2)])
    exact = normal(np.zeros(6))
    width = sum(np.abs(normal(part) - exact) for part in np.diag(off))
    assert np.all(exact > width)
    ranges = reaction_ranges(SCENE, q, rates, force, np.zeros(3), tolerance)
    np.testing.assert_allclose(ranges.low, exact - width, rtol=1e-6)
    np.testing.assert_allclose(ranges.high, exact + width, rtol=1e-6)


def test_of_several_motions_that_with_most_contacts_is_told():
    # Lifted hard enough the peg may leave, though it may also stay wedged.
    found = solve_unilateral(SCENE, [0.064, 0, 0], CLOSING, [0, 0, 2 * WEIGHT], np.zeros(3))
    assert [sum(mode.closed) for mode in found.modes] == [3, 0]
    assert found.opened == () and found.outcome is reference.Outcome.THREE_POINT


def test_a_contact_without_load_is_one_motion_whether_it_counts_as_closed_or_not():
    q, rates = [0.3, 0, 0], CLOSING

    def at_K(push):
        return reference.solve_contact(SCENE, q, rates, [push, 0, -5.0], np.zeros(3)).normal[0]

    push = -at_K(0.0) / (at_K(1.0) - at_K(0.0))
    push -= at_K(push) / (at_K(1.0) - at_K(0.0))
    found = solve_unilateral(SCENE, q, rates, [push, 0, -5.0], np.zeros(3))
    assert {mode.closed for mode in found.modes} >= {(True, True, True), (False, True, True)}
    assert found.existence is Existence.ONE


@pytest.mark.parametrize(
    ("friction", "gamma", "force", "moment", "opened"),
    [
        (0.05, 0.618, (3.46, -3.49, 14.92), (0.385, 0.148, 0.12), (0, 1)),
        (0.2, 0.392, (-11.84, 3.87, 12.81), (-0.048, 0.364, 0.0), (1, 2)),
        (0.2, 0.729, (-2.56, 7.03, 6.33), (0.346, -0.308, 0.183), (0, 1)),
        (0.5, 0.706, (5.74, 12.39, 9.68), (-0.257, 0.199, -0.331), (0,)),
    ],
)
def test_a_peg_that_is_pulled_off_from_rest_is_pulled_by_no_contact(
    friction, gamma, force, moment, opened
):
    scene = Scene(friction=friction)
    found = solve_stick_slip(scene, [gamma, 0, 0], np.zeros(3), force, moment)
    assert found.converged and found.residual < 1e-9
    assert tuple(k for k in range(3) if found.motion[k] is Motion.OPENS) == opened
    body = free_body(scene, [gamma, 0, 0], np.zeros(3), force, moment)
    normal = np.einsum("ic,ic->i", found.reaction, body.normals)
    along = found.reaction - normal[:, None] * body.normals
    assert np.all(normal >= -1e-9 * WEIGHT)
    assert np.all(np.linalg.norm(along, axis=1) <= friction * normal + 1e-9 * WEIGHT)
    # Newton's law with these forces, and every contact parts or presses.
    load = body.load + sum(wrench_of(a, f) for a, f in zip(body.arms, found.reaction))
    np.testing.assert_allclose(body.mass @ found.acceleration, load, atol=1e-7 * WEIGHT)
