"""Whether a reaction passes its limit, now or ahead: each reaction as a trend of its own."""

from math import exp, sqrt

import numpy as np

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.trend import CHANNEL, carry, correct

# A reaction changes within the first by as much as it is; what its rate changes lasts for the
# second [s].
_CHANGES, _MEMORY = 0.2, 0.1
# It is at least this share of its limit for that, so that one from nothing can grow.
_LEAST = 0.1
# A trend goes on as it is but for this share of what its acceleration adds.
_UNCERTAIN = 0.5
# Squared standard deviations beyond which a reaction has jumped.
_JUMP = 40.0
# One that is known to less than this share shows no course, and one known to less than that share
# is as far off for a while.
_KNOWN, _OFF = 1.0 / 3.0, 0.1
SIZE = 3 * CHANNEL
# So many standard deviations over: surely not.
NOTHING = -40.0
# Where a channel's first variance stands; 0: it has not begun.
_VARIANCE = 3


@compiled
def forget(m: np.ndarray, at: int) -> None:
    """Begin anew with the next reactions."""
    for i in range(3):
        m[at + CHANNEL * i + _VARIANCE] = 0.0


@compiled
def follow_load(
    m: np.ndarray, at: int, i: int, normal: float, variance: float, limit: float, dt: float
) -> bool:
    """
    Take a reaction.

    Parameters
    ----------
    m : ndarray
        Memory, of which SIZE places from `at` on.
    at, i : int
        i: 0, 1, 2 for K, B1, B2.
    normal, variance, limit : float
        [N], [N^2], [N].
    dt : float
        Since the last one [s].

    Returns
    -------
    bool
        Whether it has jumped.

    """
    a = at + CHANNEL * i
    size = max(normal, _LEAST * limit)
    acceleration = size / (_CHANGES * _CHANGES)
    known = variance < (_KNOWN * size) ** 2
    if m[a + _VARIANCE] == 0.0:
        if known:
            _begin(m, a, normal, variance, size)
        return False
    carry(m, a, dt, acceleration, _MEMORY, 0.0)
    if not known:
        if m[a + _VARIANCE] > (_KNOWN * max(m[a], _LEAST * limit)) ** 2:
            # Not determined for long, as at rest: what it says no more where it goes.
            m[a + _VARIANCE] = 0.0
        return False
    off = normal - m[a]
    if off * off > _JUMP * (m[a + _VARIANCE] + variance):
        # A step has no rate.
        _begin(m, a, normal, variance, size)
        return True
    correct(m, a, off, variance, dt, acceleration, _JUMP)
    return False


@compiled
def _begin(m, a, normal, variance, size):
    for n in range(CHANNEL):
        m[a + n] = 0.0
    m[a], m[a + _VARIANCE] = normal, max(variance, 1e-12)
    m[a + 6], m[a + 8] = (size / _CHANGES) ** 2, (size / (_CHANGES * _CHANGES)) ** 2


@compiled
def over_limit(
    m: np.ndarray, at: int, i: int, variance: float, limit: float, horizon: float
) -> float:
    """
    Return by how many standard deviations a reaction is over its limit, now or ahead.

    Parameters
    ----------
    m, at, i, limit
        As for `follow_load`.
    variance : float
        Of the reaction as it was estimated last [N^2].
    horizon : float
        [s]

    """
    a = at + CHANNEL * i
    if m[a + _VARIANCE] == 0.0:
        return NOTHING
    off = m[a + 3] + min(variance, (_OFF * m[a]) ** 2)
    now = (m[a] - limit) / sqrt(max(off, 1e-12))
    u = horizon / _MEMORY
    b = _MEMORY * _MEMORY * (exp(-u) - 1.0 + u)
    ahead = m[a] + horizon * m[a + 1] + b * m[a + 2]
    spread = off + horizon * (2.0 * m[a + 4] + horizon * m[a + 6])
    spread += b * (2.0 * m[a + 5] + 2.0 * horizon * m[a + 7] + b * m[a + 8])
    spread += (_UNCERTAIN * b * m[a + 2]) ** 2
    return max(now, (ahead - limit) / sqrt(max(spread, 1e-12)))
