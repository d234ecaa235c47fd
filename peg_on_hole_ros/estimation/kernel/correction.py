"""The correction with an orientation: innovation, widening, and Joseph's form, compiled."""

from math import floor, pi, sqrt

from peg_on_hole_ros.estimation.kernel.memory import (
    GAIN,
    JOSEPH,
    RATES,
    RESIDUAL,
    SPREAD,
    R,
    S,
    X,
    Z,
)
from peg_on_hole_ros.estimation.kernel.parameters import correct_parameters
from peg_on_hole_ros.mechanics.kernel import compiled, inlined


@compiled
def innovation(m, q):
    """
    Fill residual and lower Cholesky factor of the innovation covariance; R is in the memory.

    The measured psi and phi may be off by turns. Returns the normalised innovation squared
    (3 degrees of freedom).
    """
    for i in range(3):
        residual = q[i] - m[X + i]
        turns = 0.0 if i == 0 else floor(residual / (2.0 * pi) + 0.5)
        m[RESIDUAL + i] = residual - 2.0 * pi * turns
        for j in range(i + 1):
            total = m[Z + 12 * i + j] + m[R + 3 * i + j]
            for k in range(j):
                total -= m[S + 3 * i + k] * m[S + 3 * j + k]
            m[S + 3 * i + j] = sqrt(total) if i == j else total / m[S + 4 * j]
    w0, w1, w2 = white_innovation(m)
    return w0 * w0 + w1 * w1 + w2 * w2


@inlined
def white_innovation(m):
    """Return the innovation in the memory over the lower root of its covariance."""
    w0 = m[RESIDUAL] / m[S]
    w1 = (m[RESIDUAL + 1] - m[S + 3] * w0) / m[S + 4]
    return w0, w1, (m[RESIDUAL + 2] - m[S + 6] * w0 - m[S + 7] * w1) / m[S + 8]


@compiled
def widen_rates(m, dt, factor):
    """
    Widen as if the rates had been less well known since the last correction, dt [s] ago.

    Adds factor times the rates' covariance, and what it would have carried into the angles: a gain
    for the rates that overshoots, as scaling their rows and columns alone gives, is excluded.
    """
    for i in range(3):
        for j in range(3):
            added = factor * m[RATES + 12 * i + j]
            m[Z + 12 * i + j] += dt * dt * added
            m[Z + 12 * (3 + i) + j] += dt * added
            m[Z + 12 * i + 3 + j] += dt * added
    for i in range(3):
        for j in range(3):
            m[RATES + 12 * i + j] *= 1.0 + factor


@compiled
def correct(m):
    """
    Correct with an orientation, in Joseph's form on the joint covariance.

    State, held wrench and joint covariance are changed: an orientation also tells something of
    the noise in the wrench that led to it. Residual, Cholesky factor and R are those that
    `innovation` left in the memory.
    """
    l10, l20, l21 = m[S + 3], m[S + 6], m[S + 7]
    o0, o1, o2 = 1.0 / m[S], 1.0 / m[S + 4], 1.0 / m[S + 8]
    e0, e1, e2 = m[RESIDUAL], m[RESIDUAL + 1], m[RESIDUAL + 2]
    for i in range(12):
        g0 = m[Z + i] * o0
        g1 = (m[Z + 12 + i] - l10 * g0) * o1
        g2 = (m[Z + 24 + i] - l20 * g0 - l21 * g1) * o2 * o2
        g1 = (g1 - l21 * g2) * o1
        g0 = (g0 - l10 * g1 - l20 * g2) * o0
        m[GAIN + i], m[GAIN + 12 + i], m[GAIN + 24 + i] = g0, g1, g2
    # The wrench follows the state in the memory.
    for i in range(12):
        m[X + i] += m[GAIN + i] * e0 + m[GAIN + 12 + i] * e1 + m[GAIN + 24 + i] * e2
    if m[SPREAD] > 0.0 or m[SPREAD + 3] > 0.0:
        correct_parameters(m)
    for i in range(12):
        g0, g1, g2 = m[GAIN + i], m[GAIN + 12 + i], m[GAIN + 24 + i]
        for j in range(12):
            m[JOSEPH + 12 * i + j] = m[Z + 12 * i + j] - (
                g0 * m[Z + j] + g1 * m[Z + 12 + j] + g2 * m[Z + 24 + j]
            )
    for i in range(12):
        g0, g1, g2 = m[GAIN + i], m[GAIN + 12 + i], m[GAIN + 24 + i]
        at = JOSEPH + 12 * i
        k0 = g0 * m[R] + g1 * m[R + 3] + g2 * m[R + 6] - m[at]
        k1 = g0 * m[R + 1] + g1 * m[R + 4] + g2 * m[R + 7] - m[at + 1]
        k2 = g0 * m[R + 2] + g1 * m[R + 5] + g2 * m[R + 8] - m[at + 2]
        for j in range(12):
            m[Z + 12 * i + j] = m[at + j] + (
                k0 * m[GAIN + j] + k1 * m[GAIN + 12 + j] + k2 * m[GAIN + 24 + j]
            )
    for i in range(12):
        for j in range(i):
            m[Z + 12 * j + i] = m[Z + 12 * i + j]
