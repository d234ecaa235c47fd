"""How fast the contacts slip, how surely, and what that makes of friction."""

from math import exp, pi, sqrt

from peg_on_hole_ros.estimation.kernel.memory import (
    ACROSS,
    CROSS,
    RATES,
    SCALES,
    SPEEDS,
    SPREAD,
    X,
)
from peg_on_hole_ros.mechanics.kernel import closed_forms, compiled, inlined

# What a slip may be off by sideways turns its friction by so much of its variance: some half of
# that is a walk of the rates that is allowed for, and a steady peg's do not walk.
TURNED = 0.5
# Smallest velocity scale of friction where no step follows it [m/s].
SHARPEST = 1e-9


@inlined
def jacobian(p, geo, i):
    """Return by which the rates move a contact's material point: h (3), e by psi and phi, z."""
    s, c, a1, S1, S2, b = geo[0], geo[1], geo[2], geo[4], geo[5], geo[6]
    if i == 0:
        return 2.0 * a1, 0.0, 0.0, -0.5 * p.D, -0.5 * p.d, -2.0 * a1 * c / s, 0.0
    side = b if i == 1 else -b
    return 2.0 * a1, side, side * c, S1, S2, 2.0 * S1, side * s


@inlined
def velocity(jacobian_of, dgamma, dpsi, dphi):
    """Return the velocity of a contact's material point along h, e and z, from its `jacobian`."""
    h0, h1, h2, e1, e2, z0, z2 = jacobian_of
    return (
        h0 * dgamma + h1 * dpsi + h2 * dphi,
        e1 * dpsi + e2 * dphi,
        z0 * dgamma + z2 * dphi,
    )


@inlined
def along(p, geo, i, dgamma, dpsi, dphi):
    """Return the speed of a contact's material point, and its derivatives by the rates."""
    at = jacobian(p, geo, i)
    h0, h1, h2, e1, e2, z0, z2 = at
    v_h, v_e, v_z = velocity(at, dgamma, dpsi, dphi)
    speed = sqrt(v_h * v_h + v_e * v_e + v_z * v_z)
    over = 1.0 / (speed + 1e-300)
    return (
        speed,
        (v_h * h0 + v_z * z0) * over,
        (v_h * h1 + v_e * e1) * over,
        (v_h * h2 + v_e * e2 + v_z * z2) * over,
    )


@compiled
def slip(p, m, gamma):
    """
    Fill SPEEDS with speed and variance of the peg's material points at K, B1, B2.

    Parameters
    ----------
    p : SceneScalars
    m : ndarray
        Memory, of which rates and their covariance are used [m/s], [m^2/s^2].
    gamma : float
        Tilt at which the contacts are taken [rad].

    """
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, gamma)
    z33, z44, z55 = m[RATES], m[RATES + 13], m[RATES + 26]
    z34, z35, z45 = m[RATES + 1], m[RATES + 2], m[RATES + 14]
    for i in range(3):
        speed, d0, d1, d2 = along(p, geo, i, m[X + 3], m[X + 4], m[X + 5])
        # The rates' covariance through the velocity; the tilt's part is below it by |rate| * 1e-2.
        variance = d0 * d0 * z33 + d1 * d1 * z44 + d2 * d2 * z55
        variance += 2.0 * (d0 * d1 * z34 + d0 * d2 * z35 + d1 * d2 * z45)
        m[SPEEDS + 2 * i] = speed
        m[SPEEDS + 2 * i + 1] = variance


@compiled
def slip_all_ways(p, m, gamma):
    """
    Fill SPEEDS as `slip` does, with the variance along and across the slip, and ACROSS.

    What friction may be off by makes the slip's speed doubtful, not its direction, and is left
    out; what the slip may be off by sideways turns it, and is filled in by itself as well.
    """
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, gamma)
    c0, c1, c2 = m[CROSS + 3], m[CROSS + 4], m[CROSS + 5]
    over = 1.0 / m[SPREAD] if m[SPREAD] > 0.0 else 0.0
    z33 = m[RATES] - c0 * c0 * over
    z44 = m[RATES + 13] - c1 * c1 * over
    z55 = m[RATES + 26] - c2 * c2 * over
    z34 = m[RATES + 1] - c0 * c1 * over
    z35 = m[RATES + 2] - c0 * c2 * over
    z45 = m[RATES + 14] - c1 * c2 * over
    for i in range(3):
        at = jacobian(p, geo, i)
        h0, h1, h2, e1, e2, z0, z2 = at
        v_h, v_e, v_z = velocity(at, m[X + 3], m[X + 4], m[X + 5])
        variance = z33 * (h0 * h0 + z0 * z0) + z44 * (h1 * h1 + e1 * e1)
        variance += z55 * (h2 * h2 + e2 * e2 + z2 * z2) + 2.0 * z34 * h0 * h1
        variance += 2.0 * (z35 * (h0 * h2 + z0 * z2) + z45 * (h1 * h2 + e1 * e2))
        m[SPEEDS + 2 * i] = speed = sqrt(v_h * v_h + v_e * v_e + v_z * v_z)
        m[SPEEDS + 2 * i + 1] = max(variance, 0.0)
        over = 1.0 / (speed + 1e-300)
        d0 = (v_h * h0 + v_z * z0) * over
        d1 = (v_h * h1 + v_e * e1) * over
        d2 = (v_h * h2 + v_e * e2 + v_z * z2) * over
        variance -= d0 * d0 * z33 + d1 * d1 * z44 + d2 * d2 * z55
        variance -= 2.0 * (d0 * d1 * z34 + d0 * d2 * z35 + d1 * d2 * z45)
        m[ACROSS + i] = max(variance, 0.0)


@inlined
def turned_scales(m):
    """
    Fill SCALES so that friction along the slip has the mean that ACROSS leaves of it.

    A slip v turned by what is normal with variance sigma^2 across it has 1 - sigma^2 / (2 v^2) of
    its friction along itself; TURNED of that is taken.
    """
    for i in range(3):
        m[SCALES + i] = sqrt(TURNED * m[ACROSS + i] + SHARPEST * SHARPEST)


@inlined
def scales_without_contacts(p, m, slip_velocity_scale):
    """
    Put the smallest scale into SCALES at a tilt that has no three contacts.

    There is no slip at them then that a scale could follow from. A motion at constant rates may
    end there, and what is told of its contacts has to be numbers all the same.
    """
    if not (p.gamma0 < m[X] and m[X] < 0.5 * pi):
        for i in range(3):
            m[SCALES + i] = slip_velocity_scale


@compiled
def bridged_scales(p, m, slip_velocity_scale, widening):
    """
    Fill SCALES where no step is taken: no smallest scale is needed, see `friction_scales`.

    Parameters
    ----------
    p, m
        As for `slip_all_ways`, which is taken here.
    slip_velocity_scale, widening : float
        As for `friction_scales`; the first counts where there are no three contacts alone.

    """
    slip_all_ways(p, m, m[X])
    turned_scales(m)
    for i in range(3):
        speed, variance = m[SPEEDS + 2 * i], max(m[SPEEDS + 2 * i + 1], 1e-30)
        near = exp(-0.5 * speed * speed / variance)
        m[SCALES + i] = sqrt(m[SCALES + i] * m[SCALES + i] + widening * widening * variance * near)
    scales_without_contacts(p, m, slip_velocity_scale)


@compiled
def friction_scales(p, m, slip_velocity_scale, widening):
    """
    Fill SCALES with the velocity scale of friction at each contact.

    Where the slip may well be zero, the kink of dry friction lies inside the estimate's spread,
    and a slope taken at the mean says nothing of it. The scale then grows by the slip's standard
    deviation times `widening`; two standard deviations away from zero little of it is left, so
    that friction keeps its size while the peg slides.

    Parameters
    ----------
    p, m
        As for `slip`, which fills SPEEDS here.
    slip_velocity_scale : float
        Smallest scale [m/s].
    widening : float
        Share of the slip's standard deviation; 0 keeps the smallest scale.

    """
    slip(p, m, m[X])
    for i in range(3):
        speed, variance = m[SPEEDS + 2 * i], max(m[SPEEDS + 2 * i + 1], 1e-30)
        near = exp(-0.5 * speed * speed / variance)
        m[SCALES + i] = sqrt(
            slip_velocity_scale * slip_velocity_scale + widening * widening * variance * near
        )


@inlined
def surely_sliding(m):
    """Return 1.0 if every contact's slip is a standard deviation from rest, else 0.0."""
    for i in range(3):
        if m[SPEEDS + 2 * i] * m[SPEEDS + 2 * i] < m[SPEEDS + 2 * i + 1]:
            return 0.0
    return 1.0


@inlined
def slow_slip(m, within):
    """
    Return whether every contact's slip is less than so many standard deviations from none.

    Friction then has no direction that could be relied on. A step that assumes one accelerates
    the estimate by what is wrong of it, and one that averages over the directions lets it run
    away from a peg that slides slowly: it is up to the orientations how the peg goes on.
    """
    for i in range(3):
        speed, variance = m[SPEEDS + 2 * i], m[SPEEDS + 2 * i + 1]
        if speed * speed >= within * within * variance:
            return False
    return True
