"""Whether friction stops a peg that is pushed on: how its tilt follows the push, both ahead."""

from math import exp, sqrt

import numpy as np

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.contacts import below
from peg_on_hole_ros.monitor.trend import CHANNEL, carry, correct

# A peg on a compliant holder slides where holder and friction balance: its tilt follows the
# holder's program, less what the holder gives way to the push, tilt = program + c push. The push
# is known a hundred times better than the tilt's rate, so c and the push's trend tell when the
# closing ends. docs/jamming.md, "Stall", derives it.

# A push changes within this time by what friction can hold, and its trend lasts for that [s].
_CHANGES, _MEMORY = 0.14, 0.2
# What the program's rate may change by itself [rad/s per root of a second].
_PROGRAM = 0.005
# How far the holder gives way under a push as large as what friction can hold [rad].
_GIVES_WAY = 0.02
# Squared standard deviations beyond which push, and tilt, have jumped.
_PUSH_JUMP, _TILT_JUMP = 40.0, 20.0

# Just after a jump nothing leads anywhere [s].
_CALM = 0.01

# Memory: the push as a channel; tilt, rate of the program, c, and the upper triangle of their
# covariance; the push at the last orientation; for how long neither has jumped.
PUSH, TILT, LAST, CALM = 0, CHANNEL, 2 * CHANNEL, 2 * CHANNEL + 1
SIZE = CALM + 1
# Where a channel's first variance stands; 0: it has not begun.
_VARIANCE = 3


@compiled
def forget(m: np.ndarray, at: int) -> None:
    """Begin anew with the next push and orientation."""
    m[at + PUSH + _VARIANCE] = m[at + TILT + _VARIANCE] = m[at + CALM] = 0.0


@compiled
def follow_push(
    m: np.ndarray, at: int, push: float, variance: float, held: float, dt: float
) -> None:
    """
    Take a push.

    Parameters
    ----------
    m : ndarray
        Memory, of which SIZE places from `at` on.
    at : int
    push, variance : float
        Generalised force that closes the peg [N m], and its variance.
    held : float
        What friction can hold [N m].
    dt : float
        Since the last push [s].

    """
    a = at + PUSH
    acceleration = held / (_CHANGES * _CHANGES)
    if m[a + _VARIANCE] == 0.0:
        for i in range(CHANNEL):
            m[a + i] = 0.0
        m[a], m[a + 3] = push, variance
        m[a + 6], m[a + 8] = (held / _CHANGES) ** 2, acceleration * acceleration
        return
    carry(m, a, dt, acceleration, _MEMORY, 0.0)
    m[at + CALM] += dt
    if correct(m, a, push - m[a], variance, dt, acceleration, _PUSH_JUMP):
        m[at + CALM] = 0.0


@compiled
def follow_tilt(
    m: np.ndarray, at: int, tilt: float, variance: float, held: float, since: float, ago: float
) -> None:
    """
    Take an orientation, after the push.

    Parameters
    ----------
    m, at, held
        As for `follow_push`.
    tilt, variance : float
        As measured [rad], [rad^2].
    since, ago : float
        After the last orientation (below zero: there was none), before the last push [s].

    """
    a = at + TILT
    push = m[at + PUSH] - ago * m[at + PUSH + 1]
    grown = push - m[at + LAST]
    m[at + LAST] = push
    if m[a + _VARIANCE] == 0.0 or since < 0.0:
        for i in range(CHANNEL):
            m[a + i] = 0.0
        m[a], m[a + 3], m[a + 6], m[a + 8] = tilt, variance, 1.0, (_GIVES_WAY / held) ** 2
        return
    p01, p02, p12 = m[a + 4], m[a + 5], m[a + 7]
    m[a] += since * m[a + 1] + grown * m[a + 2]
    c01 = p01 + since * m[a + 6] + grown * p12
    c02 = p02 + since * p12 + grown * m[a + 8]
    m[a + 3] += since * (p01 + c01) + grown * (p02 + c02)
    m[a + 4], m[a + 5] = c01, c02
    m[a + 6] += _PROGRAM * _PROGRAM * since
    # A tilt that jumped has another program.
    if correct(m, a, tilt - m[a], variance, since, 0.0, _TILT_JUMP):
        m[at + CALM] = 0.0


@compiled
def stops_ahead(m: np.ndarray, at: int, horizon: float, rest_rate: float) -> float:
    """Return the probability that the tilt stands still now or a horizon [s] ahead."""
    if m[at + CALM] < _CALM:
        return 0.0
    a, q = at + TILT, at + PUSH
    b = _MEMORY * (1.0 - exp(-horizon / _MEMORY))
    growth = m[q + 1] + b * m[q + 2]
    variance = m[q + 6] + b * (2.0 * m[q + 7] + b * m[q + 8])
    now = _stands(m, a, m[q + 1], m[q + 6], rest_rate)
    return below(max(now, _stands(m, a, growth, variance, rest_rate)))


@compiled
def _stands(m, a, growth, variance, rest_rate):
    """Return by how many standard deviations the tilt is too slow to close the peg."""
    c = m[a + 2]
    rate = m[a + 1] + c * growth
    spread = m[a + 6] + growth * (2.0 * m[a + 7] + growth * m[a + 8]) + c * c * variance
    return (rate + rest_rate) / sqrt(max(spread, 1e-18))
