"""Where a peg that is in a hole, or on its rim, touches: rim against side, edge against wall."""

import numpy as np

from peg_on_hole_ros.mechanics.compiling import compiled

# Slots: two of the rim against the peg's side, two of the peg's lower edge against the wall.
SLOTS = 4
RIM, EDGE = slice(0, 2), slice(2, 4)
# What does not meet is clear of it [m].
CLEAR = 1.0
# Newton's steps to where two curves come nearest, and how far one goes [rad].
_STEPS, _LONGEST = 40, 0.2
# Two places of one pair nearer to one another than the first [rad] share the stiffness of one
# contact, beyond the second each has its own: so nothing jumps where they become one.
_TOGETHER, _APART = 0.5, 1.2


@compiled
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
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
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
        stiffness, 0 to 1.

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
    # Rows of point, normal, gap, azimuth, angle on the ellipse; what the ellipse is, in metres.
    found, form = np.zeros((4, 9)), np.zeros(4)
    count = _rim(d, D, height, s, hx, hy, zeta, P, found, form)
    _into_slots(found, count, form, 0, before, points, normals, gaps, azimuth, share)
    count = _edge(d, D, s, c, hx, hy, P, found, form)
    _into_slots(found, count, form, 2, before, points, normals, gaps, azimuth, share)
    return points, normals, gaps, azimuth, share


@compiled
def _rim(d, D, height, s, hx, hy, zeta, P, found, form):
    """Fill rows and form; return how many rows."""
    along = np.sum(P * zeta)
    Qx, Qy = P[0] - along * zeta[0], P[1] - along * zeta[1]
    form[0], form[1], form[2] = Qx * hx + Qy * hy, Qy * hx - Qx * hy, D / 4 * s * s
    form[3] = 0.0
    number, u = farthest(form[0], form[1], form[2])
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
        row[6], row[7], row[8] = length - d / 2, np.arctan2(y, x), u[i]
        count += 1
    return count


@compiled
def _edge(d, D, s, c, hx, hy, P, found, form):
    """Fill rows and form; return how many rows."""
    radius = d / 2
    Ph, Pe = P[0] * hx + P[1] * hy, P[1] * hx - P[0] * hy
    # By the angle from e, not from h: the edge is an ellipse that is longest across the tilt.
    form[0], form[1], form[2] = Pe, c * Ph, radius / 2 * s * s
    form[3] = max(P[2] + radius * s, 0.0)
    number, v = farthest(form[0], form[1], form[2])
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
        row[6], row[7], row[8] = D / 2 - r, np.arctan2(row[1], row[0]), v[i]
        count += 1
    if abs(P[2]) >= radius * s:
        return count
    cu = -P[2] / (radius * s)
    for side in (-1.0, 1.0):
        su = side * np.sqrt(1.0 - cu * cu)
        slope = Pe * cu - c * Ph * su + 2 * form[2] * su * cu
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
        row[8] = np.pi / 2 - np.arctan2(su, cu)
        count += 1
    return count


@compiled
def _height(alpha, beta, kappa, u):
    return alpha * np.cos(u) + beta * np.sin(u) + kappa * np.cos(u) ** 2


@compiled
def _shares(alpha, beta, kappa, u, v, between):
    """
    Return the shares of one contact's stiffness of two neighbouring places, the nearer first.

    A place that is about to vanish, as no hollow parts it from the nearer one any more, has no
    share left. `between` [m] is what else parts the two: an edge that rises above the rim.

    """
    apart = np.arccos(min(max(np.cos(u - v), -1.0), 1.0))
    if apart >= _APART:
        return 1.0, 1.0
    x = max(apart - _TOGETHER, 0.0) / (_APART - _TOGETHER)
    near = 1 - x * x * (3 - 2 * x)
    middle = np.arctan2(np.sin(u) + np.sin(v), np.cos(u) + np.cos(v))
    low = _climb(-alpha, -beta, -kappa, middle)
    high, lower = _height(alpha, beta, kappa, u), _height(alpha, beta, kappa, v)
    hollow = between
    if np.cos(low - middle) > np.cos(apart / 2):
        hollow += max(lower - _height(alpha, beta, kappa, low), 0.0)
    difference = max(high - lower, 0.0)
    parted = hollow / (hollow + difference) if hollow + difference > 0 else 1.0
    return 1 - 0.5 * near * parted, 0.5 * near * parted + 1 - near


@compiled
def _into_slots(found, count, form, first, before, points, normals, gaps, azimuth, share):
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
    shares = (1.0, 1.0)
    if two >= 0:
        near_one -= np.cos(found[two, 7] - before[first]) - np.cos(
            found[two, 7] - before[first + 1]
        )
        shares = _shares(form[0], form[1], form[2], found[one, 8], found[two, 8], form[3])
    slot = first if near_one >= 0 else first + 1
    other = 2 * first + 1 - slot
    for k, i, weight in ((slot, one, shares[0]), (other, two, shares[1])):
        if i < 0:
            continue
        points[k], normals[k] = found[i, 0:3], found[i, 3:6]
        gaps[k], azimuth[k], share[k] = found[i, 6], found[i, 7], weight
