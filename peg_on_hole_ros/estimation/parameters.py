"""Friction and peg diameter beside the state: learnt from orientations, or only considered."""

from math import asin, sqrt

from peg_on_hole_ros.estimation.memory import (
    CROSS,
    GAIN,
    LEARNT,
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


@compiled
def correct_parameters(m):
    """
    Correct friction and peg diameter, or let their spread count only (Schmidt's filter).

    With the optimal gain K of state and wrench, their covariance with a parameter falls by
    K H times it whether the parameter itself is corrected or not. Only a peg that surely slides
    at all contacts tells of them: elsewhere friction may point anywhere.
    """
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
        learnt = m[LEARNT + k] * m[SLIDING]
        m[WITH + 3 * k], m[WITH + 3 * k + 1], m[WITH + 3 * k + 2] = (
            learnt * g0,
            learnt * g1,
            learnt * g2,
        )
    move_parameters(m, _gained(m, 0), _gained(m, 1))
    for k in range(2):
        for n in range(2):
            # The gain of whichever of the two is corrected; of both it is the same product.
            by, of = (k, n) if m[LEARNT + k] * m[SLIDING] > 0.0 else (n, k)
            m[ROWS + 2 * k + n] = (
                m[WITH + 3 * by] * m[CROSS + 12 * of]
                + m[WITH + 3 * by + 1] * m[CROSS + 12 * of + 1]
                + m[WITH + 3 * by + 2] * m[CROSS + 12 * of + 2]
            )
    for k in range(4):
        m[SPREAD + k] -= m[ROWS + k]
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
        hole = m[SCENE + 1]
        m[SCENE] = min(m[SCENE] + by_diameter, hole - LEAST_CLEARANCE)
        m[SCENE + 3] = 2.0 * asin(sqrt((hole - m[SCENE]) / (2.0 * hole)))
