"""Normal reactions and slip speeds at an estimate, with their covariance."""

from math import exp, isfinite, nan, sqrt

from peg_on_hole_ros.estimation.kernel.memory import (
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
from peg_on_hole_ros.estimation.kernel.slow_reactions import balance_reactions
from peg_on_hole_ros.estimation.kernel.weighing import SURPRISE_LIMIT, weigh_accelerations
from peg_on_hole_ros.mechanics.kernel import (
    accelerate,
    accelerate_at,
    accelerate_with_derivatives,
    compiled,
    pose_of,
    scene_of,
)


@compiled
def fuse_reactions(m, dy, acceleration_stddev):
    """
    Weigh the six equations' answers against how fast a held peg can accelerate.

    Near the singular set the equations trade huge accelerations for huge reactions; force balance
    with a bounded acceleration does not. As a Bayesian update with accelerations as the rates went
    of late, within how much they changed, the two are one formula, without a switch.

    Where the answer at the estimate has accelerations that a held peg cannot have, the slip's
    direction is wrong, and with it all that follows. The answers around it are then weighed by how
    well theirs fit; what still does not fit widens the covariance (Birge's ratio).

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
    weigh_accelerations(m, 7, 0, uncertain, acceleration_stddev)
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
    if m[SLOW] > 0.0:
        determinant = accelerate(p, scales, x, u, work, y)
        balance_reactions(p, m, dy, acceleration_stddev)
    else:
        determinant = accelerate_with_derivatives(p, scales, x, u, work, y, dy)
        solve_around(p, m)
        fuse_reactions(m, dy, acceleration_stddev)
    # A sum is finite only if all of its terms are.
    total = determinant
    for i in range(6):
        total += y[i]
        for j in range(6):
            total += m[REACTIONS + 6 * i + j]
    return determinant if isfinite(total) else nan
