"""The risk that the peg jams within a short time, by its causes: wedging, stall, load."""

from math import cos, exp, fabs, sin, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimation.memory import NOISE, REACTIONS, SPREAD, WORK, U, X, Y
from peg_on_hole_ros.mechanics.kernel import (
    closed_forms,
    compiled,
    pose_of,
    scene_of,
)
from peg_on_hole_ros.mechanics.whitney import jamming_margin
from peg_on_hole_ros.monitoring.contacts import below
from peg_on_hole_ros.monitoring.trend import (
    QUICK_TILT,
    TURN,
    TURN_SHARE,
    position_after,
    rate_after,
)
from peg_on_hole_ros.monitoring.wedging_ahead import wedging_ahead
from peg_on_hole_ros.options import MonitorOptions

# docs/jamming.md has the definition and its derivation.

# Two running means give push and load with their trends [s].
QUICK, SLOW = 0.01, 0.04
# What push is usual for a motion is its mean over this time [s].
_USUAL = 0.2
# A push is compared with that of a motion that has lasted this long [s].
_MOVED = 0.03
# A push is more than usual by this share of what friction can hold.
_MORE = 0.15
# Above gamma0 by this share: the closed forms end at gamma0.
_EDGE = 1e-4

# Memory: quick and slow mean of push; slow mean while closing; time of closing; then the quick
# and the slow means of N_K, N_B1, N_B2; the number of loads seen.
PUSH, PUSH_SLOW, PUSH_MOVING, MOVED, LOADS, SEEN = 0, 1, 2, 3, 4, 10
SIZE = 11


class Limits(NamedTuple):
    """The options that compiled code needs, see `MonitorOptions`."""

    horizon: float
    rest_speed: float
    acceleration: float
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
            options.rest_speed,
            options.forecast_acceleration_stddev,
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
        Of the six equations now, over its frictionless value; NaN below gamma0.
    with_slip : float
        The determinant where wedging is most likely, if the peg turned by SLIP times its closing.
    insertion : float
        l/d in two-point contact; 0 elsewhere.
    margin : float
        Of `whitney.jamming_margin` in two-point contact [N]; 0 elsewhere.

    """

    wedging: float
    stall: float
    load: float
    risk: float
    determinant: float
    with_slip: float
    insertion: float
    margin: float


def new_memory() -> np.ndarray:
    """Return the memory of a risk that has seen nothing."""
    return np.zeros(SIZE)


@compiled
def assess(f, motion, j, options, dt, since, contact, under, time, usable, out):
    """
    Fill in the risk.

    Parameters
    ----------
    f : ndarray
        Memory of the filter, after `reactions.react`.
    motion : ndarray
        Memory of `trend`.
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
    p = scene_of(f)
    horizon, rest_rate = options[0], options[1] / p.D
    rate, rate_variance = rate_after(motion, QUICK_TILT, since, options[3])
    turn, turn_variance = rate_after(motion, TURN, since, options[3])
    spread = sqrt(max(rate_variance, 1e-18))
    turn_spread = sqrt(max(turn_variance, 1e-18))
    closing = below((-rest_rate - rate) / spread)
    rest = 1.0 - closing - below((rate - rest_rate) / spread)
    turn_rest = below((2.0 * rest_rate - turn) / turn_spread)
    rest *= max(turn_rest - below((-2.0 * rest_rate - turn) / turn_spread), 0.0)
    stops = closing * _stops(motion, since, options, rest_rate, p.gamma0)
    # Just after a jolt the trend knows no direction: that is no motion that could lead anywhere.
    known = fabs(rate) > 3.0 * spread
    moves = 1.0 - rest if known else 0.0
    determinant = path = slipping = 0.0
    if f[X] > p.gamma0 * (1.0 + _EDGE):
        path, determinant, slipping = wedging_ahead(
            p, f, rate if known else 0.0, turn, turn_variance, rest_rate, horizon
        )
    push, push_variance = _push(p, f)
    grows, more = _pushed(p, j, push, push_variance, horizon, dt, closing, contact)
    pushed = max(grows, more)
    above = contact * (1.0 - under)
    wedging = above * path * (moves + (1.0 - moves) * pushed)
    stall = above * min(stops * grows + rest * pushed, 1.0)
    load = above * _load(f, j, options, dt, time, usable, contact)
    insertion = margin = 0.0
    if under > 0.5:
        insertion, margin, outside, inward = _two_point(p, f, options[4])
        idle = contact * under * inward
        wedging += idle * rest * below((p.f - insertion) / sqrt(max(f[SPREAD], 1e-6)))
        stall += idle * min(stops + rest, 1.0) * outside
    out[0], out[1], out[2] = wedging, stall, load
    out[3] = 1.0 - (1.0 - wedging) * (1.0 - stall) * (1.0 - load)
    out[4], out[5], out[6], out[7] = determinant, slipping, insertion, margin


@compiled
def _stops(motion, since, options, rest_rate, gamma0):
    """Return the probability that the tilt stands still a horizon from now, above gamma0."""
    t = since + options[0]
    rate, variance = rate_after(motion, QUICK_TILT, t, options[3])
    tilt, tilt_variance = position_after(
        motion, QUICK_TILT, t, TURN_SHARE * options[2], options[3]
    )
    still = below((rate + rest_rate) / sqrt(max(variance, 1e-18)))
    return still * below((tilt - gamma0) / sqrt(max(tilt_variance, 1e-18)))


@compiled
def _push(p, f):
    """Return the generalised force that closes the peg, without contacts, and its variance."""
    tilt = max(f[X], p.gamma0 * (1.0 + _EDGE))
    geo, wrench = pose_of(p, f[X : X + 6], f[U : U + 6], f[WORK:])
    if not f[X] > p.gamma0:
        geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, tilt)
    dh_c, dz_c = geo[10], geo[11]
    push = wrench[4] - wrench[0] * dh_c - wrench[2] * dz_c
    return push, f[NOISE] * (dh_c * dh_c + dz_c * dz_c) + f[NOISE + 28]


@compiled
def _pushed(p, j, push, variance, horizon, dt, closing, contact):
    """
    Return the probabilities that the push grows, and that it is more than what moved the peg.

    Both by a share of what friction can hold: a peg that its holder brings to rest feels a push
    that changes little, one that stalls is pushed ever more. Neither says anything before the peg
    has moved in contact: nobody knows what would move it.
    """
    if contact < 0.5:
        j[MOVED] = 0.0
        return 0.0, 0.0
    if j[MOVED] == 0.0:
        j[PUSH] = j[PUSH_SLOW] = j[PUSH_MOVING] = push
    j[MOVED] += dt * closing
    j[PUSH] += min(dt / QUICK, 1.0) * (push - j[PUSH])
    j[PUSH_SLOW] += min(dt / SLOW, 1.0) * (push - j[PUSH_SLOW])
    j[PUSH_MOVING] += min(dt / _USUAL, 1.0) * closing * (push - j[PUSH_MOVING])
    if j[MOVED] < _MOVED or j[SEEN] == 0.0:
        return 0.0, 0.0
    held = 0.5 * p.d * p.f * max(fabs(j[LOADS]) + fabs(j[LOADS + 2]) + fabs(j[LOADS + 4]), 1e-9)
    growth = horizon * (j[PUSH] - j[PUSH_SLOW]) / (SLOW - QUICK)
    noise = variance * min(0.5 * dt / QUICK, 1.0)
    scatter = noise * (horizon / (SLOW - QUICK)) ** 2 + (0.03 * held) ** 2
    grows = below((growth - _MORE * held) / sqrt(scatter))
    above = j[PUSH] - j[PUSH_MOVING] - _MORE * held
    return grows, below(above / sqrt(noise + (0.03 * held) ** 2))


@compiled
def _load(f, j, options, dt, time, usable, contact):
    """Return the probability that a reaction passes its limit within the horizon."""
    if contact < 0.5:
        j[SEEN] = 0.0
    if not usable or contact < 0.5:
        return 0.0
    worst = 0.0
    # A trend of the load lasts as long as one of the motion, and ends with three-point contact.
    horizon = min(options[0], time) if time >= 0.0 else options[0]
    reach = options[3] * (1.0 - exp(-horizon / options[3]))
    for i in range(3):
        N, variance = f[Y + 3 + i], max(f[REACTIONS + 21 + 7 * i], 1e-12)
        quick, slow = LOADS + 2 * i, LOADS + 2 * i + 1
        if j[SEEN] == 0.0:
            j[quick] = j[slow] = N
        j[quick] += min(dt / QUICK, 1.0) * (N - j[quick])
        j[slow] += min(dt / SLOW, 1.0) * (N - j[slow])
        slope = (j[quick] - j[slow]) / (SLOW - QUICK)
        ahead = j[quick] + slope * (QUICK + reach)
        limit = options[5 + i]
        worst = max(worst, below((ahead - limit) / sqrt(2.0 * variance)))
        worst = max(worst, below((j[quick] - limit) / sqrt(variance)))
    j[SEEN] += 1.0
    # Both means need some time to part by the load's trend and not by its begin.
    return worst if j[SEEN] * dt > QUICK else 0.0


@compiled
def _two_point(p, f, threshold):
    """
    Return l/d, Whitney's margin, and the probabilities that it is used up and that it is pushed.

    The plane is that of the tilt, the tilt small; what turns the peg about its axis is left out.
    """
    s, c = sin(f[X]), cos(f[X])
    _, wrench = pose_of(p, f[X : X + 6], f[U : U + 6], f[WORK:])
    length = ((p.D - p.d) + 2.0 * p.d * sin(0.5 * f[X]) ** 2) / max(s, 1e-6)
    F_x, F_z = wrench[0], -wrench[2]
    M = -(wrench[4] + p.H_c * (c * wrench[0] + s * wrench[2]))
    margin = jamming_margin(0.5 * p.d, length, max(p.f, 1e-3), F_x, F_z, M)
    noise = sqrt(f[NOISE] + f[NOISE + 28] / (p.d * p.d / 4.0))
    lever = 1.0 + 2.0 * p.f * p.d / length
    outside = below(-margin / (noise * lever + 0.05 * fabs(F_z)))
    return length / p.d, margin, outside, below((F_z - threshold) / noise)
