"""How a held peg accelerates: as it did of late, within how much that has changed of late."""

from peg_on_hole_ros.estimation.kernel.memory import (
    ACCELERATION,
    ACCELERATION_BEFORE,
    CHANGES,
    CHANGES_SEEN,
    RATES_BEFORE,
    RATES_KNOWN,
    SINCE_CORRECTION,
    X,
)
from peg_on_hole_ros.mechanics.kernel import compiled, inlined

# The rates' changes are averaged over this time [s].
FOLLOWED = 0.01
# An acceleration that lasts no longer than that is known to this share of itself.
CHANGED = 0.5
# How much the followed acceleration changes within FOLLOWED is averaged over this time [s].
CHANGES_AVERAGED = 0.05
# However steady it has been, it is known no better than to these shares of what is stated: for
# one answer, and where answers at many instants are averaged, which leaves what they share.
LEAST, LEAST_AVERAGED = 0.05, 0.5
# Two orientations may have one stamp [s].
SHORTEST_TIME = 1e-4


@compiled
def follow_acceleration(m, dt):
    """
    Let the acceleration, and how much it changes, follow the rates after a correction.

    After the first one the rates are no longer unknown, which is no acceleration.

    Parameters
    ----------
    m : ndarray
        Memory, see `memory`.
    dt : float
        Time since the last correction [s].

    """
    dt = max(dt, SHORTEST_TIME)
    share = min(dt / FOLLOWED, 1.0) * m[RATES_KNOWN]
    averaged = min(dt / CHANGES_AVERAGED, 1.0) * m[RATES_KNOWN]
    m[RATES_KNOWN] = 1.0
    for i in range(3):
        now = (m[X + 3 + i] - m[RATES_BEFORE + i]) / dt
        m[ACCELERATION + i] += share * (now - m[ACCELERATION + i])
        m[RATES_BEFORE + i] = m[X + 3 + i]
        change = m[ACCELERATION + i] - m[ACCELERATION_BEFORE + i]
        m[ACCELERATION_BEFORE + i] += share * change
        m[CHANGES + i] += averaged * (change * change - m[CHANGES + i])
    m[CHANGES_SEEN] += averaged * (1.0 - m[CHANGES_SEEN])
    m[SINCE_CORRECTION] = 0.0


@inlined
def bridged_density(m, i):
    """Return how a rate that is taken for constant wanders while it accelerates [rad^2/s^3]."""
    return FOLLOWED * m[ACCELERATION + i] * m[ACCELERATION + i]


@inlined
def acceleration_variance(m, i, stddev, least):
    """
    Return how far an angle's acceleration may be from the followed one, squared [rad^2/s^4].

    As much as that has changed of late, and as stated for what has not been seen: within FOLLOWED
    it lags by what it changes, and its noise changes as much. Half of it is added, as it may end.
    Where no orientation has come for longer than FOLLOWED, less and less of late has been seen.

    Parameters
    ----------
    m : ndarray
        Memory.
    i : int
        The angle's number.
    stddev : float
        What is stated, at most [rad/s^2].
    least : float
        Share of it, at least.

    """
    stated = stddev * stddev
    silent = max(m[SINCE_CORRECTION] - FOLLOWED, 0.0)
    unseen = 1.0 - m[CHANGES_SEEN] + silent / CHANGES_AVERAGED
    seen = m[CHANGES + i] + unseen * stated
    changed = CHANGED * m[ACCELERATION + i]
    return min(stated, max(seen, least * least * stated)) + changed * changed
