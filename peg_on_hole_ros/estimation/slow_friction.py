"""Friction at contacts that may slip either way: what is not known of it."""

from math import erf, sqrt

from peg_on_hole_ros.estimation.memory import (
    FRICTION,
    REACTIONS,
    SCALES,
    SPEEDS,
    SPREAD,
    WORK,
    X,
    Y,
)
from peg_on_hole_ros.estimation.slip import TURNED, slip
from peg_on_hole_ros.mechanics.kernel import answer_to_contact_force, closed_forms, compiled


@compiled
def unknown_friction(p, m):
    """
    Fill FRICTION with what friction of unknown direction makes of accelerations and reactions.

    Each contact's friction is taken as free in the plane of the contact, about its mean and apart
    from the others'. The direction of a slip v that is normal with standard deviation sigma has
    the mean erf(v / (sqrt(2) sigma)) and the variance that this leaves of a unit vector, here
    along each axis, times the reaction and the friction coefficient (its root mean square where it
    is not known). So is what a slip that may be off by sideways, by a normal angle of standard
    deviation s, leaves unknown of friction along it: s^2 / sqrt(2) of it, apart from its mean,
    which SCALES holds, and from the part across, which is in the answer's slopes.

    Parameters
    ----------
    p : SceneScalars
    m : ndarray
        Memory, with the answer at the estimate at Y, its factored equations at WORK and the
        velocity scales of friction at SCALES.

    """
    slip(p, m, m[X])
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, m[X])
    work = m[WORK:]
    s, c, a1, S1, b = geo[0], geo[1], geo[2], geo[4], geo[6]
    over = 1.0 / sqrt(0.25 * p.D * p.D + a1 * a1)
    friction = sqrt(p.f * p.f + m[SPREAD])
    for n in range(3):
        speed, scale = m[SPEEDS + 2 * n], m[SCALES + n]
        # At rest no direction has a variance: nothing is known of friction then.
        mean = erf(speed / sqrt(2.0 * m[SPEEDS + 2 * n + 1] + 1e-300))
        turned = min(scale * scale / (sqrt(2.0) * TURNED * speed * speed + 1e-300), 1.0)
        unknown = min(1.0 - mean * mean + turned * turned, 1.0)
        size = friction * max(m[Y + 3 + n], 0.0) * sqrt(unknown)
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
            at = FRICTION + 6 * (3 * n + axis)
            for i in range(6):
                m[at + i] = y[i]


@compiled
def add_friction(m):
    """Add the covariance of FRICTION to REACTIONS."""
    for i in range(6):
        for j in range(6):
            total = 0.0
            for n in range(9):
                total += m[FRICTION + 6 * n + i] * m[FRICTION + 6 * n + j]
            m[REACTIONS + 6 * i + j] += total
