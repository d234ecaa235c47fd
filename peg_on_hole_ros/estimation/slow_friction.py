"""Friction at contacts that may slip either way: its mean, and what is not known of it."""

from math import erf, sqrt

from peg_on_hole_ros.estimation.memory import REACTIONS, SCALES, SPEEDS, WORK, X, Y
from peg_on_hole_ros.estimation.slip import slip
from peg_on_hole_ros.mechanics.kernel import (
    answer_to_contact_force,
    closed_forms,
    compiled,
    inlined,
    scene_of,
)


@compiled
def mean_friction(p, m, smallest):
    """
    Fill SCALES so that friction has its mean over the slip's spread, along the slip.

    The direction of a slip v that is normal with standard deviation sigma has the mean
    erf(v / (sqrt(2) sigma)). The scale is never below `smallest` [m/s].
    """
    slip(p, m, m[X])
    for i in range(3):
        share = _mean_share(m, i)
        m[SCALES + i] = max(m[SPEEDS + 2 * i] * sqrt(1.0 / (share * share) - 1.0), smallest)


@inlined
def _mean_share(m, i):
    share = erf(m[SPEEDS + 2 * i] / sqrt(2.0 * m[SPEEDS + 2 * i + 1] + 1e-300))
    return min(max(share, 1e-6), 1.0 - 1e-12)


@compiled
def add_friction(m):
    """
    Add to REACTIONS what friction of unknown direction makes of accelerations and reactions.

    Each contact's friction is taken as free in the plane of the contact, about its mean and apart
    from the others', with the variance that its mean leaves of a unit direction: 1 - share^2
    along each axis, of friction coefficient times the reaction at Y.
    """
    p = scene_of(m)
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, m[X])
    work = m[WORK:]
    s, c, a1, S1, b = geo[0], geo[1], geo[2], geo[4], geo[6]
    over = 1.0 / sqrt(0.25 * p.D * p.D + a1 * a1)
    for n in range(3):
        share = _mean_share(m, n)
        size = p.f * max(m[Y + 3 + n], 0.0) * sqrt(1.0 - share * share)
        side = 0.0 if n == 0 else (b if n == 1 else -b)
        n_h = c if n == 0 else -S1 * over
        n_e = side * over
        n_z = s if n == 0 else a1 * over
        for axis in range(3):
            # One axis without its part along the normal.
            along = n_h if axis == 0 else (n_e if axis == 1 else n_z)
            f_h = size * ((1.0 if axis == 0 else 0.0) - along * n_h)
            f_e = size * ((1.0 if axis == 1 else 0.0) - along * n_e)
            f_z = size * ((1.0 if axis == 2 else 0.0) - along * n_z)
            y = answer_to_contact_force(p, geo, work, n, f_h, f_e, f_z)
            for i in range(6):
                for j in range(6):
                    m[REACTIONS + 6 * i + j] += y[i] * y[j]
