"""Close to gamma0: which approximation holds where, and the inertia in the reactions."""

import numpy as np
import pytest

import rigid_body_oracle as oracle
from paper import small_tilt
from paper.small_tilt import Stage
from peg_on_hole_ros.mechanics.geometry import contact_geometry_above
from peg_on_hole_ros.mechanics.scene import Scene

EXCESS = 1e-4


@pytest.mark.parametrize(
    ("over_gamma0", "expected"),
    [(0.09, Stage.SMALL), (0.11, Stage.MEDIUM), (7, Stage.MEDIUM), (9.9, Stage.MEDIUM),
     (10.1, Stage.LARGER)],
)  # fmt: skip
def test_much_less_is_a_factor_of_ten(over_gamma0, expected):
    scene = Scene(peg_diameter=0.05 * np.cos(0.02))
    excess = over_gamma0 * scene.gamma0
    assert small_tilt.stage(scene, excess) is expected
    # The stage's expression is within what a tenth, squared in gamma beside it, leaves out.
    true = contact_geometry_above(scene, excess).a1
    found = small_tilt.axis_offset(scene, excess, expected)
    assert found == pytest.approx(true, rel=0.11 + (scene.gamma0 + excess) ** 2)
    if 1 < over_gamma0 < 10:
        larger = small_tilt.axis_offset(scene, excess, Stage.LARGER)
        assert abs(found - true) < abs(larger - true) / 3


def by_the_body(scene, rates):
    """Return N_K, N_B1, N_B2 and the tilt's cosine from the numeric body's force balance."""
    gamma = scene.gamma0 + EXCESS
    body = oracle.Body(scene, [gamma, 0, 0], rates, np.zeros(3), np.zeros(3))
    a_C = 100 * oracle.along(lambda t: body.center_jacobian(body.path(t / 100)) @ body.rates)
    return np.linalg.solve(body.reaction.T, scene.peg_mass * a_C - body.force), np.cos(gamma)


def test_inertia_along_the_hole():
    # Without weight the reactions are inertia alone; a long peg tells H_c from D/gamma0.
    scene = Scene(peg_height=0.3, gravity=(0.0, 0.0, 0.0))
    rates = (-3.0, 0.0, 0.0)
    true, _ = by_the_body(scene, rates)
    found = small_tilt.reactions(scene, EXCESS, rates)
    # Left out: excess/gamma0^2, 2.5 %, and gamma0.
    assert np.isclose(found.K, true[0], rtol=0.1)
    assert found.B_sum == pytest.approx(true[1] + true[2], rel=0.1)


def test_inertia_across_the_hole():
    # Without friction N_K cos(gamma) less N_B1 + N_B2 is what moves C across.
    scene = Scene(peg_height=0.02, friction=0.0, gravity=(0.0, 0.0, 0.0))
    rates = (-3.0, 0.0, 0.0)
    (K, B1, B2), c = by_the_body(scene, rates)
    found = small_tilt.reactions(scene, EXCESS, rates)
    pressed = found.K * c - found.B_sum
    assert pressed == pytest.approx(scene.peg_mass * 0.05 / 2 * 9.0, rel=0.01)
    # B1 and B2 press across with S1/OB of their force, 1 less some excess/gamma0.
    g = contact_geometry_above(scene, EXCESS)
    across = K * c - (B1 + B2) * g.S1 / np.hypot(scene.hole_diameter / 2, g.a1)
    assert pressed == pytest.approx(across, rel=0.1)


def test_friction_and_reactions_move_the_peg_along_the_hole():
    # Closing pulls at K down the peg's axis, and at B1 and B2 up the hole's wall.
    scene = Scene(peg_height=0.02, friction=0.5, gravity=(0.0, 0.0, 0.0))
    found = small_tilt.reactions(scene, EXCESS, (-3.0, 0.0, 0.0))
    gamma, f = scene.gamma0 + EXCESS, scene.friction
    upward = found.K * (np.sin(gamma) - f * np.cos(gamma)) + f * found.B_sum
    falls = scene.hole_diameter / scene.gamma0 + scene.mass_center_height
    assert upward == pytest.approx(-scene.peg_mass * falls * 9.0, rel=1e-6)


def test_inertia_out_of_the_plane_of_tilt():
    # A peg that slides while it closes is pushed sideways: by B1 and B2, without friction.
    scene = Scene(friction=0.0)
    for slide in (2.0, -2.0):
        rates = (-1.0, slide, 0.0)
        true, _ = by_the_body(scene, rates)
        found = small_tilt.reactions(scene, EXCESS, rates)
        assert found.B_difference == pytest.approx(true[1] - true[2], rel=0.15)
        assert found.B_difference * slide > 0
