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
# Where what else is followed lies after an acceleration.
_RATES_BEFORE, _BEFORE = RATES_BEFORE - ACCELERATION, ACCELERATION_BEFORE - ACCELERATION
_CHANGES, _SEEN = CHANGES - ACCELERATION, CHANGES_SEEN - ACCELERATION
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
    follow_rates_at(m, ACCELERATION, X + 3, dt)
    m[RATES_KNOWN] = 1.0
    m[SINCE_CORRECTION] = 0.0


@inlined
def follow_rates_at(m, at, rates, dt):
    """Let an acceleration at a place of the memory follow rates at another, see there."""
    dt = max(dt, SHORTEST_TIME)
    share = min(dt / FOLLOWED, 1.0) * m[RATES_KNOWN]
    averaged = min(dt / CHANGES_AVERAGED, 1.0) * m[RATES_KNOWN]
    for i in range(at, at + 3):
        rate = m[rates + i - at]
        m[i] += share * ((rate - m[i + _RATES_BEFORE]) / dt - m[i])
        m[i + _RATES_BEFORE] = rate
        change = m[i] - m[i + _BEFORE]
        m[i + _BEFORE] += share * change
        m[i + _CHANGES] += averaged * (change * change - m[i + _CHANGES])
    m[at + _SEEN] += averaged * (1.0 - m[at + _SEEN])


@inlined
def bridged_density(acceleration):
    """Return how a rate that is taken for constant wanders while it accelerates [rad^2/s^3]."""
    return FOLLOWED * acceleration * acceleration


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
