"""Normal reactions and slip speeds at an estimate, with their covariance."""

from math import cos, exp, sin, sqrt

from peg_on_hole_ros.mechanics.kernel import accelerate, closed_forms, compiled, equations

# Three squared normal variables stay below it in 97 of 100 cases.
SURPRISE_LIMIT = 9.0


@compiled
def fuse_reactions(Z, points, dy, acceleration_stddev, covariance, scratch):
    """
    Weigh the six equations' answer against how fast a held peg can accelerate.

    Near the singular set the equations trade huge accelerations for huge reactions; force balance
    with a bounded acceleration does not. As a Bayesian update with accelerations of zero mean and
    a stated standard deviation the two are one formula, without a switch.

    Parameters
    ----------
    Z : ndarray, shape (12, 12)
        Joint covariance of state and wrench.
    points : ndarray, shape (7, 6)
        Accelerations and reactions of the six equations, changed in place: at the estimate, then
        at the points of `solve_around`.
    dy : ndarray, shape (6, 12)
        Their derivatives at the estimate.
    acceleration_stddev : float
        Of each angle [rad/s^2].
    covariance : ndarray, shape (6, 6)
        Filled with that of the first point after the update, and with what the other points show
        to be beyond the derivatives.
    scratch : ndarray, shape (6, 12)

    """
    for i in range(6):
        for j in range(12):
            total = 0.0
            for k in range(12):
                total += dy[i, k] * Z[k, j]
            scratch[i, j] = total
    for i in range(6):
        for j in range(i + 1):
            total = 0.0
            for k in range(12):
                total += scratch[i, k] * dy[j, k]
            covariance[i, j] = total
            covariance[j, i] = total
    variance = acceleration_stddev * acceleration_stddev
    surprise = 0.0
    # One acceleration at a time: three scalar updates need no matrix inverse.
    for a in range(3):
        total = covariance[a, a] + variance
        for i in range(6):
            scratch[i, 0] = covariance[i, a] / total
        surprise += points[0, a] * points[0, a] / total
        for n in range(7):
            acceleration = points[n, a]
            for i in range(6):
                points[n, i] -= scratch[i, 0] * acceleration
        for i in range(6):
            for j in range(6):
                scratch[i, 1 + j] = covariance[a, j]
        for i in range(6):
            for j in range(6):
                covariance[i, j] -= scratch[i, 0] * scratch[i, 1 + j]
    # A held peg cannot accelerate like that: the slip's direction is wrong, and with it all that
    # follows from it. The covariance grows by as much as they are too large (Birge's ratio).
    if surprise > SURPRISE_LIMIT:
        for i in range(6):
            for j in range(6):
                covariance[i, j] *= surprise / SURPRISE_LIMIT
    for n in range(3):
        for i in range(6):
            bend = 0.5 * (points[1 + 2 * n, i] + points[2 + 2 * n, i]) - points[0, i]
            scratch[i, 0] = bend
        for i in range(6):
            for j in range(6):
                covariance[i, j] += scratch[i, 0] * scratch[j, 0]


@compiled
def solve_around(p, scales, x, u, Z, work, y, moved, points):
    """
    Solve the six equations at the estimate's answer and around it, one rate's spread at a time.

    Dry friction turns with the slip, and near stick or the singular set its turn within one
    standard deviation is no longer a straight line: the points show by how much.

    Parameters
    ----------
    p, scales, x, u, work
        As for `kernel.accelerate`.
    Z : ndarray, shape (12, 12)
        Joint covariance of state and wrench.
    y : ndarray, shape (6,)
        The answer at the estimate.
    moved : ndarray, shape (6,)
        Scratch.
    points : ndarray, shape (7, 6)
        Filled: the answer, then those at plus and minus each column of the Cholesky factor of the
        rates' covariance.

    """
    a = sqrt(max(Z[3, 3], 0.0))
    over = 1.0 / a if a > 0.0 else 0.0
    b0, b1 = Z[4, 3] * over, Z[5, 3] * over
    c = sqrt(max(Z[4, 4] - b0 * b0, 0.0))
    e = (Z[5, 4] - b1 * b0) / c if c > 0.0 else 0.0
    f = sqrt(max(Z[5, 5] - b1 * b1 - e * e, 0.0))
    points[0, :] = y
    for i in range(3):
        moved[i] = x[i]
    for n in range(3):
        d0 = a if n == 0 else 0.0
        d1 = b0 if n == 0 else (c if n == 1 else 0.0)
        d2 = b1 if n == 0 else (e if n == 1 else f)
        for side in range(2):
            sign = 1.0 - 2.0 * side
            moved[3] = x[3] + sign * d0
            moved[4] = x[4] + sign * d1
            moved[5] = x[5] + sign * d2
            accelerate(p, scales, moved, u, work, points[1 + 2 * n + side])


@compiled
def slip(p, x, Z, contact_speed):
    """
    Fill speed and variance of the peg's material points at K, B1, B2.

    Parameters
    ----------
    p : SceneScalars
    x : ndarray, shape (6,)
    Z : ndarray, shape (12, 12)
    contact_speed : ndarray, shape (3, 2)
        Filled with speed [m/s] and variance [m^2/s^2].

    """
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, x[0])
    s, c, a1, S1, S2, b = geo[0], geo[1], geo[2], geo[4], geo[5], geo[6]
    for i in range(3):
        if i == 0:
            h0, h1, h2 = 2.0 * a1, 0.0, 0.0
            e1, e2 = -0.5 * p.D, -0.5 * p.d
            z0, z2 = -2.0 * a1 * c / s, 0.0
        else:
            side = b if i == 1 else -b
            h0, h1, h2 = 2.0 * a1, side, side * c
            e1, e2 = S1, S2
            z0, z2 = 2.0 * S1, side * s
        v_h = h0 * x[3] + h1 * x[4] + h2 * x[5]
        v_e = e1 * x[4] + e2 * x[5]
        v_z = z0 * x[3] + z2 * x[5]
        speed = sqrt(v_h * v_h + v_e * v_e + v_z * v_z)
        # The rates' covariance through the velocity; the tilt's part is below it by |rate| * 1e-2.
        over = 1.0 / (speed + 1e-300)
        d0 = (v_h * h0 + v_z * z0) * over
        d1 = (v_h * h1 + v_e * e1) * over
        d2 = (v_h * h2 + v_e * e2 + v_z * z2) * over
        variance = d0 * d0 * Z[3, 3] + d1 * d1 * Z[4, 4] + d2 * d2 * Z[5, 5]
        variance += 2.0 * (d0 * d1 * Z[3, 4] + d0 * d2 * Z[3, 5] + d1 * d2 * Z[4, 5])
        contact_speed[i, 0] = speed
        contact_speed[i, 1] = variance


@compiled
def contact_forces(p, scales, x, normal, work, force, point):
    """
    Fill force on the peg (normal and friction) and place of each contact, hole axes.

    Parameters
    ----------
    p : SceneScalars
    scales : ndarray, shape (3,)
        Velocity scales of friction [m/s].
    x : ndarray, shape (6,)
    normal : ndarray, shape (3,)
        N_K, N_B1, N_B2 [N].
    work : ndarray
        From `kernel.workspace`.
    force, point : ndarray, shape (3, 3)
        Rows K, B1, B2 [N], [m].

    """
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, x[0])
    wrench = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    rates = (x[3], x[4], x[5])
    equations(p.m, p.Ie, p.Iz, p.f, p.d, p.D, scales, geo, rates, wrench, work)
    s, c = sin(x[1]), cos(x[1])
    for i in range(3):
        # Places 9 to 17 hold normal plus friction direction, rows h, e, z.
        f_h, f_e, f_z = work[9 + i], work[12 + i], work[15 + i]
        force[i, 0] = normal[i] * (c * f_h - s * f_e)
        force[i, 1] = normal[i] * (s * f_h + c * f_e)
        force[i, 2] = normal[i] * f_z
        r_h = -0.5 * p.D if i == 0 else geo[4]
        r_e = 0.0 if i == 0 else (-geo[6] if i == 1 else geo[6])
        point[i, 0] = c * r_h - s * r_e
        point[i, 1] = s * r_h + c * r_e
        point[i, 2] = 0.0


@compiled
def friction_scales(p, x, Z, slip_velocity_scale, widening, contact_speed, scales):
    """
    Fill the velocity scale of friction at each contact.

    Where the slip may well be zero, the kink of dry friction lies inside the estimate's spread,
    and a slope taken at the mean says nothing of it. The scale then grows by the slip's standard
    deviation times `widening`; two standard deviations away from zero little of it is left, so
    that friction keeps its size while the peg slides.

    Parameters
    ----------
    p, x, Z
        As for `slip`.
    slip_velocity_scale : float
        Smallest scale [m/s].
    widening : float
        Share of the slip's standard deviation; 0 keeps the smallest scale.
    contact_speed : ndarray, shape (3, 2)
        Filled by `slip`.
    scales : ndarray, shape (3,)
        Filled [m/s].

    """
    slip(p, x, Z, contact_speed)
    for i in range(3):
        variance = max(contact_speed[i, 1], 1e-30)
        near = exp(-0.5 * contact_speed[i, 0] * contact_speed[i, 0] / variance)
        scales[i] = sqrt(
            slip_velocity_scale * slip_velocity_scale + widening * widening * variance * near
        )


@compiled
def creep_variance(p, contact_speed, slip_velocity_scale, creep_time):
    """
    Return the growth of each angle's variance while no contact slides [rad^2/s].

    Regularised friction lets a stuck peg creep at up to its velocity scale, and dry friction does
    not: the difference is a slow error of the model, here white with the power of one that lasts
    for creep_time [s].
    """
    fastest = max(contact_speed[0, 0], contact_speed[1, 0], contact_speed[2, 0])
    scale2 = slip_velocity_scale * slip_velocity_scale
    stuck = scale2 / (scale2 + fastest * fastest)
    rate = 2.0 * slip_velocity_scale / p.D
    return rate * rate * stuck * creep_time
