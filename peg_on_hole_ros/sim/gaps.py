"""How far a peg is off each of its three touching points, by the shapes of peg and rim."""

import numpy as np

from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.sim.dynamics import three_points
from peg_on_hole_ros.sim.hole_places import CLEAR

# To first order in the offset from the touching pose a gap would be the offset's share along the
# normal of that pose. That is not enough: the normals at B1 and B2 turn by a tenth while the peg
# slides 0.3 mm to the side, and contacts of 1e8 N/m made 2000 N out of the 20 um that it left out.

# Newton's steps to where the peg's side comes nearest to the rim, and how far one goes [rad].
_SIDE_STEPS, _LONGEST_TURN, _FURTHEST = 30, 0.1, 1.2


@compiled
def contact_gaps(
    p: np.ndarray, gamma: float, offset: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Return where the peg touches, or would, how far off it is there, and along which normals.

    Parameters
    ----------
    p : ndarray
        From `dynamics.scene_numbers`.
    gamma : float
        Tilt [rad].
    offset : ndarray, shape (3,)
        From the touching pose along h, e, z [m].

    Returns
    -------
    points, normals : ndarray, shape (3, 3)
        Rows K, B1, B2 in (h, e, z): on the rim [m]; on the peg, unit length.
    gaps : ndarray, shape (3,)
        [m], negative where the peg is pressed in; exact but for terms in the gap's own square (a
        hundredth of an open gap of some 0.05 mm). CLEAR where the peg's end does not cross the
        rim's plane.

    """
    d, D = p[0], p[1]
    s, c, a1, a2 = three_points(p, gamma)[:4]
    # The centre of the peg's end.
    P = np.array([a2 * s, 0.0, a1 - a2 * c]) + offset
    points, normals, gaps = np.zeros((3, 3)), np.zeros((3, 3)), np.empty(3)
    gaps[0] = _side(d, D, s, c, P, points[0], normals[0])
    gaps[1] = _edge(d, D, s, c, P, -1.0, points[1], normals[1])
    gaps[2] = _edge(d, D, s, c, P, 1.0, points[2], normals[2])
    return points, normals, gaps


@compiled
def _side(d, D, s, c, P, point, normal):
    """Fill in K, the rim against the peg's side, and return its gap."""
    # The side cuts the rim's plane in an ellipse; K is where it is farthest from the hole's axis.
    A, B = d / (2 * c), d / 2
    h, e = P[0] + P[2] * s / c, P[1]
    u = 0.0
    for _ in range(_SIDE_STEPS):
        su, cu = np.sin(u), np.cos(u)
        slope = A * h * su - B * e * cu + (B * B - A * A) * su * cu
        bend = A * h * cu + B * e * su + (B * B - A * A) * (cu * cu - su * su)
        step = -slope / bend if bend < 0 else np.sign(slope) * _LONGEST_TURN
        u = min(max(u + min(max(step, -_LONGEST_TURN), _LONGEST_TURN), -_FURTHEST), _FURTHEST)
        if abs(step) < 1e-14:
            break
    x, y = h - A * np.cos(u), e - B * np.sin(u)
    over = D / (2 * np.hypot(x, y))
    point[0], point[1] = over * x, over * y
    # From the peg's axis, along (-s, 0, c), to that point of the rim.
    w = point - P
    along = -s * w[0] + c * w[2]
    w[0] += along * s
    w[2] -= along * c
    length = np.sqrt(np.sum(w * w))
    for j in range(3):
        normal[j] = -w[j] / length
    return length - d / 2


@compiled
def _edge(d, D, s, c, P, side, point, normal):
    """Fill in B1 or B2, the rim against the edge of the peg's end, and return its gap."""
    cu = -P[2] / (d / 2 * s)
    if abs(cu) >= 1.0:
        normal[2] = 1.0
        return CLEAR
    su = side * np.sqrt(1.0 - cu * cu)
    # Where the edge crosses the rim's plane; square to both edges is the normal.
    x, y = P[0] + d / 2 * cu * c, P[1] + d / 2 * su
    r = np.hypot(x, y)
    x, y = x / r, y / r
    point[0], point[1] = D / 2 * x, D / 2 * y
    normal[0], normal[1], normal[2] = -x * su * s, -y * su * s, x * su * c - y * cu
    length = side * np.sqrt(np.sum(normal * normal))
    for j in range(3):
        normal[j] /= length
    return (D / 2 - r) * su * s / length
