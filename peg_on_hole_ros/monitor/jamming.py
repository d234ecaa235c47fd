"""The risk that the peg jams within a short time, by its causes: wedging, stall, load."""

from math import fabs, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import MonitorOptions
from peg_on_hole_ros.estimator.record import Estimate, scene_of
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor import load_ahead, push, stuck
from peg_on_hole_ros.monitor.contacts import below
from peg_on_hole_ros.monitor.load_ahead import follow_load, over_limit
from peg_on_hole_ros.monitor.push import EDGE, pushed_on
from peg_on_hole_ros.monitor.stuck import forget_stuck, stuck_in_hole
from peg_on_hole_ros.monitor.trend import (
    CALM,
    QUICK_TILT,
    TURN,
    is_number,
    rate_after,
)
from peg_on_hole_ros.monitor.wedging_ahead import wedging_ahead

# docs/jamming.md has the definition and its derivation.

# A jump of the tilt is followed for this long before it counts as a motion [s].
_CALM = 0.01
# A trend of the load takes this long to part from its begin [s].
_LOADED = 0.015
# The sum of the reactions is its mean over this time [s].
_TOTAL_OVER = 0.01

# Memory: the sum of the reactions (0: not seen), for how long they were seen without a break; then
# that of `push`, of `load_ahead` and of `stuck`.
TOTAL, UNBROKEN, CLOSES = 0, 1, 2
LOADS = CLOSES + push.SIZE
HOLE = LOADS + load_ahead.SIZE
SIZE = HOLE + stuck.SIZE
_forget_push, _forget_loads = push.forget, load_ahead.forget


class Limits(NamedTuple):
    """The options that compiled code needs, see `MonitorOptions`."""

    horizon: float
    load_horizon: float
    rest_speed: float
    memory: float
    threshold: float
    limit_K: float
    limit_B1: float
    limit_B2: float


def limits(options: MonitorOptions) -> np.ndarray:
    """Return the options as an array."""
    return np.array(
        Limits(
            options.jamming_horizon,
            options.load_horizon,
            options.rest_speed,
            options.forecast_acceleration_time,
            options.contact_force_threshold,
            *options.max_normal,
        )
    )


class Risk(NamedTuple):
    """
    The risk and its causes.

    Attributes
    ----------
    wedging, stall, load : float
        Probability of each within the horizon.
    risk : float
        That of any, as if they were independent.
    determinant : float
        Of the six equations now, over its frictionless value; 0 below gamma0.
    insertion : float
        l/d in two-point contact; 0 elsewhere.
    margin : float
        Of `whitney.jamming_margin` in two-point contact [N]; 0 elsewhere.
    loaded : float
        Which contact `load` is of: 0 K, 1 B1, 2 B2.

    """

    wedging: float
    stall: float
    load: float
    risk: float
    determinant: float
    insertion: float
    margin: float
    loaded: float


def new_memory() -> np.ndarray:
    """Return the memory of a risk that has seen nothing."""
    return np.zeros(SIZE)


@compiled
def break_course(j: np.ndarray) -> None:
    """
    Let the course of the reactions begin anew: they are no numbers to use, or jump.

    They do where the peg does not move as predicted: what changes reactions and motion at once,
    as another friction does, is no trend to go on.

    Parameters
    ----------
    j : ndarray
        From `new_memory`.

    """
    j[UNBROKEN] = 0.0
    _forget_loads(j, LOADS)


@compiled
def assess(
    estimate: Estimate,
    motion: np.ndarray,
    j: np.ndarray,
    options: np.ndarray,
    dt: float,
    since: float,
    contact: float,
    under: float,
    time: float,
    usable: bool,
    out: np.ndarray,
) -> None:
    """
    Fill in the risk.

    Parameters
    ----------
    estimate : Estimate
    motion : ndarray
        Memory of `trend`, then that of `down_the_hole`.
    j : ndarray
        From `new_memory`.
    options : ndarray
        From `limits`.
    dt, since : float
        Since the last wrench, and since the last orientation [s].
    contact, under : float
        Probabilities that anything touches, and that gamma is below gamma0.
    time : float
        Until gamma0 [s]; below zero: not known.
    usable : bool
        Whether the reactions of three contacts are numbers to use.
    out : ndarray
        Filled in the order of `Risk`.

    """
    p = scene_of(estimate)
    horizon, rest_rate = options[0], options[2] / p.D
    rate, rate_variance = rate_after(motion, QUICK_TILT, since, options[3])
    turn, turn_variance = rate_after(motion, TURN, since, options[3])
    spread = sqrt(max(rate_variance, 1e-18))
    turn_spread = sqrt(max(turn_variance, 1e-18))
    closing = below((-rest_rate - rate) / spread)
    rest = 1.0 - closing - below((rate - rest_rate) / spread)
    turn_rest = below((2.0 * rest_rate - turn) / turn_spread)
    rest *= max(turn_rest - below((-2.0 * rest_rate - turn) / turn_spread), 0.0)
    # Just after a jolt the trend knows no direction: that is no motion that could lead anywhere.
    # One of 2000 orientations looks like a jolt by chance, and gives a peg at rest a rate.
    known = fabs(rate) > 3.0 * spread and motion[CALM] >= _CALM
    moves = 1.0 - rest if known else 0.0
    # Of a trend that is noise a peg at rest closes in every other instant.
    surely = closing if known else 0.0
    determinant = path = 0.0
    if estimate.motion.gamma > p.gamma0 * (1.0 + EDGE):
        path, determinant = wedging_ahead(
            p, estimate, rate if known else 0.0, turn, turn_variance, rest_rate, horizon
        )
    over = loaded = stall = pushed = 0.0
    if contact < 0.5:
        j[TOTAL] = j[UNBROKEN] = 0.0
        _forget_push(j, CLOSES)
        _forget_loads(j, LOADS)
        forget_stuck(j, HOLE)
    else:
        # What is foreseen ends with three-point contact.
        over, loaded = _load(estimate, j, options, dt, time, usable)
        ahead = min(horizon, time) if time >= 0.0 else horizon
        stops, grows, more = pushed_on(
            p,
            estimate,
            motion,
            j,
            CLOSES,
            j[TOTAL],
            ahead,
            rest_rate,
            dt,
            since,
            surely,
            rate,
            turn,
        )
        pushed = max(grows, more)
        stall = min(closing * stops * grows + rest * pushed, 1.0)
    # Below gamma0, or clear of everything, this is not about three contacts.
    above = contact * (1.0 - under)
    wedging = above * path * (moves + (1.0 - moves) * pushed)
    stall *= above
    load = above * over
    insertion = margin = 0.0
    if under > 0.5:
        stands, wedged, insertion, margin = stuck_in_hole(
            p, estimate, motion, j, HOLE, options[4], dt
        )
        wedging = contact * under * wedged
        # Of a peg that is not wedged, so that the risk is that it is stuck.
        stall = (contact * under * stands - wedging) / max(1.0 - wedging, 1e-9)
    out[0], out[1], out[2] = wedging, stall, load
    out[3] = 1.0 - (1.0 - wedging) * (1.0 - stall) * (1.0 - load)
    out[4], out[5], out[6], out[7] = determinant, insertion, margin, loaded


@compiled
def _load(estimate, j, options, dt, time, usable):
    """Return the probability that a reaction passes its limit, and which: 0 K, 1 B1, 2 B2."""
    normal, covariance = estimate.reactions.normal, estimate.reactions.covariance
    for i in range(3):
        usable = usable and is_number(normal[i]) and is_number(covariance[i, i])
    if not usable:
        break_course(j)
        return 0.0, 0.0
    total = 0.0
    j[UNBROKEN] += dt
    for i in range(3):
        N, variance = normal[i], covariance[i, i]
        total += fabs(N)
        if follow_load(j, LOADS, i, N, variance, options[5 + i], dt):
            j[UNBROKEN] = 0.0
    j[TOTAL] += (min(dt / _TOTAL_OVER, 1.0) if j[TOTAL] > 0.0 else 1.0) * (total - j[TOTAL])
    # A load that jumps shows no course, but it is there.
    horizon = 0.0
    if j[UNBROKEN] > _LOADED:
        horizon = min(options[1], time) if time >= 0.0 else options[1]
    most, which = load_ahead.NOTHING, 0.0
    for i in range(3):
        over = over_limit(j, LOADS, i, covariance[i, i], options[5 + i], horizon)
        if over > most:
            most, which = over, float(i)
    return below(most), which
