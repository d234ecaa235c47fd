"""The worked examples of the paper: the numbers that must come out, Fig. 10, "slip reduces"."""

import numpy as np
import pytest

import rigid_body_oracle as oracle
from paper import examples
from peg_on_hole_ros.mechanics import reference
from peg_on_hole_ros.mechanics.scene import Scene

SCENE = Scene()
WEIGHT = SCENE.peg_mass * 9.80665
CLOSING, WITH_SLIP = (-0.16, 0.0, 0.0), (-0.16, 0.0, 2.0)


@pytest.mark.parametrize(
    "gamma, rates, expected",
    [(0.1, CLOSING, 2.03), (0.1, WITH_SLIP, 5.20), (0.15, CLOSING, 0.48), (0.15, WITH_SLIP, 2.04)],
)
def test_imposed_alignment_gives_the_known_overall_reactions(gamma, rates, expected):
    found = examples.figure_10(SCENE, gamma, rates, "corrected")
    assert found == pytest.approx(expected, abs=0.005)
    # By the numeric body: force balance of the moved mass centre.
    body = oracle.Body(SCENE, [gamma, 0, 0], rates, np.zeros(3), np.zeros(3))
    a_C = oracle.along(lambda t: body.center_jacobian(body.path(t)), 2.0) @ body.rates
    N = np.linalg.solve(body.reaction.T, SCENE.peg_mass * a_C - body.force)
    assert N[0] * np.sqrt(1.04) / WEIGHT == pytest.approx(found, rel=1e-8)


def test_imposed_couple_keeps_the_rates():
    found = examples.imposed(SCENE, 0.2, (-0.16, 0.4, 2.0))
    s, c = np.sin(0.2), np.cos(0.2)
    # A couple with these generalised forces: Q = (-M_e, M_z, c M_z - s M_h).
    M_e, M_z = -found.couple[0], found.couple[1]
    M = np.array([(c * M_z - found.couple[2]) / s, M_e, M_z])
    solution = reference.solve_contact(SCENE, [0.2, 0, 0], (-0.16, 0.4, 2.0), np.zeros(3), M)
    np.testing.assert_allclose(solution.acceleration, 0, atol=1e-10)
    np.testing.assert_allclose(solution.normal, found.normal, rtol=1e-10)


def test_imposed_alignment_over_an_array():
    gamma = np.array([0.1, 0.15, 0.3])
    many = examples.imposed(SCENE, gamma, WITH_SLIP)
    for k in range(3):
        one = examples.imposed(SCENE, gamma[k], WITH_SLIP)
        np.testing.assert_allclose(many.normal[:, k], one.normal, rtol=1e-12)
        np.testing.assert_allclose(many.couple[:, k], one.couple, rtol=1e-10, atol=1e-14)


# What each reading of the print gives at 0.15 rad, without and with slip; the paper has 45, 35.
FIGURE_10 = {
    "corrected": (0.48, 2.04),
    "literal sign of gamma', f in (28.6)": (-6.79, 2.17),
    "literal sign of gamma', no f in (28.6)": (-0.44, 2.52),
    "closing speed in friction, no f in (28.6)": (0.13, 1.80),
    "literal sign of gamma', beta for lambda as in (23.3)": (0.00, 0.09),
    "(39) with the closing speed": (3.87, 10.75),
}


@pytest.mark.parametrize("reading", examples.READINGS)
def test_no_reading_of_the_print_gives_figure_10(reading):
    found = [examples.figure_10(SCENE, 0.15, rates, reading) for rates in (CLOSING, WITH_SLIP)]
    assert found == pytest.approx(FIGURE_10[reading], abs=0.006)
    assert not (30 < found[1] < 40 and 40 < found[0] < 50)


def free(gamma, slip):
    return reference.solve_contact(
        SCENE, [gamma, 0, 0], (-0.16, 0, slip), np.zeros(3), np.zeros(3)
    )


def reactions_by_the_body(gamma, rates):
    """Return N under a pure couple with constant rates, from the numeric body's force balance."""
    body = oracle.Body(SCENE, [gamma, 0, 0], rates, np.zeros(3), np.zeros(3))
    a_C = oracle.along(lambda t: body.center_jacobian(body.path(t)), 2.0) @ body.rates
    return np.linalg.solve(body.reaction.T, SCENE.peg_mass * a_C - body.force)


TURNS = {"slip": (-0.16, 0.0, 2.0), "slide": (-0.16, 2.0, 0.0), "both": (-0.16, 1.0, 1.0)}


@pytest.mark.parametrize("turn", TURNS)
def test_both_claims_of_the_abstract_are_reversed_in_imposed_alignment(turn):
    """Far from gamma0 turning raises all three reactions, near it lowers them."""
    for gamma, sign in ((0.2, 1), (0.1, 1), (0.0680, 1), (0.0670, -1), (0.0650, -1), (0.0640, -1)):
        plain, turning = (reactions_by_the_body(gamma, r) for r in (CLOSING, TURNS[turn]))
        assert np.all(sign * (turning - plain) > 0), gamma
        assert examples.imposed(SCENE, gamma, TURNS[turn]).normal == pytest.approx(
            turning, rel=1e-8
        )


@pytest.mark.parametrize(("slip", "crossing"), [(2.0, 0.0673), (0.5, 0.0764), (0.1, 0.0907)])
def test_slower_slip_lowers_the_reaction_at_K_from_larger_tilts_on(slip, crossing):
    def raised(gamma):
        with_slip, without = (
            reactions_by_the_body(gamma, (-0.16, 0.0, phi))[0] for phi in (slip, 0.0)
        )
        return with_slip - without

    assert raised(crossing - 1e-4) < 0 < raised(crossing + 1e-4)


def test_slip_lowers_the_reaction_of_free_alignment_only_where_that_would_wedge():
    # Away from the singular set slip raises it.
    for gamma in (0.08, 0.1, 0.15):
        assert free(gamma, 2.0).normal[0] > 1.5 * free(gamma, 0.0).normal[0]
    # Towards it, 0.0652 rad, free alignment needs ever larger reactions; slip does not.
    assert free(0.07, 0.0).normal[0] > 1.5 * free(0.07, 2.0).normal[0]
    assert free(0.066, 0.0).normal[0] > 9 * free(0.066, 2.0).normal[0]
    # Below, pure alignment is wedged, and slip frees it.
    assert free(0.0640, 0.0).outcome is reference.Outcome.WEDGED
    assert free(0.0640, 2.0).outcome is reference.Outcome.THREE_POINT
    assert free(0.0640, 2.0).normal[0] / WEIGHT == pytest.approx(9.64, abs=0.01)


def test_singular_tilt_of_the_paper_scene():
    assert free(0.0651, 0).determinant < 0 < free(0.0653, 0).determinant
    assert free(0.0651, 2).determinant > 1
    # Opening motion has a singular band of its own.
    signs = [
        reference.solve_contact(
            SCENE, [g, 0, 0], (0.16, 0, 0), np.zeros(3), np.zeros(3)
        ).determinant
        for g in (0.08, 0.12, 0.15, 0.2)
    ]
    assert signs[0] > 0 > signs[1] and signs[2] < 0 < signs[3]
