"""Where a peg that is in a hole, or on its rim, touches: rim against side, edge against wall."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.compiling import compiled

# Slots: two of the rim against the peg's side, two of the peg's lower edge against the wall.
SLOTS = 4
RIM_SLOTS, EDGE_SLOTS = slice(0, 2), slice(2, 4)
# What does not meet is clear of it [m].
CLEAR = 1.0
# Newton's steps to where two curves come nearest, and how far one goes [rad].
_CLIMB_STEPS, _LONGEST_CLIMB = 40, 0.2
# Two places of one pair nearer to one another than the first [rad] share the stiffness of one
# contact, beyond the second each has its own: so nothing jumps where they become one.
_ONE_CONTACT, _TWO_CONTACTS = 0.5, 1.2


class TouchingPlaces(NamedTuple):
    """
    Where a peg touches, or would: a row for each slot, two on the rim and two on the edge.

    Attributes
    ----------
    points, normals : ndarray, shape (4, 3)
        [m]; on the peg, unit length; hole axes.
    gaps : ndarray, shape (4,)
        How far the peg is off there [m], negative where pressed in; CLEAR: no such place.
    azimuth : ndarray, shape (4,)
        [rad]
    share : ndarray, shape (4,)
        Of a contact's stiffness, 0 to 1.

    """

    points: np.ndarray
    normals: np.ndarray
    gaps: np.ndarray
    azimuth: np.ndarray
    share: np.ndarray


class _Pose(NamedTuple):
    """
    A peg in a hole: diameters, height, sine and cosine of its tilt, and where it tilts to.

    `h_x`, `h_y` is the direction of the tilt, `zeta` the peg's axis, `P` the centre of its lower
    end [m].

    """

    d: float
    D: float
    height: float
    s: float
    c: float
    h_x: float
    h_y: float
    zeta: np.ndarray
    P: np.ndarray


class _Nearest(NamedTuple):
    """
    Places found of a pair of curves: a row each, of which `count` are filled in.

    `angle` is where they lie on the ellipse that the pair is [rad]; the rest as in
    `TouchingPlaces`.

    """

    points: np.ndarray
    normals: np.ndarray
    gaps: np.ndarray
    azimuth: np.ndarray
    angle: np.ndarray


class _Ellipse(NamedTuple):
    """
    A pair of curves, seen along the hole: their distance is least where this is greatest.

    alpha cos u + beta sin u + kappa cos(u)^2 [m]; `rise` is how far the edge rises above the rim
    [m].

    """

    alpha: float
    beta: float
    kappa: float
    rise: float


@compiled
def _climb(alpha, beta, kappa, u):
    """Return the local maximum of alpha cos u + beta sin u + kappa cos(u)^2 uphill of u."""
    for _ in range(_CLIMB_STEPS):
        su, cu = np.sin(u), np.cos(u)
        slope = beta * cu - alpha * su - 2 * kappa * su * cu
        bend = -alpha * cu - beta * su - 2 * kappa * (cu * cu - su * su)
        step = -slope / bend if bend < 0 else np.sign(slope) * _LONGEST_CLIMB
        step = min(max(step, -_LONGEST_CLIMB), _LONGEST_CLIMB)
        u += step
        if abs(step) < 1e-13:
            break
    return u


@compiled
def farthest(alpha: float, beta: float, kappa: float) -> tuple[int, np.ndarray]:
    """
    Return the local maxima of alpha cos u + beta sin u + kappa cos(u)^2 over a turn.

    Parameters
    ----------
    alpha, beta, kappa : float
        kappa is not negative.

    Returns
    -------
    count : int
        1 or 2.
    u : ndarray, shape (2,)
        The first is the greatest [rad].

    """
    out = np.empty(2)
    toward = 1.0 if alpha >= 0 else -1.0
    out[0] = _climb(alpha, beta, kappa, np.arctan2(beta, alpha + 2 * kappa * toward))
    # Inside of this astroid there is another on the other side.
    inside = abs(alpha) ** (2 / 3) + abs(beta) ** (2 / 3) < (2 * kappa) ** (2 / 3)
    if not inside:
        return 1, out
    out[1] = _climb(alpha, beta, kappa, np.arctan2(beta, alpha - 2 * kappa * toward))
    if np.cos(out[1] - out[0]) > 1 - 1e-12:
        return 1, out
    return 2, out


@compiled
def touching_places(
    p: np.ndarray, height: float, C: np.ndarray, R: np.ndarray, before: np.ndarray
) -> TouchingPlaces:
    """
    Return where the peg touches, or would, how far off it is there, and along which normals.

    Parameters
    ----------
    p : ndarray
        From `dynamics.scene_numbers`.
    height : float
        Of the peg [m]: its side ends there.
    C : ndarray, shape (3,)
        Mass centre, hole axes [m].
    R : ndarray, shape (3, 3)
        Peg axes in hole axes.
    before : ndarray, shape (4,)
        Azimuth of each slot lately [rad]: a contact keeps its slot.

    Returns
    -------
    TouchingPlaces

    Notes
    -----
    Seen along the hole both pairs of curves are an ellipse in a circle: their distance has one
    local minimum or two. A place of the edge that would lie above the rim is replaced by where
    the edge crosses the rim, as B1 and B2 of three-point contact do; normals are those of edge
    against edge there.

    """
    slots = TouchingPlaces(
        np.zeros((SLOTS, 3)),
        np.zeros((SLOTS, 3)),
        np.full(SLOTS, CLEAR),
        before.copy(),
        np.ones(SLOTS),
    )
    slots.normals[:, 2] = 1.0
    zeta = R[:, 2].copy()
    s = np.hypot(zeta[0], zeta[1])
    h_x, h_y = (-zeta[0] / s, -zeta[1] / s) if s > 1e-12 else (1.0, 0.0)
    pose = _Pose(p[0], p[1], height, s, zeta[2], h_x, h_y, zeta, C - p[2] * zeta)
    found = _Nearest(np.zeros((4, 3)), np.zeros((4, 3)), np.zeros(4), np.zeros(4), np.zeros(4))
    count, ellipse = _rim(pose, found)
    _into_slots(found, count, ellipse, 0, before, slots)
    count, ellipse = _edge(pose, found)
    _into_slots(found, count, ellipse, 2, before, slots)
    return slots


@compiled
def _rim(pose, found):
    """Fill in the places of the rim against the peg's side; return how many, and the ellipse."""
    D, s, h_x, h_y, zeta, P = pose.D, pose.s, pose.h_x, pose.h_y, pose.zeta, pose.P
    along = np.sum(P * zeta)
    Qx, Qy = P[0] - along * zeta[0], P[1] - along * zeta[1]
    ellipse = _Ellipse(Qx * h_x + Qy * h_y, Qy * h_x - Qx * h_y, D / 4 * s * s, 0.0)
    number, u = farthest(ellipse.alpha, ellipse.beta, ellipse.kappa)
    count = 0
    for i in range(number):
        cu, su = np.cos(u[i]), np.sin(u[i])
        x, y = D / 2 * (cu * h_x - su * h_y), D / 2 * (cu * h_y + su * h_x)
        wx, wy, wz = x - P[0], y - P[1], -P[2]
        up = wx * zeta[0] + wy * zeta[1] + wz * zeta[2]
        if up < 0 or up > pose.height:
            continue
        wx, wy, wz = wx - up * zeta[0], wy - up * zeta[1], wz - up * zeta[2]
        length = np.sqrt(wx * wx + wy * wy + wz * wz)
        _put(found.points, count, x, y, 0.0)
        _put(found.normals, count, -wx / length, -wy / length, -wz / length)
        found.gaps[count], found.azimuth[count] = length - pose.d / 2, np.arctan2(y, x)
        found.angle[count] = u[i]
        count += 1
    return count, ellipse


@compiled
def _put(rows, i, x, y, z):
    rows[i, 0], rows[i, 1], rows[i, 2] = x, y, z


@compiled
def _edge(pose, found):
    """Fill in the places of the lower edge against the wall; return how many, and the ellipse."""
    D, s, c, h_x, h_y, P = pose.D, pose.s, pose.c, pose.h_x, pose.h_y, pose.P
    radius = pose.d / 2
    Ph, Pe = P[0] * h_x + P[1] * h_y, P[1] * h_x - P[0] * h_y
    # By the angle from e, not from h: the edge is an ellipse that is longest across the tilt.
    ellipse = _Ellipse(Pe, c * Ph, radius / 2 * s * s, max(P[2] + radius * s, 0.0))
    number, v = farthest(ellipse.alpha, ellipse.beta, ellipse.kappa)
    count = 0
    for i in range(number):
        u = np.pi / 2 - v[i]
        z = P[2] + radius * s * np.cos(u)
        if z > 0:
            continue
        h, e = Ph + radius * c * np.cos(u), Pe + radius * np.sin(u)
        r = np.hypot(h, e)
        x, y = h * h_x - e * h_y, h * h_y + e * h_x
        _put(found.points, count, x, y, z)
        _put(found.normals, count, -x / r, -y / r, 0.0)
        found.gaps[count], found.azimuth[count] = D / 2 - r, np.arctan2(y, x)
        found.angle[count] = v[i]
        count += 1
    if abs(P[2]) >= radius * s:
        return count, ellipse
    cu = -P[2] / (radius * s)
    for side in (-1.0, 1.0):
        su = side * np.sqrt(1.0 - cu * cu)
        slope = Pe * cu - c * Ph * su + 2 * ellipse.kappa * su * cu
        if slope * side >= 0 or count == 4:
            # Further down the edge is nearer to the wall: that place is a row of its own.
            continue
        h, e = Ph + radius * c * cu, Pe + radius * su
        r = np.hypot(h, e)
        ch, ce = h / r, e / r
        # Square to both edges, and into the peg.
        nh, ne, nz = -ch * su * s * side, -ce * su * s * side, (ch * su * c - ce * cu) * side
        length = np.sqrt(nh * nh + ne * ne + nz * nz)
        if length < 1e-12:
            nh, ne, nz, length = -ch, -ce, 0.0, 1.0
        nh, ne, nz = nh / length, ne / length, nz / length
        x, y = D / 2 * (ch * h_x - ce * h_y), D / 2 * (ch * h_y + ce * h_x)
        _put(found.points, count, x, y, 0.0)
        _put(found.normals, count, nh * h_x - ne * h_y, nh * h_y + ne * h_x, nz)
        found.gaps[count] = (D / 2 - r) * -(nh * ch + ne * ce)
        found.azimuth[count] = np.arctan2(y, x)
        found.angle[count] = np.pi / 2 - np.arctan2(su, cu)
        count += 1
    return count, ellipse


@compiled
def _height(ellipse, u):
    alpha, beta, kappa, _ = ellipse
    return alpha * np.cos(u) + beta * np.sin(u) + kappa * np.cos(u) ** 2


@compiled
def _shares(ellipse, u, v):
    """
    Return the shares of one contact's stiffness of two neighbouring places, the nearer first.

    A place that is about to vanish, as no hollow parts it from the nearer one any more, has no
    share left. An edge that rises above the rim parts the two as well.

    """
    apart = np.arccos(min(max(np.cos(u - v), -1.0), 1.0))
    if apart >= _TWO_CONTACTS:
        return 1.0, 1.0
    x = max(apart - _ONE_CONTACT, 0.0) / (_TWO_CONTACTS - _ONE_CONTACT)
    near = 1 - x * x * (3 - 2 * x)
    middle = np.arctan2(np.sin(u) + np.sin(v), np.cos(u) + np.cos(v))
    low = _climb(-ellipse.alpha, -ellipse.beta, -ellipse.kappa, middle)
    high, lower = _height(ellipse, u), _height(ellipse, v)
    hollow = ellipse.rise
    if np.cos(low - middle) > np.cos(apart / 2):
        hollow += max(lower - _height(ellipse, low), 0.0)
    difference = max(high - lower, 0.0)
    parted = hollow / (hollow + difference) if hollow + difference > 0 else 1.0
    return 1 - 0.5 * near * parted, 0.5 * near * parted + 1 - near


@compiled
def _into_slots(found, count, ellipse, first, before, slots):
    """Put the two nearest of the places found into the slots that they were in."""
    if count == 0:
        return
    gaps, azimuth = found.gaps, found.azimuth
    one = 0
    for i in range(1, count):
        if gaps[i] < gaps[one]:
            one = i
    two = -1
    for i in range(count):
        if i != one and (two < 0 or gaps[i] < gaps[two]):
            two = i
    near_one = np.cos(azimuth[one] - before[first]) - np.cos(azimuth[one] - before[first + 1])
    shares = (1.0, 1.0)
    if two >= 0:
        near_one -= np.cos(azimuth[two] - before[first]) - np.cos(azimuth[two] - before[first + 1])
        shares = _shares(ellipse, found.angle[one], found.angle[two])
    slot = first if near_one >= 0 else first + 1
    other = 2 * first + 1 - slot
    for k, i, weight in ((slot, one, shares[0]), (other, two, shares[1])):
        if i < 0:
            continue
        slots.points[k], slots.normals[k] = found.points[i], found.normals[i]
        slots.gaps[k], slots.azimuth[k], slots.share[k] = gaps[i], azimuth[i], weight
