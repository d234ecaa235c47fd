"""How far an offset peg is off its touching points: against shapes sampled densely, and motion."""

import numpy as np
import pytest

from peg_on_hole_ros.mechanics.geometry import contact_geometry, contact_points, normals
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.dynamics import scene_numbers, three_points
from peg_on_hole_ros.sim.gaps import contact_gaps
from peg_on_hole_ros.sim.hole_places import CLEAR

pytestmark = pytest.mark.xdist_group("simulation")
SCENE = Scene(peg_diameter=0.04984)
P = scene_numbers(SCENE)
TILTS = (0.1, 0.18, 0.3)
# What a peg is off after K has opened for a tenth of a second [m].
OFFSETS = np.array([[3e-4, 0.0, -6e-5], [1e-4, 4e-5, 2e-5], [-1e-5, -2e-5, 1e-5]])


def axes(gamma):
    """Rows eta, eps, zeta in (h, e, z)."""
    s, c = np.sin(gamma), np.cos(gamma)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def end_centre(gamma, offset):
    _, _, a1, a2 = three_points(P, gamma)[:4]
    return np.array([0, 0, a1]) - a2 * axes(gamma)[2] + offset


def circle(radius, angles):
    return radius * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=-1)


@pytest.mark.parametrize("gamma", TILTS)
def test_touching_pose_has_no_gaps(gamma):
    points, n, gaps = contact_gaps(P, gamma, np.zeros(3))
    g = contact_geometry(SCENE, gamma)
    # Lengths of centimetres to rounding.
    np.testing.assert_allclose(gaps, 0, atol=1e-16)
    np.testing.assert_allclose(points, contact_points(g, SCENE.hole_diameter), atol=1e-15)
    np.testing.assert_allclose(n, normals(g), atol=1e-13)


@pytest.mark.parametrize("gamma", TILTS)
@pytest.mark.parametrize(
    "offset",
    [OFFSETS[0], *(pytest.param(each, marks=pytest.mark.nightly) for each in OFFSETS[1:])],
)
def test_gaps_are_the_distances_of_the_shapes(gamma, offset):
    points, n, gaps = contact_gaps(P, gamma, offset)
    centre, R = end_centre(gamma, offset), axes(gamma)
    # K: the rim's points, off the peg's axis by less its radius; 0.2 um apart.
    rim = circle(SCENE.hole_diameter / 2, np.pi + np.linspace(-0.6, 0.6, 150_001))
    across = np.cross(rim - centre, R[2])
    nearest = np.sqrt((across**2).sum(axis=1)).min() - SCENE.peg_diameter / 2
    # It is taken where the side is outermost in the rim: of a contact that is open by 0.3 mm that
    # is 7 % more than the least distance, of one by a micrometre nothing that counts.
    assert gaps[0] == pytest.approx(nearest, rel=0.1 if nearest > 1e-4 else 0.01, abs=1e-10)
    # B1, B2: the two circles about the crossing; 6 um apart, so some 0.4 nm in the distance.
    for i in (1, 2):
        at = np.arctan2(points[i, 1], points[i, 0])
        rim = circle(SCENE.hole_diameter / 2, at + np.linspace(-0.02, 0.02, 1601)[:, None])
        edge = (points[i] - centre) @ R.T
        angles = np.arctan2(edge[1], edge[0]) + np.linspace(-0.02, 0.02, 1601)
        edge = centre + circle(SCENE.peg_diameter / 2, angles) @ R
        distance = np.sqrt(((rim - edge[None]) ** 2).sum(axis=-1)).min()
        assert abs(gaps[i]) == pytest.approx(distance, rel=0.02, abs=5e-9)


@pytest.mark.parametrize("i", [0, 1, 2])
@pytest.mark.parametrize("gamma", TILTS)
def test_a_gap_changes_as_the_touching_point_moves_along_the_normal(i, gamma):
    """Else contacts would do work on no way: 2000 N out of nothing, 0.3 mm off the rim."""
    offset = OFFSETS[0].copy()
    for _ in range(20):
        # Slid until this contact just touches.
        _, n, gaps = contact_gaps(P, gamma, offset)
        offset -= gaps[i] * n[i]
    points, n, gaps = contact_gaps(P, gamma, offset)
    assert abs(gaps[i]) < 1e-12 and np.abs(offset).max() > 2e-5
    move = 1e-7

    def after(tilt, by):
        # Turning by gamma about -e through the peg's end, and the end where that leaves it.
        stays = end_centre(gamma, offset) - end_centre(gamma + tilt, np.zeros(3))
        return contact_gaps(P, gamma + tilt, stays + by)[2][i]

    for j in range(3):
        by = move * np.eye(3)[j]
        slope = (after(0.0, by) - after(0.0, -by)) / (2 * move)
        assert slope == pytest.approx(n[i, j], abs=1e-4)
    velocity = np.cross([0.0, -1.0, 0.0], points[i] - end_centre(gamma, offset))
    slope = (after(move, np.zeros(3)) - after(-move, np.zeros(3))) / (2 * move)
    assert slope == pytest.approx(velocity @ n[i], abs=1e-5)


def test_an_end_above_the_rim_is_clear_of_it():
    _, _, gaps = contact_gaps(P, 0.2, np.array([0.0, 0.0, 0.02]))
    assert (gaps[1:] == CLEAR).all()
