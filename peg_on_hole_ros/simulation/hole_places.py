"""Where a peg that is in a hole, or on its rim, touches: rim against side, edge against wall."""

import numpy as np
from numba import njit

# Slots: two of the rim against the peg's side, two of the peg's lower edge against the wall.
SLOTS = 4
RIM, EDGE = slice(0, 2), slice(2, 4)
# What does not meet is clear of it [m].
CLEAR = 1.0
# Newton's steps to where two curves come nearest, and how far one goes [rad].
_STEPS, _LONGEST = 40, 0.2
# Two places of one pair nearer to one another than this [rad] share a contact's stiffness, so
# that nothing jumps where they become one.
_APART = 0.5


@njit(cache=True)
def _climb(alpha, beta, kappa, u):
    """Return the local maximum of alpha cos u + beta sin u + kappa cos(u)^2 uphill of u."""
    for _ in range(_STEPS):
        su, cu = np.sin(u), np.cos(u)
        slope = beta * cu - alpha * su - 2 * kappa * su * cu
        bend = -alpha * cu - beta * su - 2 * kappa * (cu * cu - su * su)
        step = -slope / bend if bend < 0 else np.sign(slope) * _LONGEST
        step = min(max(step, -_LONGEST), _LONGEST)
        u += step
        if abs(step) < 1e-13:
            break
    return u


@njit(cache=True)
def farthest(alpha, beta, kappa):
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


@njit(cache=True)
def touching_places(p, height, C, R, before):
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
    points, normals : ndarray, shape (4, 3)
        Rows: two on the rim, two on the edge [m]; on the peg, unit length; hole axes.
    gaps, azimuth, share : ndarray, shape (4,)
        [m], negative where pressed in, CLEAR where there is no such place; [rad]; of a contact's
        stiffness, 0.5 to 1.

    Notes
    -----
    Seen along the hole both pairs of curves are an ellipse in a circle: their distance has one
    local minimum or two. A place of the edge that would lie above the rim is replaced by where
    the edge crosses the rim, as B1 and B2 of three-point contact do; normals are those of edge
    against edge there.

    """
    d, D = p[0], p[1]
    points, normals = np.zeros((SLOTS, 3)), np.zeros((SLOTS, 3))
    gaps, share = np.full(SLOTS, CLEAR), np.ones(SLOTS)
    azimuth = before.copy()
    normals[:, 2] = 1.0
    zeta = R[:, 2].copy()
    s, c = np.hypot(zeta[0], zeta[1]), zeta[2]
    hx, hy = (-zeta[0] / s, -zeta[1] / s) if s > 1e-12 else (1.0, 0.0)
    P = C - p[2] * zeta
    found = np.zeros((4, 8))
    count = _rim(d, D, height, s, hx, hy, zeta, P, found)
    _into_slots(found, count, 0, before, points, normals, gaps, azimuth, share)
    count = _edge(d, D, s, c, hx, hy, P, found)
    _into_slots(found, count, 2, before, points, normals, gaps, azimuth, share)
    return points, normals, gaps, azimuth, share


@njit(cache=True)
def _rim(d, D, height, s, hx, hy, zeta, P, found):
    """Fill rows of point, normal, gap, azimuth; return how many."""
    along = np.sum(P * zeta)
    Qx, Qy = P[0] - along * zeta[0], P[1] - along * zeta[1]
    number, u = farthest(
        D * (Qx * hx + Qy * hy), D * (Qy * hx - Qx * hy), D * D / 4 * s * s
    )
    count = 0
    for i in range(number):
        cu, su = np.cos(u[i]), np.sin(u[i])
        x, y = D / 2 * (cu * hx - su * hy), D / 2 * (cu * hy + su * hx)
        wx, wy, wz = x - P[0], y - P[1], -P[2]
        up = wx * zeta[0] + wy * zeta[1] + wz * zeta[2]
        if up < 0 or up > height:
            continue
        wx, wy, wz = wx - up * zeta[0], wy - up * zeta[1], wz - up * zeta[2]
        length = np.sqrt(wx * wx + wy * wy + wz * wz)
        row = found[count]
        row[0], row[1], row[2] = x, y, 0.0
        row[3], row[4], row[5] = -wx / length, -wy / length, -wz / length
        row[6], row[7] = length - d / 2, np.arctan2(y, x)
        count += 1
    return count


@njit(cache=True)
def _edge(d, D, s, c, hx, hy, P, found):
    """Fill rows of point, normal, gap, azimuth; return how many."""
    radius = d / 2
    Ph, Pe = P[0] * hx + P[1] * hy, P[1] * hx - P[0] * hy
    kappa = radius * radius * s * s
    # cos^2 of the other angle: the edge is an ellipse that is longest across the tilt.
    number, v = farthest(2 * radius * Pe, 2 * radius * c * Ph, kappa)
    count = 0
    for i in range(number):
        u = np.pi / 2 - v[i]
        z = P[2] + radius * s * np.cos(u)
        if z > 0:
            continue
        h, e = Ph + radius * c * np.cos(u), Pe + radius * np.sin(u)
        r = np.hypot(h, e)
        row = found[count]
        row[0], row[1], row[2] = h * hx - e * hy, h * hy + e * hx, z
        row[3], row[4], row[5] = -row[0] / r, -row[1] / r, 0.0
        row[6], row[7] = D / 2 - r, np.arctan2(row[1], row[0])
        count += 1
    if abs(P[2]) >= radius * s:
        return count
    cu = -P[2] / (radius * s)
    for side in (-1.0, 1.0):
        su = side * np.sqrt(1.0 - cu * cu)
        slope = 2 * radius * (Pe * cu - c * Ph * su) + 2 * kappa * su * cu
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
        row = found[count]
        row[0], row[1], row[2] = D / 2 * (ch * hx - ce * hy), D / 2 * (ch * hy + ce * hx), 0.0
        row[3], row[4], row[5] = nh * hx - ne * hy, nh * hy + ne * hx, nz
        row[6], row[7] = (D / 2 - r) * -(nh * ch + ne * ce), np.arctan2(row[1], row[0])
        count += 1
    return count


@njit(cache=True)
def _into_slots(found, count, first, before, points, normals, gaps, azimuth, share):
    """Give the two nearest of what was found to the slots that they were in."""
    if count == 0:
        return
    one = 0
    for i in range(1, count):
        if found[i, 6] < found[one, 6]:
            one = i
    two = -1
    for i in range(count):
        if i != one and (two < 0 or found[i, 6] < found[two, 6]):
            two = i
    near_one = np.cos(found[one, 7] - before[first]) - np.cos(found[one, 7] - before[first + 1])
    if two >= 0:
        near_one -= np.cos(found[two, 7] - before[first]) - np.cos(
            found[two, 7] - before[first + 1]
        )
    slot = first if near_one >= 0 else first + 1
    other = 2 * first + 1 - slot
    weight = 1.0
    if two >= 0:
        apart = np.arccos(min(max(np.cos(found[one, 7] - found[two, 7]), -1.0), 1.0)) / _APART
        if apart < 1:
            weight = 0.5 + 0.5 * apart * apart * (3 - 2 * apart)
    for k, i in ((slot, one), (other, two)):
        if i < 0:
            continue
        points[k], normals[k] = found[i, 0:3], found[i, 3:6]
        gaps[k], azimuth[k], share[k] = found[i, 6], found[i, 7], weight
