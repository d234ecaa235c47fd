"""Normal reactions and slip speeds at an estimate, with their covariance."""

from math import cos, exp, isfinite, nan, sin, sqrt

from peg_on_hole_ros.estimation.kernel.acceleration import LEAST, acceleration_variance
from peg_on_hole_ros.estimation.kernel.memory import (
    ACCELERATION,
    FRICTION,
    LASTING,
    POINTS,
    RATES,
    REACTIONS,
    SCALES,
    SLOW,
    SURPRISE,
    WORK,
    U,
    X,
    Y,
    covariance_entry,
    fill_lasting,
    times_covariance,
)
from peg_on_hole_ros.estimation.kernel.slow_friction import WAYS, add_friction, unknown_friction
from peg_on_hole_ros.mechanics.kernel import (
    accelerate_at,
    accelerate_with_derivatives,
    closed_forms,
    compiled,
    equations,
    pose_of,
    scene_of,
)

# Three squared normal variables stay below it in 97 of 100 cases.
SURPRISE_LIMIT = 9.0


@compiled
def fuse_reactions(m, dy, acceleration_stddev):
    """
    Weigh the six equations' answers against how fast a held peg can accelerate.

    Near the singular set the equations trade huge accelerations for huge reactions; force balance
    with a bounded acceleration does not. As a Bayesian update with accelerations as the rates went
    of late, within how much they changed, the two are one formula, without a switch.

    Where the answer at the estimate has accelerations that a held peg cannot have, the slip's
    direction is wrong, and with it all that follows. The answers around it are then weighed by how
    well theirs fit; what still does not fit widens the covariance (Birge's ratio). While a slip is
    not told from none, friction of unknown direction widens it further.

    Parameters
    ----------
    m : ndarray
        Memory: the answers of `solve_around` at POINTS are changed; the mean is filled in at Y,
        and its covariance at REACTIONS.
    dy : ndarray, shape (6, 14)
        Derivatives of the answer at the estimate by state, wrench, friction and peg diameter.
    acceleration_stddev : float
        Of each angle at most, beside what `acceleration_variance` adds [rad/s^2].

    """
    uncertain = times_covariance(m, dy, 6)
    for i in range(6):
        for j in range(i + 1):
            total = covariance_entry(m, dy, i, j, uncertain)
            m[REACTIONS + 6 * i + j] = total
            m[REACTIONS + 6 * j + i] = total
    fill_lasting(m, uncertain)
    slow = m[SLOW] > 0.0
    for n in range(7):
        m[SURPRISE + n] = 0.0
    # One acceleration at a time: three scalar updates need no matrix inverse.
    for a in range(3):
        at = REACTIONS + 6 * a
        column = (m[at], m[at + 1], m[at + 2], m[at + 3], m[at + 4], m[at + 5])
        over = 1.0 / (column[a] + acceleration_variance(m, a, acceleration_stddev, LEAST))
        for n in range(7):
            acceleration = m[POINTS + 6 * n + a] - m[ACCELERATION + a]
            m[SURPRISE + n] += acceleration * acceleration * over
            for i in range(6):
                m[POINTS + 6 * n + i] -= column[i] * over * acceleration
        for n in range(2 if uncertain else 0):
            shared = m[LASTING + 6 * n + a] * over
            for i in range(6):
                m[LASTING + 6 * n + i] -= column[i] * shared
        for n in range(WAYS if slow else 0):
            shared = m[FRICTION + 6 * n + a] * over
            for i in range(6):
                m[FRICTION + 6 * n + i] -= column[i] * shared
        for i in range(6):
            weight = column[i] * over
            for j in range(i + 1):
                value = m[REACTIONS + 6 * i + j] - weight * column[j]
                m[REACTIONS + 6 * i + j] = value
                m[REACTIONS + 6 * j + i] = value
    least = m[SURPRISE]
    for i in range(6):
        m[Y + i] = m[POINTS + i]
    if least > SURPRISE_LIMIT:
        least = _weigh_points(m)
    growth = max(1.0, least / SURPRISE_LIMIT)
    for i in range(36):
        m[REACTIONS + i] *= growth
    for n in range(3):
        ahead, behind = POINTS + 6 * (1 + 2 * n), POINTS + 6 * (2 + 2 * n)
        for i in range(6):
            bend_i = 0.5 * (m[ahead + i] + m[behind + i]) - m[POINTS + i]
            for j in range(6):
                bend_j = 0.5 * (m[ahead + j] + m[behind + j]) - m[POINTS + j]
                m[REACTIONS + 6 * i + j] += bend_i * bend_j
    if slow:
        add_friction(m)


@compiled
def _weigh_points(m):
    """Put the points' mean by likelihood at Y, add their spread to REACTIONS; return the best."""
    least = m[SURPRISE]
    for n in range(1, 7):
        least = min(least, m[SURPRISE + n])
    total = 0.0
    for i in range(6):
        m[Y + i] = 0.0
    for n in range(7):
        weight = exp(0.5 * (least - m[SURPRISE + n]))
        total += weight
        for i in range(6):
            m[Y + i] += weight * m[POINTS + 6 * n + i]
    for i in range(6):
        m[Y + i] /= total
    for n in range(7):
        weight = exp(0.5 * (least - m[SURPRISE + n])) / total
        for i in range(6):
            off = m[POINTS + 6 * n + i] - m[Y + i]
            for j in range(6):
                m[REACTIONS + 6 * i + j] += weight * off * (m[POINTS + 6 * n + j] - m[Y + j])
    return least


@compiled
def solve_around(p, m):
    """
    Fill POINTS with the answer at Y, and with those at the rates' spread around the estimate.

    Dry friction turns with the slip, and near stick or the singular set its turn within one
    standard deviation is no straight line. The six equations are solved at plus and minus each
    column of the Cholesky factor of the rates' covariance.

    Parameters
    ----------
    p : SceneScalars
    m : ndarray
        Memory, with the answer at the estimate at Y.

    """
    x, u, scales, work = m[X : X + 6], m[U : U + 6], m[SCALES : SCALES + 3], m[WORK:]
    a = sqrt(max(m[RATES], 0.0))
    over = 1.0 / a if a > 0.0 else 0.0
    b0, b1 = m[RATES + 1] * over, m[RATES + 2] * over
    c = sqrt(max(m[RATES + 13] - b0 * b0, 0.0))
    e = (m[RATES + 14] - b1 * b0) / c if c > 0.0 else 0.0
    f = sqrt(max(m[RATES + 26] - b1 * b1 - e * e, 0.0))
    pose = pose_of(p, x, u, work)
    for i in range(6):
        m[POINTS + i] = m[Y + i]
    for n in range(3):
        d0 = a if n == 0 else 0.0
        d1 = b0 if n == 0 else (c if n == 1 else 0.0)
        d2 = b1 if n == 0 else (e if n == 1 else f)
        _, ahead = accelerate_at(p, scales, pose, (x[3] + d0, x[4] + d1, x[5] + d2), work)
        _, behind = accelerate_at(p, scales, pose, (x[3] - d0, x[4] - d1, x[5] - d2), work)
        for i in range(6):
            m[POINTS + 6 * (1 + 2 * n) + i] = ahead[i]
            m[POINTS + 6 * (2 + 2 * n) + i] = behind[i]


@compiled
def react(m, dy, acceleration_stddev):
    """
    Fill Y with the reactions of three-point contact at the estimate, and REACTIONS.

    Parameters
    ----------
    m, dy, acceleration_stddev
        As for `fuse_reactions`; dy is filled.

    Returns
    -------
    float
        Determinant over its frictionless value; NaN where the equations have no finite answer.

    """
    x, u, y = m[X : X + 6], m[U : U + 6], m[Y : Y + 6]
    scales, work = m[SCALES : SCALES + 3], m[WORK:]
    p = scene_of(m)
    determinant = accelerate_with_derivatives(p, scales, x, u, work, y, dy)
    if m[SLOW] > 0.0:
        unknown_friction(p, m)
    solve_around(p, m)
    fuse_reactions(m, dy, acceleration_stddev)
    # A sum is finite only if all of its terms are.
    total = determinant
    for i in range(6):
        total += y[i]
        for j in range(6):
            total += m[REACTIONS + 6 * i + j]
    return determinant if isfinite(total) else nan


@compiled
def tilt_on_contacts(p, gamma):
    """Return the tilt, kept where the closed forms of the geometry exist [rad]."""
    return min(max(gamma, p.gamma0 * (1.0 + 1e-9)), 1.5)


@compiled
def contact_forces(p, m, gamma, out, normal, force, point):
    """
    Fill in force on the peg (normal and friction) and place of each contact, hole axes.

    Parameters
    ----------
    p : SceneScalars
    m : ndarray
        Memory, of which psi and the rates are used.
    gamma : float
        Tilt at which the contacts are taken [rad].
    out : ndarray
        Read and filled at three places.
    normal, force, point : int
        Places of N_K, N_B1, N_B2 (3) [N], which are given; of the forces (3, 3) [N] and of the
        points (3, 3) [m], rows K, B1, B2.

    """
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, gamma)
    wrench = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    rates = (m[X + 3], m[X + 4], m[X + 5])
    scales, work = m[SCALES : SCALES + 3], m[WORK:]
    equations(p.m, p.Ie, p.Iz, p.f, p.d, p.D, scales, geo, rates, wrench, work)
    s, c = sin(m[X + 1]), cos(m[X + 1])
    for i in range(3):
        # Places 9 to 17 hold normal plus friction direction, rows h, e, z.
        f_h, f_e, f_z = work[9 + i], work[12 + i], work[15 + i]
        N, at = out[normal + i], force + 3 * i
        out[at], out[at + 1], out[at + 2] = (
            N * (c * f_h - s * f_e),
            N * (s * f_h + c * f_e),
            N * f_z,
        )
        r_h = -0.5 * p.D if i == 0 else geo[4]
        r_e = 0.0 if i == 0 else (-geo[6] if i == 1 else geo[6])
        at = point + 3 * i
        out[at], out[at + 1], out[at + 2] = c * r_h - s * r_e, s * r_h + c * r_e, 0.0


@compiled
def rim_load(m):
    """Return the sizes of the force [N] and of the couple [N m] that a rim has to carry."""
    p = scene_of(m)
    s, c = sin(m[X]), cos(m[X])
    spsi, cpsi, sphi, cphi = sin(m[X + 1]), cos(m[X + 1]), sin(m[X + 2]), cos(m[X + 2])
    g_h, g_e = cpsi * p.g_x + spsi * p.g_y, cpsi * p.g_y - spsi * p.g_x
    # Gravity in peg axes: across the tilt, along eps, along the axis.
    across = c * g_h + s * p.g_z
    F_x = m[U] + p.m * (cphi * across + sphi * g_e)
    F_y = m[U + 1] + p.m * (cphi * g_e - sphi * across)
    F_z = m[U + 2] + p.m * (c * p.g_z - s * g_h)
    couple = m[U + 3] * m[U + 3] + m[U + 4] * m[U + 4] + m[U + 5] * m[U + 5]
    return sqrt(F_x * F_x + F_y * F_y + F_z * F_z), sqrt(couple)
