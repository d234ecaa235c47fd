"""How fast the contacts slip, how surely, and what that makes of friction."""

from math import exp, sqrt

from peg_on_hole_ros.estimation.memory import (
    CROSS,
    SCALES,
    SPEEDS,
    SPREAD,
    WORK,
    U,
    X,
    Y,
    Z,
    covariance_entry,
    times_covariance,
)
from peg_on_hole_ros.mechanics.kernel import (
    accelerate_with_derivatives,
    closed_forms,
    compiled,
    inlined,
)


@inlined
def _along(p, geo, i, dgamma, dpsi, dphi):
    """Return the speed of a contact's material point, and its derivatives by the rates."""
    s, c, a1, S1, S2, b = geo[0], geo[1], geo[2], geo[4], geo[5], geo[6]
    if i == 0:
        h0, h1, h2 = 2.0 * a1, 0.0, 0.0
        e1, e2 = -0.5 * p.D, -0.5 * p.d
        z0, z2 = -2.0 * a1 * c / s, 0.0
    else:
        side = b if i == 1 else -b
        h0, h1, h2 = 2.0 * a1, side, side * c
        e1, e2 = S1, S2
        z0, z2 = 2.0 * S1, side * s
    v_h = h0 * dgamma + h1 * dpsi + h2 * dphi
    v_e = e1 * dpsi + e2 * dphi
    v_z = z0 * dgamma + z2 * dphi
    speed = sqrt(v_h * v_h + v_e * v_e + v_z * v_z)
    over = 1.0 / (speed + 1e-300)
    return (
        speed,
        (v_h * h0 + v_z * z0) * over,
        (v_h * h1 + v_e * e1) * over,
        (v_h * h2 + v_e * e2 + v_z * z2) * over,
    )


@compiled
def slip(p, m, gamma, given_friction=False):
    """
    Fill SPEEDS with speed and variance of the peg's material points at K, B1, B2.

    Parameters
    ----------
    p : SceneScalars
    m : ndarray
        Memory, of which rates and their covariance are used [m/s], [m^2/s^2].
    gamma : float
        Tilt at which the contacts are taken [rad].
    given_friction : bool
        Leave out of the variances what comes from not knowing the friction coefficient: it makes
        the slip's speed doubtful, not its direction.

    """
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, gamma)
    z33, z44, z55 = m[Z + 39], m[Z + 52], m[Z + 65]
    z34, z35, z45 = m[Z + 40], m[Z + 41], m[Z + 53]
    for i in range(3):
        speed, d0, d1, d2 = _along(p, geo, i, m[X + 3], m[X + 4], m[X + 5])
        # The rates' covariance through the velocity; the tilt's part is below it by |rate| * 1e-2.
        variance = d0 * d0 * z33 + d1 * d1 * z44 + d2 * d2 * z55
        variance += 2.0 * (d0 * d1 * z34 + d0 * d2 * z35 + d1 * d2 * z45)
        if given_friction and m[SPREAD] > 0.0:
            shared = d0 * m[CROSS + 3] + d1 * m[CROSS + 4] + d2 * m[CROSS + 5]
            variance = max(variance - shared * shared / m[SPREAD], 0.0)
        m[SPEEDS + 2 * i] = speed
        m[SPEEDS + 2 * i + 1] = variance


@compiled
def stops_by_chance(p, m, dy, dt, within):
    """
    Return whether it is not sure that friction stops the peg within an interval.

    At rest the spread shows nothing of what led there. Without the kink of dry friction the slip
    would have turned round by the end of the interval: surely, if some contact's did by more than
    so many standard deviations.

    Parameters
    ----------
    p : SceneScalars
    m : ndarray
        Memory, with state and covariance of the begin of the interval.
    dy : ndarray, shape (6, 14)
        Scratch.
    dt : float
        [s].
    within : float
        Standard deviations.

    """
    accelerate_with_derivatives(
        p, m[SCALES : SCALES + 3], m[X : X + 6], m[U : U + 6], m[WORK:], m[Y : Y + 6], dy
    )
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, m[X])
    r0, r1, r2 = m[X + 3], m[X + 4], m[X + 5]
    for i in range(3):
        for j in range(14):
            dy[i, j] *= dt
        dy[i, 3 + i] += 1.0
    uncertain = times_covariance(m, dy, 3)
    for i in range(3):
        speed, d0, d1, d2 = _along(p, geo, i, r0, r1, r2)
        turned = -speed - dt * (d0 * m[Y] + d1 * m[Y + 1] + d2 * m[Y + 2])
        variance = 0.0
        for j in range(3):
            d_j = d0 if j == 0 else (d1 if j == 1 else d2)
            for k in range(3):
                d_k = d0 if k == 0 else (d1 if k == 1 else d2)
                variance += d_j * d_k * covariance_entry(m, dy, j, k, uncertain)
        if turned > 0.0 and turned * turned >= within * within * variance:
            return False
    return True


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


@compiled
def creep_variance(p, m, slip_velocity_scale, creep_time):
    """
    Return the growth of each angle's variance while no contact slides [rad^2/s].

    Regularised friction lets a stuck peg creep at up to its velocity scale, and dry friction does
    not: the difference is a slow error of the model, here white with the power of one that lasts
    for creep_time [s].
    """
    fastest = max(m[SPEEDS], m[SPEEDS + 2], m[SPEEDS + 4])
    scale2 = slip_velocity_scale * slip_velocity_scale
    stuck = scale2 / (scale2 + fastest * fastest)
    rate = 2.0 * slip_velocity_scale / p.D
    return rate * rate * stuck * creep_time


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
