"""
Chamfered pegs in chamfered holes against sharp ones, by brute force over their surfaces.

Nothing of the closed form is used to find a pose: peg and hole are cut by lines along the tilt, at
many heights and many distances from the plane of symmetry. Each line leaves the peg some room to
either side; the least of all is the room of the pair. A peg that is lowered rests where no room is
left, and the lines that leave none are its contacts.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import brentq

from paper.chamfers import edges_carry, elevations
from peg_on_hole_ros.estimator.hole_geometry import depth_at
from peg_on_hole_ros.mechanics.geometry import contact_geometry, contact_points
from peg_on_hole_ros.mechanics.scene import Scene
from tiers import at_push

LOOSE = Scene(hole_diameter=0.050, peg_diameter=0.0499)
TIGHT = Scene(hole_diameter=0.012, peg_diameter=0.01199)
# Height of the cones [m], and half angles [degrees].
HEIGHT = 4e-4
DEGREES = np.pi / 180


class Pair(NamedTuple):
    """Heights [m] and half angles [rad] of the two cones; a height of 0: sharp."""

    hole_height: float = 0.0
    hole_angle: float = 45 * DEGREES
    peg_height: float = 0.0
    peg_angle: float = 45 * DEGREES


SHARP = Pair()
PAIRS = {
    "sharp": SHARP,
    "hole": Pair(hole_height=HEIGHT),
    "peg": Pair(peg_height=HEIGHT),
    "both": Pair(hole_height=HEIGHT, peg_height=HEIGHT),
}


class Rest(NamedTuple):
    """Where a peg rests: its shoulder's centre (h, z), and the contact on either side (e, z)."""

    place: np.ndarray
    towards_B: np.ndarray
    towards_K: np.ndarray


def widths(scene, pair, gamma, Z, y, z):
    """
    Return how far the peg reaches to -h and to h on lines at y, z, and how far the hole does.

    The shoulder's centre is at (0, 0, Z), and the hole is as wide to either side; NaN where there
    is no peg, infinite where there is no hole.
    """
    s, c = np.sin(gamma), np.cos(gamma)
    r, R, dz, t = scene.peg_diameter / 2, scene.hole_diameter / 2, z - Z, np.tan(pair.peg_angle)
    # In peg axes a line has x' = c X + s dz and z' = c dz - s X. What is a X^2 + 2 b X + e <= 0 on
    # it lies within the shank, and within the cone; what is below high is above the end face.
    quadrics = [(c * c, c * s * dz, (s * dz) ** 2 + y * y - r * r)]
    if pair.peg_height:
        wide = r + t * c * dz
        e = (s * dz) ** 2 + y * y - wide * wide
        quadrics.append((c * c - (t * s) ** 2, c * s * dz + t * s * wide, e))
    low, high = np.full(y.shape, -np.inf), (c * dz + pair.peg_height) / s
    for a, b, e in quadrics:
        # A root of what is below zero is NaN, and stays so: the line misses.
        root = np.sqrt(b * b - a * e)
        low, high = np.maximum(low, (-b - root) / a), np.minimum(high, (-b + root) / a)
    misses = ~(low <= high)
    low[misses] = high[misses] = np.nan
    within = R + np.where(z > 0, z * np.tan(pair.hole_angle), 0.0)
    half = np.sqrt(np.maximum(within**2 - y * y, 0.0))
    return low, high, np.where(z <= pair.hole_height, half, np.inf)


def least(scene, pair, gamma, Z, sign, y):
    """Return of each y the least room to h or to -h, and at which height: bore, or cone."""
    bore = scene.hole_diameter / 2 * np.array([-3.0, 0.0])
    found = []
    for lowest, highest in [bore] + [[0.0, pair.hole_height]] * bool(pair.hole_height):
        lowest = max(lowest, Z - scene.peg_diameter * np.sin(gamma) - pair.peg_height)
        z = np.linspace(np.full(y.shape, lowest), highest, 25, axis=1)
        for _ in range(7):
            low, high, half = widths(scene, pair, gamma, Z, y[:, None] + 0 * z, z)
            left = half - high if sign > 0 else half + low
            left[np.isnan(left)] = np.inf
            best, rows = np.argmin(left, axis=1), np.arange(len(y))
            found.append(np.array([left[rows, best], z[rows, best]]))
            ends = z[rows, np.maximum(best - 1, 0)], z[rows, np.minimum(best + 1, 24)]
            z = np.linspace(*ends, 25, axis=1)
    found = np.array(found)
    best = np.argmin(found[:, 0], axis=0)
    return found[best, :, np.arange(len(y))].T


@np.errstate(invalid="ignore")
def room(scene, pair, gamma, Z, sign):
    """Return how far the peg may go along h, or to -h, and (e, z) of what stops it there."""
    ys = np.linspace(0.0, scene.hole_diameter / 2, 41)
    for _ in range(9):
        left, z = least(scene, pair, gamma, Z, sign, ys)
        j = int(np.argmin(left))
        found = left[j], np.array([ys[j], z[j]])
        ys = np.linspace(ys[max(j - 1, 0)], ys[min(j + 1, len(ys) - 1)], 15)
    return found


@cache
def rest(scene, pair, gamma):
    """Lower a peg at a tilt until no room is left."""
    D = scene.hole_diameter

    def left(Z):
        # Above the hole it is endless.
        return min(sum(room(scene, pair, gamma, Z, sign)[0] for sign in (1, -1)), D)

    Z = brentq(left, -0.5 * D, 0.5 * D, xtol=1e-13)
    (ahead, B), (_, K) = (room(scene, pair, gamma, Z, sign) for sign in (1, -1))
    return Rest(np.array([ahead, Z]), B, K)


def tilts(scene):
    """Two on two points in the hole, and two on three points."""
    return [0.3 * scene.gamma0, 0.8 * scene.gamma0, 1.2 * scene.gamma0, 0.6]


# The last grids have steps of some 1e-10 m, and kinks make errors of that order; of diameters.
CLOSE = 5e-8


@pytest.mark.parametrize("scene", at_push([LOOSE], [LOOSE, TIGHT]))
@pytest.mark.parametrize("name", at_push(["both"], list(PAIRS)))
def test_a_chamfered_pair_rests_as_a_sharp_one_of_bore_and_shank(scene, name):
    pair = PAIRS[name]
    for gamma in tilts(scene):
        found, D = rest(scene, pair, gamma), scene.hole_diameter
        if gamma > scene.gamma0:
            g = contact_geometry(scene, gamma)
            place = [g.a2 * g.s, g.a1 - g.a2 * g.c]
            K, B = contact_points(g, D)[[0, 2], 1:]
        else:
            # K on the throat, B on the bore, both in the plane of symmetry.
            depth = depth_at(scene.peg_diameter, D, gamma)[0]
            s, c, d = np.sin(gamma), np.cos(gamma), scene.peg_diameter
            place = [(D - d * c) / 2, -depth]
            K, B = np.zeros(2), np.array([0.0, -depth + d / 2 * s])
        np.testing.assert_allclose(found.place, place, atol=CLOSE * D)
        # Where a contact is in its own plane is a flat minimum: known to the root of that.
        np.testing.assert_allclose(found.towards_K, K, atol=np.sqrt(CLOSE) * D)
        np.testing.assert_allclose(found.towards_B, B, atol=np.sqrt(CLOSE) * D)


def end_of(scene, angle, elevation):
    """Return the tilt at which an elevation reaches a cone's half angle, by bisection."""
    return brentq(lambda gamma: getattr(elevations(scene, gamma), elevation) - angle, 1e-3, 1.5)


# Half angles of 2 and 5 degrees are no chamfers: they bring the limit to where it can be seen, on
# two points below gamma0 = 3.6 degrees, and on three above it.
ENDS = {
    "hole_2": (Pair(hole_height=HEIGHT, hole_angle=2 * DEGREES), "K"),
    "peg_5": (Pair(peg_height=HEIGHT, peg_angle=5 * DEGREES), "B_shoulder"),
    "hole_20": (Pair(hole_height=HEIGHT, hole_angle=20 * DEGREES), "K"),
    "peg_2": (Pair(peg_height=HEIGHT, peg_angle=2 * DEGREES), "B_shoulder"),
    "both_30": (Pair(HEIGHT, 30 * DEGREES, HEIGHT, 30 * DEGREES), "K"),
}


@pytest.mark.parametrize("name", at_push(["hole_2", "peg_5"], list(ENDS)))
def test_beyond_the_normal_of_its_cone_an_edge_carries_no_more(name):
    """Just below it the pose is a sharp pair's to nanometres, and beyond it is off by far."""
    pair, elevation = ENDS[name]
    hole_angle = pair.hole_angle if pair.hole_height else np.pi / 2
    peg_angle = pair.peg_angle if pair.peg_height else np.pi / 2
    least = min(hole_angle, peg_angle)
    end = end_of(LOOSE, least, elevation)
    # Of the shoulder above gamma0 the tilt suffices, and is not needed: see `paper.chamfers`.
    assert end > 1.5 * least if name == "peg_5" else end == pytest.approx(least)
    assert edges_carry(0.97 * least, hole_angle, peg_angle)
    assert not edges_carry(1.1 * end, hole_angle, peg_angle)
    off = [
        float(np.hypot(*(rest(LOOSE, pair, gamma).place - rest(LOOSE, SHARP, gamma).place)))
        for gamma in (0.97 * least, 1.1 * end)
    ]
    assert off[0] < CLOSE * LOOSE.hole_diameter < 1e-6 < off[1]


@pytest.mark.parametrize("scene", [LOOSE, TIGHT], ids=["loose", "tight"])
def test_the_tilt_itself_is_the_greatest_elevation(scene):
    """So that a tilt below both half angles always suffices; K has it all the way."""
    for gamma in np.linspace(0.1 * scene.gamma0, 1.4, 300):
        found = elevations(scene, gamma)
        assert gamma == found.K and max(found) <= gamma * (1 + 1e-12)
    # B is far from it: half of the tilt, where that is large.
    assert elevations(scene, 0.6).B_throat == pytest.approx(0.3, rel=0.02)
    assert elevations(scene, 0.6).B_shoulder == pytest.approx(0.3, rel=0.03)


@pytest.mark.parametrize("share", [1.05, 2.0, 6.0])
def test_between_B1_and_B2_the_rim_runs_down_the_cone_ever_steeper_up_to_the_tilt(share):
    gamma, R = share * LOOSE.gamma0, LOOSE.hole_diameter / 2
    g = contact_geometry(LOOSE, gamma)
    end, across = np.array([g.a2 * g.s, 0.0, g.a1 - g.a2 * g.c]), np.array([g.c, 0.0, g.s])
    theta = np.linspace(np.arctan2(g.b, g.S1), 0.0, 400)[1:]
    rim = np.stack([R * np.cos(theta), R * np.sin(theta), 0 * theta], axis=-1) - end
    down = -(rim @ [-g.s, 0.0, g.c])
    slopes = (LOOSE.peg_diameter / 2 - np.hypot(rim @ across, rim[:, 1])) / down
    assert np.all(np.diff(slopes) > -1e-9)
    found = elevations(LOOSE, gamma)
    assert slopes[0] == pytest.approx(np.tan(found.B_shoulder), rel=0.02)
    assert slopes[-1] == pytest.approx(np.tan(gamma), rel=1e-9)


@pytest.mark.parametrize("scene", [LOOSE, TIGHT], ids=["loose", "tight"])
def test_diameters_of_the_chamfers_are_those_of_another_pair(scene):
    """Of 45 degrees they state a clearance of eight to eighty times, and another gamma0."""
    wide = HEIGHT * np.tan(45 * DEGREES)
    stated = Scene(
        hole_diameter=scene.hole_diameter + 2 * wide, peg_diameter=scene.peg_diameter - 2 * wide
    )
    clearance = scene.hole_diameter - scene.peg_diameter
    assert stated.hole_diameter - stated.peg_diameter == pytest.approx(clearance + 4 * wide)
    gamma = 1.5 * scene.gamma0
    found = rest(scene, PAIRS["both"], gamma)
    assert found.towards_B[1] == pytest.approx(0.0, abs=1e-6)
    # On three points at a tilt at which the pair as stated would be deep in the hole.
    assert gamma < 0.8 * stated.gamma0
