"""Whether a reaction passes its limit, now or ahead: each reaction as a trend of its own."""

from math import exp, sqrt

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.trend import Trend, begin, carry, correct, forget_trend, mean_after

# A reaction changes within the first by as much as it is; what its rate changes lasts for the
# second [s].
_CHANGES, _MEMORY = 0.2, 0.1
# It is at least this share of its limit for that, so that one from nothing can grow.
_LEAST = 0.1
# A trend goes on as it is but for this share of what its acceleration adds.
_UNCERTAIN = 0.5
# Squared standard deviations beyond which a reaction has jumped.
_LOAD_JUMP = 40.0
# One that is known to less than this share shows no course, and one known to less than that share
# is as far off for a while.
_KNOWN, _OFF = 1.0 / 3.0, 0.1
# So many standard deviations over: surely not.
NOTHING = -40.0


@compiled
def follow_load(trend: Trend, normal: float, variance: float, limit: float, dt: float) -> bool:
    """
    Take a reaction.

    Parameters
    ----------
    trend : Trend
        Of the reaction; changed.
    normal, variance, limit : float
        [N], [N^2], [N].
    dt : float
        Since the last one [s].

    Returns
    -------
    bool
        Whether it has jumped.

    """
    size = max(normal, _LEAST * limit)
    acceleration = size / (_CHANGES * _CHANGES)
    known = variance < (_KNOWN * size) ** 2
    if trend.p00 == 0.0:
        if known:
            _begin_load(trend, normal, variance, size)
        return False
    carry(trend, dt, acceleration, _MEMORY, 0.0)
    if not known:
        if trend.p00 > (_KNOWN * max(trend.value, _LEAST * limit)) ** 2:
            # Not determined for long, as at rest: what it says no more where it goes.
            forget_trend(trend)
        return False
    off = normal - trend.value
    if off * off > _LOAD_JUMP * (trend.p00 + variance):
        # A step has no rate.
        _begin_load(trend, normal, variance, size)
        return True
    correct(trend, off, variance, dt, acceleration, _LOAD_JUMP)
    return False


@compiled
def _begin_load(trend: Trend, normal: float, variance: float, size: float) -> None:
    rate, acceleration = size / _CHANGES, size / (_CHANGES * _CHANGES)
    begin(trend, normal, max(variance, 1e-12), rate**2, acceleration**2)


@compiled
def over_limit(trend: Trend, variance: float, limit: float, horizon: float) -> float:
    """
    Return by how many standard deviations a reaction is over its limit, now or ahead.

    Parameters
    ----------
    trend, limit
        As for `follow_load`.
    variance : float
        Of the reaction as it was estimated last [N^2].
    horizon : float
        [s]

    """
    if trend.p00 == 0.0:
        return NOTHING
    off = trend.p00 + min(variance, (_OFF * trend.value) ** 2)
    now = (trend.value - limit) / sqrt(max(off, 1e-12))
    ahead, spread = mean_after(trend, horizon, _MEMORY, off)
    u = horizon / _MEMORY
    b = _MEMORY * _MEMORY * (exp(-u) - 1.0 + u)
    spread += (_UNCERTAIN * b * trend.drive) ** 2
    return max(now, (ahead - limit) / sqrt(max(spread, 1e-12)))
