"""Friction and peg diameter beside the state: learnt from orientations, or only considered."""

from math import asin, sqrt

from peg_on_hole_ros.estimation.kernel.acceleration import SHORTEST_TIME
from peg_on_hole_ros.estimation.kernel.memory import (
    CROSS,
    GAIN,
    HELD_BACK,
    INTERVAL,
    LEARNT,
    OFFSETS,
    RESIDUAL,
    ROWS,
    SCENE,
    SLIDING,
    SPREAD,
    WITH,
    S,
)
from peg_on_hole_ros.mechanics.kernel import compiled, inlined

# What is learnt stays a peg on a hole with friction [-], [m].
LEAST_FRICTION, MOST_FRICTION = 1e-3, 2.0
LEAST_CLEARANCE = 1e-7
# Friction and peg diameter lie on a ridge where either, were the other known, would be known to
# less than this share of its variance; they are then learnt with a share of the optimal gain.
# Chosen on pure align: with 0.5 friction at 0.5 is learnt too slowly, with 0.15 bounds fail.
RIDGE = 0.3
ALONG_RIDGE = 0.3
# After a correction friction is known no better than to this share of what that has moved it by
# (not beside an uncertain bias or tilt, where it moves by a tenth of the gain).
# Chosen where align at 1 rad/s begins with a friction 2.3 standard deviations too high: with 0.2
# it is thrown past the true one and is 5 deviations off, with 0.6 it is learnt more slowly.
BENT = 0.4
# A peg diameter is learnt where a second of such corrections would tell it to this [m], or where
# they lower its variance at this rate [1/s]. Where they tell less, as in pure align at low
# friction, what the model leaves out moves it further. At 1.6 um align at f 0.5 no longer learns
# it in time; a clearance that is stated to a tenth of a millimetre is told by the rate.
TOLD_IN_A_SECOND = 2.5e-6
TOLD_AT = 30.0


@inlined
def friction_known_to(m, share):
    """Return whether a standard deviation of friction is no more than a share of it."""
    most = share * m[SCENE + 7]
    return m[SPREAD] <= most * most


@inlined
def learns_clearance(m):
    """Return whether the peg diameter is corrected, and not known."""
    return m[LEARNT + 1] * m[SPREAD + 3] > 0.0


@inlined
def learns_bias(m):
    """Return whether a bias of the sensor is corrected, and not known."""
    return m[OFFSETS + 2] > 0.0


@inlined
def learns_geometry_or_bias(m):
    """Return whether clearance, bias or tilt is learnt: constants that steps alone tell well."""
    return learns_clearance(m) or learns_bias(m) or m[OFFSETS + 3] > 0.0


@inlined
def learning_share(ff, fd, dd):
    """
    Return the share of the optimal gain with which what is learnt of the two is learnt.

    Where a motion tells what they make together far better than either, as pure align does, the
    tangent of the ridge turns while they move along it, and with its full gain the filter takes
    that for knowledge of each.

    Parameters
    ----------
    ff, fd, dd : float
        Variance of friction [-], its covariance with the peg diameter [m], and the variance of
        that [m^2].

    """
    return ALONG_RIDGE if ff * dd - fd * fd < RIDGE * ff * dd else 1.0


@inlined
def learnt_variance(variance, before, moved):
    """
    Return the variance of friction after a correction.

    What it does to a motion is far from linear near the friction that would wedge the peg: a
    tangent that moves it far has told less than it seems.

    Parameters
    ----------
    variance : float
        As the tangent has it.
    before : float
        Before the correction.
    moved : float
        By how much the correction has moved friction.

    """
    return max(variance, min(before, BENT * BENT * moved * moved))


@inlined
def tells_diameter(variance, told, interval):
    """
    Return whether a correction tells enough of a peg diameter to change it.

    Parameters
    ----------
    variance, told : float
        Of the diameter, and by how much it falls with the optimal gain [m^2].
    interval : float
        Time since the last correction [s].

    """
    left = (variance - told) * max(interval, SHORTEST_TIME)
    return told > left * min(TOLD_AT, variance / (TOLD_IN_A_SECOND * TOLD_IN_A_SECOND))


@compiled
def learning_shares(m):
    """
    Return the shares of the optimal gain for friction and peg diameter, and fill HELD_BACK.

    The memory m holds the innovation's factor S, as `correction.innovation` leaves it.
    """
    share = learning_share(m[SPREAD], m[SPREAD + 1], m[SPREAD + 3])
    of_friction, of_diameter = share * m[LEARNT], 0.0
    if learns_clearance(m):
        w0 = m[CROSS + 12] / m[S]
        w1 = (m[CROSS + 13] - m[S + 3] * w0) / m[S + 4]
        w2 = (m[CROSS + 14] - m[S + 6] * w0 - m[S + 7] * w1) / m[S + 8]
        if tells_diameter(m[SPREAD + 3], w0 * w0 + w1 * w1 + w2 * w2, m[INTERVAL]):
            of_diameter = share
    partly = (of_friction < 1.0 and m[SPREAD] > 0.0) or (of_diameter < 1.0 and m[SPREAD + 3] > 0.0)
    m[HELD_BACK] = m[SLIDING] if partly else 0.0
    return m[SLIDING] * of_friction, m[SLIDING] * of_diameter


@compiled
def correct_parameters(m):
    """
    Correct friction and peg diameter, or let their spread count only (Schmidt's filter).

    With the optimal gain K of state and wrench, their covariance with a parameter falls by
    K H times it whether the parameter itself is corrected or not. Only a peg that surely slides
    at all contacts tells of them: elsewhere friction may point anywhere.
    """
    of_friction, of_diameter = learning_shares(m)
    l10, l20, l21 = m[S + 3], m[S + 6], m[S + 7]
    o0, o1, o2 = 1.0 / m[S], 1.0 / m[S + 4], 1.0 / m[S + 8]
    for k in range(2):
        at = CROSS + 12 * k
        t0, t1, t2 = m[at], m[at + 1], m[at + 2]
        g0 = t0 * o0
        g1 = (t1 - l10 * g0) * o1
        g2 = (t2 - l20 * g0 - l21 * g1) * o2 * o2
        g1 = (g1 - l21 * g2) * o1
        g0 = (g0 - l10 * g1 - l20 * g2) * o0
        m[WITH + 3 * k], m[WITH + 3 * k + 1], m[WITH + 3 * k + 2] = g0, g1, g2
    before, moved = m[SPREAD], of_friction * _gained(m, 0)
    move_parameters(m, moved, of_diameter * _gained(m, 1))
    for k in range(2):
        for n in range(2):
            # Joseph's form for shares of the optimal gain.
            left_k = 1.0 - (of_friction if k == 0 else of_diameter)
            left_n = 1.0 - (of_friction if n == 0 else of_diameter)
            m[ROWS + 2 * k + n] = (1.0 - left_k * left_n) * (
                m[WITH + 3 * k] * m[CROSS + 12 * n]
                + m[WITH + 3 * k + 1] * m[CROSS + 12 * n + 1]
                + m[WITH + 3 * k + 2] * m[CROSS + 12 * n + 2]
            )
    for k in range(4):
        m[SPREAD + k] -= m[ROWS + k]
    m[SPREAD] = learnt_variance(m[SPREAD], before, moved)
    off = 0.5 * (m[SPREAD + 1] + m[SPREAD + 2])
    m[SPREAD + 1] = m[SPREAD + 2] = off
    for k in range(2):
        at = CROSS + 12 * k
        t0, t1, t2 = m[at], m[at + 1], m[at + 2]
        for i in range(12):
            m[at + i] -= m[GAIN + i] * t0 + m[GAIN + 12 + i] * t1 + m[GAIN + 24 + i] * t2


@inlined
def _gained(m, k):
    at = WITH + 3 * k
    return m[at] * m[RESIDUAL] + m[at + 1] * m[RESIDUAL + 1] + m[at + 2] * m[RESIDUAL + 2]


@inlined
def move_parameters(m, by_friction, by_diameter):
    """Add to friction [-] and peg diameter [m], which stay a peg's on a hole."""
    m[SCENE + 7] = min(max(m[SCENE + 7] + by_friction, LEAST_FRICTION), MOST_FRICTION)
    if m[LEARNT + 1] * m[SLIDING] > 0.0:
        move_diameter(m, by_diameter)


@inlined
def move_diameter(m, by_diameter):
    """Add to the peg diameter [m], which stays below the hole's."""
    hole = m[SCENE + 1]
    m[SCENE] = min(m[SCENE] + by_diameter, hole - LEAST_CLEARANCE)
    m[SCENE + 3] = 2.0 * asin(sqrt((hole - m[SCENE]) / (2.0 * hole)))
