"""Load: a reaction passes its limit, now or ahead, each reaction as a trend of its own."""

from collections.abc import Sequence
from math import exp, sqrt
from typing import Annotated

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.contact_probabilities import normal_cdf
from peg_on_hole_ros.monitor.dangers.situation import (
    Situation,
    horizon_on_rim,
    on_rim,
    reactions_usable,
    touches,
)
from peg_on_hole_ros.monitor.trend import Trend, begin, carry, correct, forget_trend, mean_after
from peg_on_hole_ros.monitor.tuned import LOAD_AHEAD
from peg_on_hole_ros.typed_record import Record

ADVICE = (
    "a contact's load nears its limit: reduce the force",
    "a contact's load passes its limit, or is about to: reduce the force, or reverse",
)


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
    restart_trends(found)


@compiled
def restart_trends(found: Load) -> None:
    """
    Begin the course of the reactions anew: they are no numbers to use, or jump.

    They do where the peg does not move as predicted: what changes reactions and motion at once,
    as another friction does, is no trend to go on.
    """
    found.unbroken = 0.0
    for i in range(3):
        forget_trend(found.trends[i])


@compiled
def assess(found: Load, situation: Situation) -> None:
    """Process a wrench, see the package."""
    estimate, shown, settings = situation.estimate, situation.shown, situation.settings
    found.probability, found.which = 0.0, 0
    if not (touches(shown) and reactions_usable(estimate, shown)):
        restart_trends(found)
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
    if found.unbroken > LOAD_AHEAD.loaded:
        horizon = horizon_on_rim(shown, settings.load_horizon)
    most = LOAD_AHEAD.nothing
    for i in range(3):
        over = over_limit(found.trends[i], covariance[i, i], settings.max_normal[i], horizon)
        if over > most:
            most, found.which = over, i
    found.probability = on_rim(shown) * normal_cdf(most)


@compiled
def follow_load(trend: Trend, normal: float, variance: float, limit: float, dt: float) -> bool:
    """
    Process a reaction.

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
    size = max(normal, LOAD_AHEAD.least * limit)
    acceleration = size / (LOAD_AHEAD.changes * LOAD_AHEAD.changes)
    known = variance < (LOAD_AHEAD.known * size) ** 2
    if trend.p00 == 0.0:
        if known:
            _begin_load(trend, normal, variance, size)
        return False
    carry(trend, dt, acceleration, LOAD_AHEAD.memory, 0.0)
    if not known:
        if trend.p00 > (LOAD_AHEAD.known * max(trend.value, LOAD_AHEAD.least * limit)) ** 2:
            # Not determined for long, as at rest: it no longer shows where the load goes.
            forget_trend(trend)
        return False
    off = normal - trend.value
    if off * off > LOAD_AHEAD.jump * (trend.p00 + variance):
        # A step has no rate.
        _begin_load(trend, normal, variance, size)
        return True
    correct(trend, off, variance, dt, acceleration, LOAD_AHEAD.jump)
    return False


@compiled
def _begin_load(trend: Trend, normal: float, variance: float, size: float) -> None:
    rate = size / LOAD_AHEAD.changes
    acceleration = size / (LOAD_AHEAD.changes * LOAD_AHEAD.changes)
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
        return LOAD_AHEAD.nothing
    off = trend.p00 + min(variance, (LOAD_AHEAD.off * trend.value) ** 2)
    now = (trend.value - limit) / sqrt(max(off, 1e-12))
    ahead, spread = mean_after(trend, horizon, LOAD_AHEAD.memory, off)
    u = horizon / LOAD_AHEAD.memory
    b = LOAD_AHEAD.memory * LOAD_AHEAD.memory * (exp(-u) - 1.0 + u)
    spread += (LOAD_AHEAD.uncertain * b * trend.drive) ** 2
    return max(now, (ahead - limit) / sqrt(max(spread, 1e-12)))
