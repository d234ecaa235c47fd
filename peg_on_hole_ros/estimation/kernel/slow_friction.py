"""Friction at contacts that may slip either way: what is not known of it."""

from math import erf, sqrt

from peg_on_hole_ros.estimation.kernel.memory import (
    ACROSS,
    FRICTION,
    PER_NEWTON,
    SPEEDS,
    SPREAD,
    WORK,
    X,
    Y,
)
from peg_on_hole_ros.estimation.kernel.slip import jacobian, slip, velocity
from peg_on_hole_ros.mechanics.kernel import (
    answer_to_contact_force,
    closed_forms,
    compiled,
    inlined,
)

# A cosine of a normal angle has the standard deviation s^2 / sqrt(2); of a steady peg, whose rates
# do not walk as they are allowed to, half of that (`slip.TURNED`). Between the two.
UNSURE = 0.5
# How much of a direction's variance is taken as each contact's own; the rest is in the slopes by
# the rates, which turn all three together. Slow pure align needs it (without it 20 to 60 % of the
# reactions are covered); a peg that turns round is told the worse by it (see docs/steps.md).
TURNING = 0.7
# Three axes at each contact, and along its slip.
WAYS = 12


@compiled
def answers_to_friction(p, m):
    """
    Fill PER_NEWTON with what friction of unknown direction makes of accelerations and reactions.

    Each contact's friction is taken as free in the plane of the contact, about its mean and apart
    from the others'. The direction of a slip v that is normal with standard deviation sigma has
    the mean erf(v / (sqrt(2) sigma)), and its variance is what this leaves of a unit vector.
    TURNING of that is taken along each axis, times the friction coefficient (its root mean square
    where it is not known), for one newton of the reaction.

    A slip that may be off by sideways, by a normal angle of standard deviation s, leaves
    UNSURE s^2 of friction along it unknown as well. What it makes of friction's mean is in the
    velocity scales, and of friction across it in the answer's slopes.

    Parameters
    ----------
    p : SceneScalars
    m : ndarray
        Memory, with the factored equations at WORK and the variance across the slips at ACROSS.

    """
    slip(p, m, m[X])
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, m[X])
    work = m[WORK:]
    s, c, a1, S1, b = geo[0], geo[1], geo[2], geo[4], geo[6]
    over = 1.0 / sqrt(0.25 * p.D * p.D + a1 * a1)
    friction = sqrt(p.f * p.f + m[SPREAD])
    for n in range(3):
        speed = m[SPEEDS + 2 * n]
        # At rest no direction has a variance: nothing is known of friction then.
        mean = erf(speed / sqrt(2.0 * m[SPEEDS + 2 * n + 1] + 1e-300))
        size = friction * sqrt(TURNING * (1.0 - mean * mean))
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
            _answer(p, geo, m, work, n, 4 * n + axis, f_h, f_e, f_z)
        turned = min(UNSURE * m[ACROSS + n] / (speed * speed + 1e-300), 1.0)
        size = friction * mean * turned / (speed + 1e-300)
        v_h, v_e, v_z = velocity(jacobian(p, geo, n), m[X + 3], m[X + 4], m[X + 5])
        _answer(p, geo, m, work, n, 4 * n + 3, size * v_h, size * v_e, size * v_z)


@inlined
def _answer(p, geo, m, work, n, way, f_h, f_e, f_z):
    y = answer_to_contact_force(p, geo, work, n, f_h, f_e, f_z)
    at = PER_NEWTON + 6 * way
    for i in range(6):
        m[at + i] = y[i]


@inlined
def unknown_friction(m):
    """Fill FRICTION with what unknown friction makes of Y at the reactions there."""
    for way in range(WAYS):
        normal = max(m[Y + 3 + way // 4], 0.0)
        for i in range(6):
            m[FRICTION + 6 * way + i] = normal * m[PER_NEWTON + 6 * way + i]
