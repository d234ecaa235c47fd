"""What something else than the holder does to the peg: the wrench that its motion leaves over."""

from math import cos, exp, fabs, nan, sin, sqrt

import numpy as np

from peg_on_hole_ros.estimator.record import BIAS_LOAD, NOISE, RATES, U, X
from peg_on_hole_ros.mechanics.kernel import compiled, scene_of
from peg_on_hole_ros.monitoring.trend import is_number

# A single wrench of 0.2 N and 5 mN m looks as if a rim carried 0.6 N; the mean over
# `monitor.evidence_time` tells a free peg from one that is touched lightly. A peg that is turned
# in the air needs a couple for it, some 0.1 N m at 200 rad/s^2: it is known from the rates.
# Its force for being moved is not, for nothing measures where the peg is.
#
# Axes: those of the peg without phi (eta, e, zeta). Memory: share of one wrench's variance that
# is left in the means (0: none yet), mean force (3), mean couple less gyroscopic (3), mean rate
# of change of the angular momentum (3), and what that was last (3).
_SHARE, _FORCE, _COUPLE, _RATE, _MOMENTUM = 0, 1, 4, 7, 10
SIZE = 13
# Squares of noise alone stay below so many times their mean.
ROOM = 3.0
# A load this many times the mean square of the noise off the mean has changed.
JUMP = 6.0
# A force out of the hole counts as one of this part: a peg that leaves the rim is accelerated so.
LIFT = 3.0


def new_means() -> np.ndarray:
    """Return the memory of means over nothing."""
    return np.zeros(SIZE)


@compiled
def carried_load(f, means, dt, time):
    """
    Take one wrench into the means, and return what is left for a rim to carry.

    Parameters
    ----------
    f : ndarray
        Record of the estimate.
    means : ndarray
        From `new_means`; changed.
    dt : float
        Since the wrench before [s].
    time : float
        Over which means are taken [s].

    Returns
    -------
    carried : float
        Root of the squares of force and couple; a couple counts by its force at the peg's
        radius [N]. NaN for a wrench that is no number: it is not taken.
    variance : float
        What noise alone would make of its square [N^2].

    """
    p = scene_of(f)
    s, c = sin(f[X]), cos(f[X])
    spsi, cpsi, sphi, cphi = sin(f[X + 1]), cos(f[X + 1]), sin(f[X + 2]), cos(f[X + 2])
    g_h, g_e = cpsi * p.g_x + spsi * p.g_y, cpsi * p.g_y - spsi * p.g_x
    # The frame turns by w; the peg by phi' more about zeta.
    w_x, w_y, w_z = f[X + 4] * s, -f[X + 3], f[X + 4] * c
    L_x, L_y, L_z = p.Ie * w_x, p.Ie * w_y, p.Iz * (w_z + f[X + 5])
    new = (
        cphi * f[U] - sphi * f[U + 1] + p.m * (c * g_h + s * p.g_z),
        sphi * f[U] + cphi * f[U + 1] + p.m * g_e,
        f[U + 2] + p.m * (c * p.g_z - s * g_h),
        cphi * f[U + 3] - sphi * f[U + 4] - (w_y * L_z - w_z * L_y),
        sphi * f[U + 3] + cphi * f[U + 4] - (w_z * L_x - w_x * L_z),
        f[U + 5] - (w_x * L_y - w_y * L_x),
        L_x,
        L_y,
        L_z,
    )
    over_radius = 2.0 / p.d
    noise = jump = 0.0
    for i in range(3):
        noise += f[NOISE + 7 * i] + over_radius * over_radius * f[NOISE + 21 + 7 * i]
        jump += (new[i] - means[_FORCE + i]) ** 2
        jump += (over_radius * (new[3 + i] - means[_COUPLE + i])) ** 2
    if not is_number(jump + fabs(L_x) + fabs(L_y) + fabs(L_z)):
        return nan, noise
    share = 1.0 - exp(-dt / time)
    begun = means[_SHARE] > 0.0
    for i in range(3):
        rate = (new[6 + i] - means[_MOMENTUM + i]) / dt if begun and dt > 0.0 else 0.0
        means[_RATE + i] += share * (rate - means[_RATE + i])
        means[_MOMENTUM + i] = new[6 + i]
    # A load that has changed is not a mean of before and after.
    if not begun or jump > JUMP * noise:
        means[_SHARE] = share = 1.0
    else:
        means[_SHARE] = (1.0 - share) * (1.0 - share) * means[_SHARE] + share * share
    squares = 0.0
    for i in range(3):
        means[_FORCE + i] += share * (new[i] - means[_FORCE + i])
        means[_COUPLE + i] += share * (new[3 + i] - means[_COUPLE + i])
        couple = means[_COUPLE + i] - means[_RATE + i]
        squares += means[_FORCE + i] ** 2 + (over_radius * couple) ** 2
    pull = _pull(f, means)
    squares -= pull * pull * (1.0 - 1.0 / (LIFT * LIFT))
    return sqrt(squares), means[_SHARE] * noise + _turned(f, time)


@compiled
def _pull(f, means):
    """Return the force out of the hole [N]: contacts push, but where a squeeze lets them pull."""
    return max(sin(f[X]) * means[_FORCE] + cos(f[X]) * means[_FORCE + 2], 0.0)


@compiled
def _turned(f, time):
    """Return the variance that the rates leave to a couple, as a force at the peg's radius."""
    p, s = scene_of(f), sin(f[X])
    turned = 2.0 / p.d * p.Ie / time
    return turned * turned * (f[RATES] + s * s * f[RATES + 7])


@compiled
def stands_out(f, means, floor, time, root):
    """
    Return the square of a carried load over what nothing, or next to nothing, would make of it.

    Force and couple count by their joint noise: about the mass centre of a peg far from its
    sensor the couple is noisy, and mostly by the force's noise, which the force tells.

    Parameters
    ----------
    f, means, time
        As for `carried_load`, which has taken the wrench.
    floor : float
        Square of the load that counts as none [N^2].
    root : ndarray
        Scratch, 42 places.

    """
    over_radius = 2.0 / scene_of(f).d
    c, s, sphi, cphi = cos(f[X]), sin(f[X]), sin(f[X + 2]), cos(f[X + 2])
    pull = _pull(f, means) * (1.0 - 1.0 / LIFT)
    h, e = means[_FORCE] - pull * s, means[_FORCE + 1]
    # In the peg's axes, in which the noise stands.
    root[36], root[37] = cphi * h + sphi * e, cphi * e - sphi * h
    root[38] = means[_FORCE + 2] - pull * c
    h, e = means[_COUPLE] - means[_RATE], means[_COUPLE + 1] - means[_RATE + 1]
    root[39] = over_radius * (cphi * h + sphi * e)
    root[40] = over_radius * (cphi * e - sphi * h)
    root[41] = over_radius * (means[_COUPLE + 2] - means[_RATE + 2])
    # Of six squares as of one.
    room, turned = 6.0 * ROOM * means[_SHARE], ROOM * _turned(f, time)
    least = floor + ROOM * f[BIAS_LOAD]
    squares = 0.0
    for i in range(6):
        for k in range(i + 1):
            v = room * f[NOISE + 6 * i + k]
            if i > 2:
                v *= over_radius
            if k > 2:
                v *= over_radius
            if i == k:
                v += least + (turned if i > 2 else 0.0)
            for a in range(k):
                v -= root[6 * i + a] * root[6 * k + a]
            root[6 * i + k] = sqrt(max(v, 1e-300)) if i == k else v / root[7 * k]
        v = root[36 + i]
        for a in range(i):
            v -= root[6 * i + a] * root[36 + a]
        root[36 + i] = v / root[7 * i]
        squares += root[36 + i] * root[36 + i]
    return squares
