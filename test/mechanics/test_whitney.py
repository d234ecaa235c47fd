"""Whitney's diagram by force balance over all pairs of contact forces inside their cones."""

import numpy as np
import pytest
from scipy.optimize import linprog

from paper.whitney import jamming_diagram
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.whitney import jamming_margin

RADIUS, FRICTION = 0.025, 0.2
LENGTH = 0.03
# Sides of the lower end's contact and of the rim's: either tilt, or both on one side.
PAIRS = ((1, -1), (-1, 1), (1, 1), (-1, -1))


def columns(length, friction, sides):
    """Return force (x, z down the hole) and moment about the lower end of the cones' edges."""
    found = []
    for side, height in zip(sides, (0.0, length)):
        for sign in (1, -1):
            f_x, f_z = -side, sign * friction
            found.append([f_x, f_z, -height * f_x - side * RADIUS * f_z])
    return np.array(found, float).T


def kept(load, length, friction):
    """Return whether forces inside the cones of some pair of contacts can balance a load."""
    return any(
        linprog(
            np.zeros(4), A_eq=columns(length, friction, sides), b_eq=-load, bounds=(0, None)
        ).status
        == 0
        for sides in PAIRS
    )


def inside(vertices, x, y):
    """Return whether a point lies inside a polygon with counter-clockwise vertices."""
    edges = np.roll(vertices, -1, axis=0) - vertices
    off = np.array([x, y]) - vertices
    return bool((edges[:, 0] * off[:, 1] - edges[:, 1] * off[:, 0] > 0).all())


def test_diagram_parts_what_slides_from_what_friction_keeps():
    rng = np.random.default_rng(6)
    diagram = jamming_diagram(RADIUS, LENGTH, FRICTION)
    assert not diagram.can_wedge
    seen = []
    for _ in range(300):
        F_z = rng.uniform(0.5, 50.0)
        x, y = rng.uniform(-7, 7), rng.uniform(-15, 15)
        slides = not kept(np.array([x * F_z, F_z, y * RADIUS * F_z]), LENGTH, FRICTION)
        margin = jamming_margin(RADIUS, LENGTH, FRICTION, x * F_z, F_z, y * RADIUS * F_z)
        assert slides == inside(diagram.vertices, x, y) == (margin > 0)
        seen.append(slides)
    assert 30 < sum(seen) < 200


def test_vertices_are_the_published_ones():
    # Whitney 1982: (-1/mu, 1), (1/mu, -1), (1/mu, -(2 lambda + 1)) and its mirror.
    vertices = jamming_diagram(RADIUS, LENGTH, FRICTION).vertices
    ratio = LENGTH / (2 * RADIUS * FRICTION)
    published = [[-5, 2 * ratio + 1], [-5, 1], [5, -(2 * ratio + 1)], [5, -1]]
    np.testing.assert_allclose(vertices, published, rtol=1e-14)
    # The long edges cut the axis of the moments at plus and minus lambda.
    for a, b, cut in ((0, 3, ratio), (1, 2, -ratio)):
        assert vertices[[a, b], 1].mean() == pytest.approx(cut, rel=1e-14)


@pytest.mark.parametrize("share", [0.2, 0.95, 1.05, 3.0])
def test_wedging_is_where_contacts_can_squeeze_the_peg_without_a_load(share):
    length = share * 2 * RADIUS * FRICTION
    squeezed = False
    for sides in PAIRS[:2]:
        rows = np.vstack([columns(length, FRICTION, sides), np.ones(4)])
        found = linprog(np.zeros(4), A_eq=rows, b_eq=[0, 0, 0, 1], bounds=(0, None))
        squeezed |= found.status == 0
    assert jamming_diagram(RADIUS, length, FRICTION).can_wedge == squeezed == (share < 1)


def test_pull_is_no_push():
    assert jamming_margin(RADIUS, LENGTH, FRICTION, 0.0, -3.0, 0.0) == pytest.approx(-3.0)


@pytest.mark.parametrize(
    "bad", [(0.0, 0.03, 0.2), (0.025, -1.0, 0.2), (0.025, 0.03, float("nan"))]
)
def test_impossible_pegs_are_refused(bad):
    with pytest.raises(PegOnHoleError, match="must be above 0"):
        jamming_diagram(*bad)
