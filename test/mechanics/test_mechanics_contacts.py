"""Contacts that open and wedge: all motions that rigid contacts allow, and critical frictions."""

from dataclasses import replace

import numpy as np
import pytest

import rigid_body_oracle as oracle
from paper.unilateral import Existence, solve_unilateral
from paper.wedging import wedging
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics import reference
from peg_on_hole_ros.mechanics.reference import critical_frictions
from peg_on_hole_ros.mechanics.scene import Scene

SCENE = Scene()
WEIGHT = SCENE.peg_mass * 9.80665
NOTHING = (np.zeros(3), np.zeros(3))
CLOSING = np.array([-0.16, 0.0, 0.0])


def random_states(count, seed):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        q = np.array([rng.uniform(0.07, 1.0), *rng.uniform(-3, 3, 2)])
        yield q, rng.uniform(-2, 2, 3), rng.uniform(-6, 6, 3), rng.uniform(-0.2, 0.2, 3)


def test_closed_contacts_move_as_the_six_equations_say():
    seen = 0
    for q, rates, force, moment in random_states(60, 1):
        plain = reference.solve_contact(SCENE, q, rates, force, moment)
        found = solve_unilateral(SCENE, q, rates, force, moment)
        closed = [mode for mode in found.modes if all(mode.closed)]
        # Three closed contacts are a mode exactly where all reactions press.
        assert bool(closed) == bool(np.all(plain.normal >= 0))
        for mode in closed:
            seen += 1
            np.testing.assert_allclose(mode.normal, plain.normal, rtol=1e-8)
            size = np.max(np.abs(plain.acceleration))
            np.testing.assert_allclose(mode.rates_change, plain.acceleration, atol=1e-8 * size)
    assert seen > 5


def test_every_mode_presses_or_parts():
    kinds = set()
    for q, rates, force, moment in random_states(80, 2):
        found = solve_unilateral(SCENE, q, rates, force, moment)
        kinds.add(found.outcome)
        for mode in found.modes:
            assert np.all(mode.normal >= 0)
            size = np.max(np.abs(mode.acceleration))
            assert np.all(mode.parting >= -1e-8 * size)
            assert np.all(mode.normal * mode.parting == 0)
    assert len(kinds) >= 2


def test_an_opening_contact_parts_as_a_body_on_the_other_two():
    q, scene = np.array([0.3, 0.5, 0.2]), SCENE
    found = solve_unilateral(scene, q, CLOSING, *NOTHING)
    assert found.opened == ("K",) and found.existence is Existence.ONE
    assert found.outcome is reference.Outcome.CONTACT_OPEN
    (mode,) = found.modes
    body = oracle.Body(scene, q, CLOSING, *NOTHING)
    g_C, g_w = oracle.gap_gradients(scene, body.C, body.R)
    v = body.dC @ body.rates

    def gap_rate(t):
        angle, axis = np.linalg.norm(body.omega) * t, body.omega / np.linalg.norm(body.omega)
        K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        R = (np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K) @ body.R
        by_C, by_turn = oracle.gap_gradients(scene, body.C + v * t, R)
        return by_C @ v + by_turn @ body.omega

    drift = oracle.along(gap_rate)
    on = [1, 2]
    A = np.zeros((8, 8))
    A[:3, :3], A[3:6, 3:6] = scene.peg_mass * np.eye(3), body.inertia
    A[:3, 6:], A[3:6, 6:] = -body.reaction[on].T, -body.torque[on].T
    A[6:, :3], A[6:, 3:6] = g_C[on], g_w[on]
    gyro = np.cross(body.omega, body.inertia @ body.omega)
    y = np.linalg.solve(A, np.concatenate([body.force, -gyro, -drift[on]]))
    np.testing.assert_allclose(mode.normal, [0, *y[6:]], rtol=1e-8)
    gap = g_C[0] @ y[:3] + g_w[0] @ y[3:6] + drift[0]
    assert mode.parting[0] == pytest.approx(gap / np.linalg.norm(g_C[0]), rel=1e-8) and gap > 0


def test_wedged_pure_alignment_has_no_motion_and_slip_gives_one():
    stuck = solve_unilateral(SCENE, [0.064, 0, 0], CLOSING, *NOTHING)
    assert stuck.existence is Existence.NONE and stuck.modes == ()
    assert stuck.outcome is reference.Outcome.WEDGED
    freed = solve_unilateral(SCENE, [0.064, 0, 0], CLOSING + [0, 0, 2], *NOTHING)
    assert freed.existence is Existence.ONE and freed.outcome is reference.Outcome.THREE_POINT


def test_beyond_the_singular_set_there_may_be_several_motions():
    # Lifted hard enough the peg may leave, though it may also stay wedged.
    force = np.array([0, 0, 2 * WEIGHT])
    found = solve_unilateral(SCENE, [0.064, 0, 0], CLOSING, force, np.zeros(3))
    assert found.existence is Existence.SEVERAL
    # That with most contacts comes first.
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


def test_every_critical_friction_makes_the_six_equations_singular():
    for gamma, rates in ((0.0634, CLOSING), (0.07, CLOSING), (0.12, -CLOSING), (0.3, CLOSING)):
        q = [gamma, 0, 0]
        found = wedging(SCENE, q, rates)
        assert len(found.roots) >= 1
        for root in found.roots:
            if root > 1.9:
                continue

            def determinant(f, q=q, rates=rates):
                A, _ = reference.six_equations(
                    replace(SCENE, friction=f), q, rates, np.zeros(6), 0.0
                )
                return np.linalg.det(A)

            below, above = determinant(root * (1 - 1e-6)), determinant(root * (1 + 1e-6))
            assert below * above < 0
        assert np.sign(found.determinant) == np.sign(determinant_over_frictionless(q, rates))


def determinant_over_frictionless(q, rates):
    dets = [
        np.linalg.det(
            reference.six_equations(replace(SCENE, friction=f), q, rates, np.zeros(6), 0.0)[0]
        )
        for f in (SCENE.friction, 0.0)
    ]
    return dets[0] / dets[1]


def test_a_pair_of_critical_frictions_appears_at_once():
    before, after = (wedging(SCENE, [g, 0, 0], CLOSING) for g in (0.0658, 0.0657))
    assert len(before.roots) == 1 and before.roots[0] > 2 and before.discriminant < 0
    assert len(after.roots) == 3 and after.roots[0] == pytest.approx(0.252, abs=1e-3)
    assert after.discriminant > 0
    # The determinant has fallen smoothly meanwhile: it warns earlier.
    assert 0 < after.determinant < before.determinant < 0.1
    assert wedging(SCENE, [0.064, 0, 0], CLOSING + [0, 0, 2]).roots == ()


def test_roots_of_known_cubics():
    # (1 - f)(1 - f/2)(1 - f/3), and a double root.
    np.testing.assert_allclose(critical_frictions([1, -11 / 6, 1, -1 / 6]), [1, 2, 3], rtol=1e-9)
    np.testing.assert_allclose(critical_frictions([1, -4, 4, 0]), [0.5, 0.5], rtol=1e-6)
    assert critical_frictions([1, 0, 0, 0]) == ()
    assert critical_frictions([1, 2, 1, 0]) == ()
    with pytest.raises(PegOnHoleError, match="is not four finite coefficients"):
        critical_frictions([1, np.nan, 0, 0])


@pytest.mark.parametrize("rates", [(0, 1, 0), (0, 0, 1), (0, -1, 0), (0, 0, -1)])
@pytest.mark.parametrize("gamma", [0.0634, 0.07, 0.15, 0.5, 1.2])
def test_a_peg_that_does_not_tilt_wedges_with_no_friction(gamma, rates):
    q = [gamma, 0.3, 0.2]
    none, some = (
        reference.six_equations(replace(SCENE, friction=f), q, rates, np.zeros(6), 0.0)[0]
        for f in (0.0, 1.0)
    )
    # Friction enters them linearly: that way beyond what a scene takes, to a thousand.
    signs = [np.linalg.slogdet(none + f * (some - none))[0] for f in np.geomspace(1e-3, 1e3, 200)]
    assert signs == [np.linalg.slogdet(none)[0]] * 200
    assert reference.solve_contact(SCENE, q, rates, *NOTHING).critical_friction is None
    assert wedging(SCENE, q, rates).roots == ()


def test_bad_states_are_refused():
    with pytest.raises(PegOnHoleError, match=r"gamma = 0.05 rad has no three-point contact"):
        solve_unilateral(SCENE, [0.05, 0, 0], CLOSING, *NOTHING)
    with pytest.raises(PegOnHoleError, match=r"rates = \[nan  0.  0.\] rad/s is not finite"):
        solve_unilateral(SCENE, [0.1, 0, 0], [np.nan, 0, 0], *NOTHING)
    with pytest.raises(PegOnHoleError, match=r"moment = \[ 0. inf  0.\] N m is not finite"):
        solve_unilateral(SCENE, [0.1, 0, 0], CLOSING, np.zeros(3), [0, np.inf, 0])
