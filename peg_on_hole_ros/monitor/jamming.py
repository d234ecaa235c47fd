"""The risk that the peg jams within a short time, by its causes: wedging, stall, load."""

from math import cos, exp, fabs, log, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import MonitorOptions
from peg_on_hole_ros.estimator.record import NOISE, REACTIONS, SPREAD, WORK, P, U, X, Y
from peg_on_hole_ros.mechanics.kernel import (
    closed_forms,
    compiled,
    pose_of,
    scene_of,
)
from peg_on_hole_ros.mechanics.whitney import jamming_margin
from peg_on_hole_ros.monitor import down_the_hole, load_ahead, stall_ahead
from peg_on_hole_ros.monitor.contacts import MOST, below
from peg_on_hole_ros.monitor.down_the_hole import along_share, follow_depth, stands, unsettle
from peg_on_hole_ros.monitor.load_ahead import follow_load, over_limit
from peg_on_hole_ros.monitor.stall_ahead import follow_push, follow_tilt, stops_ahead
from peg_on_hole_ros.monitor.trend import (
    CALM,
    MEASURED,
    QUICK_TILT,
    TURN,
    is_number,
    rate_after,
)
from peg_on_hole_ros.monitor.wedging_ahead import wedging_ahead

# docs/jamming.md has the definition and its derivation.

# Two running means tell whether the push grows at all: slower than its trend, and steadier [s].
_QUICK, _SLOW = 0.01, 0.04
# A push grows, or is more than usual, by this share of what friction can hold, known to that.
_MORE, _MORE_STDDEV = 0.15, 0.03
# What push is usual for a motion is its mean over this time [s].
_USUAL = 0.2
# A push is compared with that of a motion that has lasted this long [s].
_MOVED = 0.03
# A jump of the tilt is followed for this long before it counts as a motion [s].
_CALM = 0.01
# A trend of the load takes this long to part from its begin [s].
_LOADED = 0.015
# A tilt tells no depth before two contacts have carried for this long [s].
_HELD = 0.01
# Above gamma0 by this share: the closed forms end at gamma0.
_EDGE = 1e-4
_ROOT_TWO_PI = sqrt(2.0 * pi)

# Memory: quick and slow mean of the push, its mean while closing, for how long the peg has closed;
# the sum of the reactions (0: not seen), for how long they were seen without a break; means, as of
# the push, of the share of friction that is against the closing; then that of `stall_ahead`, of
# `load_ahead` and of `down_the_hole`.
PUSH, PUSH_SLOW, USUAL, MOVED, TOTAL, UNBROKEN = 0, 1, 2, 3, 4, 5
AGAINST, AGAINST_SLOW, AGAINST_USUAL, STALL = 6, 7, 8, 9
LOADS = STALL + stall_ahead.SIZE
DEPTH = LOADS + load_ahead.SIZE
# By how many deviations the load is surely beyond Whitney's diagram, a mean as of the push.
BEYOND = DEPTH + down_the_hole.SIZE
SIZE = BEYOND + 1
_forget_stall, _forget_loads = stall_ahead.forget, load_ahead.forget
_forget_depth = down_the_hole.forget


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
    with_slip : float
        The determinant where wedging is most likely, if the peg turned by SLIP times its closing.
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
    with_slip: float
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
    f: np.ndarray,
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
    f : ndarray
        Record of the estimate.
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
    determinant = path = slipping = 0.0
    if f[X] > p.gamma0 * (1.0 + _EDGE):
        path, determinant, slipping = wedging_ahead(
            p, f, rate if known else 0.0, turn, turn_variance, rest_rate, horizon
        )
    over = loaded = stall = pushed = 0.0
    if contact < 0.5:
        j[MOVED] = j[TOTAL] = j[UNBROKEN] = j[BEYOND] = 0.0
        _forget_stall(j, STALL)
        _forget_loads(j, LOADS)
        _forget_depth(j, DEPTH)
    else:
        if motion[MEASURED + 2] != 0.0:
            follow_depth(j, DEPTH, p, motion[MEASURED], motion[MEASURED + 1], motion[MEASURED + 2])
        # What is foreseen ends with three-point contact.
        over, loaded = _load(f, j, options, dt, time, usable)
        ahead = min(horizon, time) if time >= 0.0 else horizon
        stops, grows, more = _pushed(
            p, f, motion, j, ahead, rest_rate, dt, since, surely, rate, turn
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
        around = 0.5 * p.d * (f[X + 4] + f[X + 5])
        f_z = p.f * along_share(j, DEPTH, p, around)
        insertion, margin, beyond, surely, width, locks, held, pressed = _two_point(
            p, f, f_z, options[4]
        )
        kept = below(beyond)
        unsettle(j, DEPTH, (1.0 - held) * min(dt / _HELD, 1.0))
        rests, stops = stands(j, DEPTH, p, horizon, options[2])
        j[BEYOND] += min(dt / _QUICK, 1.0) * (surely - j[BEYOND])
        # A peg that slides is at the diagram's edge; one that rests is anywhere beyond it, up to
        # twice the push, or inside where it can wedge.
        for_rest = 0.5 * max(j[BEYOND], 0.0) ** 2 - (1.0 - locks) * log(width)
        # Inside says nothing, for friction may be stated too low.
        for_rest = exp(min(max(for_rest, 0.0), MOST))
        rests *= for_rest / (1.0 + rests * (for_rest - 1.0))
        stuck = contact * under * held * pressed * (rests + stops * kept)
        wedging = stuck * locks * (1.0 - kept)
        # Of a peg that is not wedged, so that the risk is that it is stuck.
        stall = (stuck - wedging) / max(1.0 - wedging, 1e-9)
    out[0], out[1], out[2] = wedging, stall, load
    out[3] = 1.0 - (1.0 - wedging) * (1.0 - stall) * (1.0 - load)
    out[4], out[5], out[6], out[7], out[8] = determinant, slipping, insertion, margin, loaded


@compiled
def _push(p, f):
    """
    Return the generalised force that closes the peg, without contacts, its variance, and a lever.

    The lever is by how much the contacts slip, in their mean, where the tilt changes by one.
    """
    tilt = max(f[X], p.gamma0 * (1.0 + _EDGE))
    geo, wrench = pose_of(p, f[X : X + 6], f[U : U + 6], f[WORK:])
    if not f[X] > p.gamma0:
        geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, tilt)
    dh_c, dz_c = geo[10], geo[11]
    push = wrench[4] - wrench[0] * dh_c - wrench[2] * dz_c
    s, a1, S1 = geo[0], geo[2], geo[4]
    lever = 2.0 / 3.0 * (a1 / s + 2.0 * sqrt(a1 * a1 + S1 * S1))
    return push, f[NOISE] * (dh_c * dh_c + dz_c * dz_c) + f[NOISE + 28], lever


@compiled
def _pushed(p, f, motion, j, horizon, rest_rate, dt, since, closing, rate, turn):
    """
    Return the probabilities that the peg stops, that the push grows, that it is more than usual.

    A peg that its holder brings to rest feels a push that changes little, one that stalls is
    pushed ever more; both beside what friction can hold. Nothing is said before the peg has moved
    in contact: nobody knows what would move it.
    """
    push, variance, lever = _push(p, f)
    if not (is_number(push) and is_number(variance)):
        # Nothing is taken from it.
        return 0.0, 0.0, 0.0
    held = max(0.5 * p.d * p.f * j[TOTAL], 3.0 * sqrt(variance))
    follow_push(j, STALL, push, variance, held, dt)
    if motion[MEASURED + 2] != 0.0:
        tilt, tilt_variance = motion[MEASURED], motion[MEASURED + 1]
        follow_tilt(j, STALL, tilt, tilt_variance, held, motion[MEASURED + 2], since)
        motion[MEASURED + 2] = 0.0
    # Friction is against closing and turning in their shares of the slip.
    against = lever * fabs(rate) / (lever * fabs(rate) + 0.5 * p.d * fabs(turn) + 1e-9)
    if j[MOVED] == 0.0:
        j[PUSH] = j[PUSH_SLOW] = j[USUAL] = push
        j[AGAINST] = j[AGAINST_SLOW] = j[AGAINST_USUAL] = against
    j[AGAINST] += min(dt / _QUICK, 1.0) * (against - j[AGAINST])
    j[AGAINST_SLOW] += min(dt / _SLOW, 1.0) * (against - j[AGAINST_SLOW])
    j[PUSH] += min(dt / _QUICK, 1.0) * (push - j[PUSH])
    j[PUSH_SLOW] += min(dt / _SLOW, 1.0) * (push - j[PUSH_SLOW])
    j[MOVED] += dt * closing
    j[USUAL] += min(dt / _USUAL, 1.0) * closing * (push - j[USUAL])
    j[AGAINST_USUAL] += min(dt / _USUAL, 1.0) * closing * (against - j[AGAINST_USUAL])
    if j[MOVED] < _MOVED or j[TOTAL] == 0.0:
        return 0.0, 0.0, 0.0
    scatter = (_MORE_STDDEV * held) ** 2
    noise = variance * min(0.5 * dt / _QUICK, 1.0)
    slope = horizon / (_SLOW - _QUICK)
    # A slip or slide that ends, or reverses, turns friction against the closing: that is no press.
    now = max(j[AGAINST], 1e-9)
    turned = max(1.0 - j[AGAINST_SLOW] / now, 0.0) * fabs(j[PUSH])
    growth = slope * (j[PUSH] - j[PUSH_SLOW] - turned) - _MORE * held
    grows = below(growth / sqrt(slope * slope * noise + scatter))
    usual = j[USUAL] + max(now / max(j[AGAINST_USUAL], 1e-9) - 1.0, 0.0) * fabs(j[USUAL])
    more = below((j[PUSH] - usual - _MORE * held) / sqrt(noise + scatter))
    return stops_ahead(j, STALL, horizon, rest_rate), grows, more


@compiled
def _load(f, j, options, dt, time, usable):
    """Return the probability that a reaction passes its limit, and which: 0 K, 1 B1, 2 B2."""
    for i in range(3):
        usable = usable and is_number(f[Y + 3 + i]) and is_number(f[REACTIONS + 21 + 7 * i])
    if not usable:
        break_course(j)
        return 0.0, 0.0
    total = 0.0
    j[UNBROKEN] += dt
    for i in range(3):
        N, variance = f[Y + 3 + i], f[REACTIONS + 21 + 7 * i]
        total += fabs(N)
        if follow_load(j, LOADS, i, N, variance, options[5 + i], dt):
            j[UNBROKEN] = 0.0
    j[TOTAL] += (min(dt / _QUICK, 1.0) if j[TOTAL] > 0.0 else 1.0) * (total - j[TOTAL])
    # A load that jumps shows no course, but it is there.
    horizon = 0.0
    if j[UNBROKEN] > _LOADED:
        horizon = min(options[1], time) if time >= 0.0 else options[1]
    most, which = load_ahead.NOTHING, 0.0
    for i in range(3):
        over = over_limit(j, LOADS, i, f[REACTIONS + 21 + 7 * i], options[5 + i], horizon)
        if over > most:
            most, which = over, float(i)
    return below(most), which


@compiled
def _two_point(p, f, f_z, threshold):
    """
    Return l/d, Whitney's margin, by how many deviations it is used up, and more of the load.

    That is by how many it is used up with a friction that is one deviation less, how many of them
    twice the push is wide, and the probabilities that the peg can wedge, that rim and wall are
    pressed on, and that it is pushed into the hole. Of the friction, f_z is along the hole. The
    plane is that of the tilt, the tilt small. An estimate a little below zero leans to the other
    side.
    """
    s, c = sin(f[X]), cos(f[X])
    side = 1.0 if s >= 0.0 else -1.0
    _, wrench = pose_of(p, f[X : X + 6], f[U : U + 6], f[WORK:])
    length = ((p.D - p.d) + 2.0 * p.d * sin(0.5 * f[X]) ** 2) / max(side * s, 1e-6)
    F_x, F_z = side * wrench[0], -wrench[2]
    M = -side * (wrench[4] + p.H_c * (c * wrench[0] + s * wrench[2]))
    f_z = max(f_z, 1e-3)
    margin = jamming_margin(0.5 * p.d, length, f_z, F_x, F_z, M)
    more = f_z + sqrt(max(f[SPREAD], 1e-6))
    by_friction = jamming_margin(0.5 * p.d, length, more, F_x, F_z, M) - margin
    noise = sqrt(f[NOISE] + f[NOISE + 28] / (p.d * p.d / 4.0))
    lever = 1.0 + 2.0 * p.f * p.d / length
    uncertain = noise * lever + 0.05 * fabs(F_z)
    uncertain = sqrt(uncertain * uncertain + by_friction * by_friction)
    beyond, surely = -margin / uncertain, (by_friction - margin) / uncertain
    # Moments about the edge leave K alone, if the peg slides in; B carries it and the side load.
    arm = length + p.f * p.d
    about_edge = M + 0.5 * p.d * (c * F_z + side * s * F_x)
    about_edge_noise = f[NOISE + 28] + p.H_c * p.H_c * f[NOISE]
    N_K, variance = about_edge / arm, about_edge_noise / (arm * arm)
    # K is as steep as the peg leans: without friction it lifts the peg by so much, as where the
    # holder alone keeps the tilt. What is left of the push is for friction.
    steep = max(side * s, 0.0) / length
    left, left_noise = F_z - steep * max(about_edge, 0.0), steep * steep * about_edge_noise
    pressed = below((left - threshold) / sqrt(noise * noise + left_noise))
    variance += max(f[SPREAD], 0.0) * (N_K * p.d / arm) ** 2
    loaded = below(N_K / sqrt(variance)) * below((F_x + N_K) / sqrt(variance + f[NOISE]))
    # Where either friction cone holds the other contact, any load may be locked in.
    locks = below((p.f - length / p.d) / sqrt(max(f[SPREAD], 1e-6)))
    held = max(loaded, locks)
    width = max(2.0 * F_z / (uncertain * _ROOT_TWO_PI), 1.0)
    # K lies on the peg's side.
    deepest = 2.0 * p.H_c * side * f[X] - (p.D - p.d)
    held *= below(deepest / (2.0 * p.H_c * sqrt(max(f[P], 1e-18))))
    return length / p.d, margin, beyond, surely, width, locks, held, pressed
