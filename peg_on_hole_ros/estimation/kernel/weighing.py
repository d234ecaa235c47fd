"""Answers of the six equations weighed against how fast a held peg can accelerate."""

from peg_on_hole_ros.estimation.kernel.acceleration import LEAST, acceleration_variance
from peg_on_hole_ros.estimation.kernel.memory import (
    ACCELERATION,
    ANSWERS,
    FRICTION,
    LASTING,
    REACTIONS,
    SURPRISE,
)
from peg_on_hole_ros.mechanics.kernel import inlined

# Three squared normal variables stay below it in 97 of 100 cases.
SURPRISE_LIMIT = 9.0


@inlined
def weigh_accelerations(m, ways, uncertain, acceleration_stddev):
    """
    Correct an answer and its covariance by what a held peg can accelerate; fill SURPRISE.

    Parameters
    ----------
    m : ndarray
        Memory: the answer at ANSWERS, its covariance at REACTIONS, what friction and peg diameter
        make of it at LASTING. SURPRISE is how far its accelerations are from those, squared.
    ways : int
        How many of FRICTION there are: what else moves the answer, a standard deviation each.
    uncertain : bool
        Whether friction or peg diameter take part.
    acceleration_stddev : float
        As for `reactions.react`.

    """
    m[SURPRISE] = 0.0
    # One acceleration at a time: three scalar updates need no matrix inverse.
    for a in range(3):
        expected = m[ACCELERATION + a]
        variance = acceleration_variance(m, a, acceleration_stddev, LEAST)
        off = m[ANSWERS + a] - expected
        m[SURPRISE] += off * off / (m[REACTIONS + 7 * a] + variance)
        _weigh(m, a, expected, variance, ways, uncertain)


@inlined
def weigh_loads(m, expected, stddev, uncertain):
    """
    Correct an answer and its covariance by what the reactions may be.

    Parameters
    ----------
    m, uncertain
        As for `weigh_accelerations`.
    expected, stddev : float
        Of each reaction, apart from the others [N].

    """
    for i in range(3):
        _weigh(m, 3 + i, expected, stddev * stddev, 0, uncertain)


@inlined
def _weigh(m, k, expected, variance, ways, uncertain):
    """Correct all by what one of Y is expected to be, within a variance."""
    at = REACTIONS + 6 * k
    column = (m[at], m[at + 1], m[at + 2], m[at + 3], m[at + 4], m[at + 5])
    over = 1.0 / (m[at + k] + variance)
    off = m[ANSWERS + k] - expected
    for i in range(6):
        m[ANSWERS + i] -= column[i] * over * off
    for n in range(2 if uncertain else 0):
        shared = m[LASTING + 6 * n + k] * over
        for i in range(6):
            m[LASTING + 6 * n + i] -= column[i] * shared
    for n in range(ways):
        shared = m[FRICTION + 6 * n + k] * over
        for i in range(6):
            m[FRICTION + 6 * n + i] -= column[i] * shared
    for i in range(6):
        weight = column[i] * over
        for j in range(i + 1):
            value = m[REACTIONS + 6 * i + j] - weight * column[j]
            m[REACTIONS + 6 * i + j] = value
            m[REACTIONS + 6 * j + i] = value
