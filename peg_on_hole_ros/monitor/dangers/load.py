"""Load: a reaction passes its limit, now or ahead, each reaction as a trend of its own."""

from collections.abc import Sequence
from math import exp, sqrt
from typing import Annotated

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.contacts import below
from peg_on_hole_ros.monitor.dangers.situation import (
    Situation,
    horizon_on_rim,
    on_rim,
    reactions_usable,
    touches,
)
from peg_on_hole_ros.monitor.trend import Trend, begin, carry, correct, forget_trend, mean_after
from peg_on_hole_ros.typed_record import Record

ADVICE = (
    "a contact's load nears its limit: reduce the force",
    "a contact's load passes its limit, or is about to: reduce the force, or reverse",
)
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
# A trend of the load takes this long to part from its begin [s].
_LOADED = 0.015


class Load(Record):
    """
    Whether a contact passes its allowed load.

    Attributes
    ----------
    probability : float
        Within the horizon.
    which : int
        Contact of that: 0 K, 1 B1, 2 B2.
    unbroken : float
        For how long the reactions were seen without a break [s].
    trends : sequence of Trend
        Of the reactions at K, B1, B2 [N].

    """

    probability: float
    which: int
    unbroken: float
    trends: Annotated[Sequence[Trend], (3,)]


@compiled
def forget(found: Load) -> None:
    """Begin anew with the next wrench."""
    found.probability, found.which = 0.0, 0
    break_course(found)


@compiled
def break_course(found: Load) -> None:
    """
    Let the course of the reactions begin anew: they are no numbers to use, or jump.

    They do where the peg does not move as predicted: what changes reactions and motion at once,
    as another friction does, is no trend to go on.
    """
    found.unbroken = 0.0
    for i in range(3):
        forget_trend(found.trends[i])


@compiled
def assess(found: Load, situation: Situation) -> None:
    """Take a wrench, see the package."""
    estimate, shown, settings = situation.estimate, situation.shown, situation.settings
    found.probability, found.which = 0.0, 0
    if not (touches(shown) and reactions_usable(estimate, shown)):
        break_course(found)
        return
    normal, covariance, dt = (
        estimate.reactions.normal,
        estimate.reactions.covariance,
        situation.passed.dt,
    )
    found.unbroken += dt
    for i in range(3):
        limit = settings.max_normal[i]
        if follow_load(found.trends[i], normal[i], covariance[i, i], limit, dt):
            found.unbroken = 0.0
    # A load that jumps shows no course, but it is there.
    horizon = 0.0
    if found.unbroken > _LOADED:
        horizon = horizon_on_rim(shown, settings.load_horizon)
    most = NOTHING
    for i in range(3):
        over = over_limit(found.trends[i], covariance[i, i], settings.max_normal[i], horizon)
        if over > most:
            most, found.which = over, i
    found.probability = on_rim(shown) * below(most)


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
