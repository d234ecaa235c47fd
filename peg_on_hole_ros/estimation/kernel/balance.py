"""What the balance of forces tells, where noise would select steps: friction, state and others."""

from math import fabs, isfinite, sqrt

from peg_on_hole_ros.estimation.kernel.acceleration import LEAST_AVERAGED, acceleration_variance
from peg_on_hole_ros.estimation.kernel.bias_by_balance import learn_bias
from peg_on_hole_ros.estimation.kernel.diameter_by_balance import (
    diameter_outweighs,
    learn_diameter,
)
from peg_on_hole_ros.estimation.kernel.memory import (
    ACCELERATION,
    ACROSS,
    CROSS,
    GAIN,
    LEARNT,
    OFFSET_CROSS,
    OFFSET_SPREAD,
    OFFSETS,
    ROWS,
    SCALES,
    SEEN,
    SLOW,
    SPEEDS,
    SPREAD,
    STOPPED,
    TOLD_GAIN,
    TOLD_SHARE,
    UNBALANCE,
    WITH,
    WORK,
    U,
    X,
    Y,
    Z,
    covariance_entry,
    times_covariance,
)
from peg_on_hole_ros.estimation.kernel.offsets import offsets_are_small
from peg_on_hole_ros.estimation.kernel.parameters import (
    learns_bias,
    learnt_variance,
    move_parameters,
)
from peg_on_hole_ros.estimation.kernel.prediction import SELECTED
from peg_on_hole_ros.estimation.kernel.slip import slip_all_ways, turned_scales
from peg_on_hole_ros.estimation.kernel.symmetric import factors, solve
from peg_on_hole_ros.estimation.steps.choice import LONG_STEP
from peg_on_hole_ros.mechanics.kernel import (
    accelerate_with_derivatives,
    compiled,
    inlined,
    scene_of,
)

# A slip of so many standard deviations, along and across, has a direction.
SURE = 3.0
# Bridged rates, and how they are seen to accelerate, are those of some milliseconds before: in a
# turn the acceleration may be off by so many times itself.
LAGS = 2.0
# Beside a clearance that is not known to this share of itself, levers are hardly known either, and
# make another friction of an acceleration that lags: where friction is known to a fifth of itself,
# a peg that accelerates by more than a quarter of what it may then tells nothing.
WIDE_CLEARANCE = 0.02
ROUGHLY = 0.2
STEADY = 0.25
# A held peg's accelerations are taken to be independent after this time [s].
ACCELERATION_TIME = 0.02
# A slip that is known across to this share of its speed, squared, turns friction as a tangent
# says: what it does to the balance of forces then tells angles and rates. With 0.03 reversals
# are covered in 83 to 88 %.
DIRECTED = 0.005
# A held peg's accelerations are known no better than to this share of what is stated, where they
# tell angles and rates; friction, which is one number, is left with what all instants share.
LEAST_DIRECTED = 0.1
# Nearer to the singular set than this a tangent says nothing of friction.
LEAST_DETERMINANT = 0.1


@compiled
def learn_from_balance(m, dy, dt, acceleration_stddev):
    """
    Correct by how much a held peg can accelerate: friction, and angles and rates in a slow slip.

    Where noise stops the peg in some steps, those that are believed are the others: what they
    tell of friction is too high. The wrench that begins is told apart from the state before it,
    and selects nothing. It is measured at the end of its interval, to where the angles are taken
    at constant rates. Accelerations at these rates have no kink: while the peg surely slides, they
    are a smooth function of friction, and small.

    The noise of one wrench is in the accelerations and in what friction makes of them. Weighed by
    its own, friction would be moved one way by their product: it is weighed by what the interval
    before told, whose noise is another one.

    Friction points against the slip, so that the wrench tells how the peg slides, and through the
    lever arms how it is tilted. Steps hold that; where a slip was not told, nothing
    does, and it is learnt here. The wrench is only considered; of a bias that is not small beside
    its noise, see `bias_by_balance`, and of a clearance that is hardly known
    `diameter_by_balance`; beside them friction is only considered as well.

    Parameters
    ----------
    m : ndarray
        Memory before a prediction: friction, angles, rates and their covariance with everything
        are changed.
    dy : ndarray, shape (6, 14)
        Scratch.
    dt : float
        Time since this was last asked [s].
    acceleration_stddev : float
        Of each angle [rad/s^2].

    Returns
    -------
    bool
        Whether something was learnt. UNBALANCE says, where forces were weighed, by how much they
        were out of balance, also where nothing is to be learnt.

    """
    if not m[STOPPED] > SELECTED:
        return False
    learns = m[LEARNT] * m[SPREAD] > 0.0 and offsets_are_small(m)
    p = scene_of(m)
    wide = m[SPREAD + 3] > (WIDE_CLEARANCE * (p.D - p.d)) ** 2
    if wide and m[SPREAD] < (ROUGHLY * p.f) ** 2:
        steady = STEADY * acceleration_stddev
        for i in range(3):
            if not fabs(m[ACCELERATION + i]) <= steady:
                return False
    q0, q1, q2 = dt * m[X + 3], dt * m[X + 4], dt * m[X + 5]
    m[X] += q0
    m[X + 1] += q1
    m[X + 2] += q2
    learnt = _learn(p, m, dy, dt, acceleration_stddev, learns)
    m[X] -= q0
    m[X + 1] -= q1
    m[X + 2] -= q2
    return learnt


@compiled
def _learn(p, m, dy, dt, acceleration_stddev, learns):
    """Do so with the angles where the interval ends, and their covariance where it begins."""
    slip_all_ways(p, m, m[X])
    for i in range(3):
        if m[SPEEDS + 2 * i] * m[SPEEDS + 2 * i] <= SURE * SURE * m[SPEEDS + 2 * i + 1]:
            return False
    # The mean of what a slip turned sideways makes of friction is in the scales; what it may be
    # instead is one error for as long as the rates have theirs, and no average makes it less.
    turned_scales(m)
    turned = 0.0
    for i in range(3):
        turned = max(turned, m[ACROSS + i] / (m[SPEEDS + 2 * i] * m[SPEEDS + 2 * i]))
    learns = learns and m[SPREAD] >= (turned * p.f) ** 2
    directed, biased = turned < DIRECTED, learns_bias(m)
    if not (learns or directed or biased):
        return False
    determinant = accelerate_with_derivatives(
        p, m[SCALES : SCALES + 3], m[X : X + 6], m[U : U + 6], m[WORK:], m[Y : Y + 6], dy
    )
    if not (isfinite(m[Y] + m[Y + 1] + m[Y + 2]) and determinant > LEAST_DETERMINANT):
        return False
    for i in range(3):
        if not m[Y + 3 + i] > 0.0:
            return False
    a0 = m[Y] - m[ACCELERATION]
    a1 = m[Y + 1] - m[ACCELERATION + 1]
    a2 = m[Y + 2] - m[ACCELERATION + 2]
    again = max(1.0, ACCELERATION_TIME / dt)
    # Over long intervals too few changes are seen, and what a peg did within them is not.
    least = LEAST_AVERAGED if dt <= LONG_STEP else 1.0
    least_directed = LEAST_DIRECTED if dt <= LONG_STEP else 1.0
    for i in range(3):
        for j in range(3):
            dy[i, 3 + j] += dt * dy[i, j]
    uncertain = times_covariance(m, dy, 3)
    if not uncertain:
        for i in range(6):
            m[WITH + i] = 0.0
    # The innovation's covariance for friction, and that for angles and rates.
    c00 = covariance_entry(m, dy, 0, 0, uncertain)
    s10 = covariance_entry(m, dy, 1, 0, uncertain)
    c11 = covariance_entry(m, dy, 1, 1, uncertain)
    s20 = covariance_entry(m, dy, 2, 0, uncertain)
    s21 = covariance_entry(m, dy, 2, 1, uncertain)
    c22 = covariance_entry(m, dy, 2, 2, uncertain)
    s00 = c00 + again * _turning_variance(m, 0, acceleration_stddev, least)
    s11 = c11 + again * _turning_variance(m, 1, acceleration_stddev, least)
    s22 = c22 + again * _turning_variance(m, 2, acceleration_stddev, least)
    t00 = c00 + again * _turning_variance(m, 0, acceleration_stddev, least_directed)
    t11 = c11 + again * _turning_variance(m, 1, acceleration_stddev, least_directed)
    t22 = c22 + again * _turning_variance(m, 2, acceleration_stddev, least_directed)
    lower = factors(t00, s10, t11, s20, s21, t22)
    _note_unbalance(m, lower, a0, a1, a2)
    directed = directed and m[SLOW] > 0.0
    of_constants = s00, s10, s11, s20, s21, s22
    of_state = t00, s10, t11, s20, s21, t22
    resized = learns and diameter_outweighs(m, dy, of_constants)
    learns = learns and not resized
    if not (learns or directed or biased or resized):
        return False
    g0 = g1 = g2 = told = 0.0
    if learns:
        g0, g1, g2 = _friction_gain(m, factors(s00, s10, s11, s20, s21, s22))
        told = 2.0 * (g0 * m[WITH] + g1 * m[WITH + 2] + g2 * m[WITH + 4])
        told -= g0 * g0 * s00 + g1 * g1 * s11 + g2 * g2 * s22
        told -= 2.0 * (g0 * g1 * s10 + g0 * g2 * s20 + g1 * g2 * s21)
        learns = told > 0.0
    _fill_with_offsets(m, dy)
    if learns:
        moved = -(g0 * a0 + g1 * a1 + g2 * a2)
        move_parameters(m, moved, 0.0)
        m[SPREAD] = learnt_variance(m[SPREAD] - told, m[SPREAD], moved)
        m[SPREAD + 1] -= g0 * m[WITH + 1] + g1 * m[WITH + 3] + g2 * m[WITH + 5]
        m[SPREAD + 2] = m[SPREAD + 1]
        for k in range(int(m[OFFSETS]), int(m[OFFSETS + 1])):
            w = SEEN + 3 * k
            m[OFFSET_SPREAD + 10 * k] -= g0 * m[w] + g1 * m[w + 1] + g2 * m[w + 2]
        for j in range(12):
            m[CROSS + j] -= g0 * m[ROWS + j] + g1 * m[ROWS + 12 + j] + g2 * m[ROWS + 24 + j]
        # What the gains of the state take off its covariance with friction, beside, by its own
        # innovation: all covariances are then those of one error, and friction's has more.
        m[WITH] -= g0 * t00 + g1 * s10 + g2 * s20
        m[WITH + 2] -= g0 * s10 + g1 * t11 + g2 * s21
        m[WITH + 4] -= g0 * s20 + g1 * s21 + g2 * t22
    else:
        g0 = g1 = g2 = 0.0
    if directed:
        _correct_state(m, lower, a0, a1, a2)
    if biased:
        learn_bias(m, (a0, a1, a2), of_constants, of_state, (g0, g1, g2), directed)
    if resized:
        learn_diameter(m, (a0, a1, a2), of_constants, of_state, directed)
    return learns or directed or biased or resized


@inlined
def _note_unbalance(m, lower, a0, a1, a2):
    """Keep by how much the forces are off, over the lower root of its covariance."""
    l10, l20, l21, d0, d1, d2 = lower
    a1 -= l10 * a0
    a2 -= l20 * a0 + l21 * a1
    m[UNBALANCE] = 1.0
    m[UNBALANCE + 1] = a0 / sqrt(d0)
    m[UNBALANCE + 2] = a1 / sqrt(d1)
    m[UNBALANCE + 3] = a2 / sqrt(d2)


@inlined
def _turning_variance(m, i, stddev, least):
    """Return how far an angle's acceleration may be from the followed one of a bridged peg."""
    lags = LAGS * m[ACCELERATION + i]
    return acceleration_variance(m, i, stddev, least) + lags * lags


@inlined
def _friction_gain(m, lower):
    """Return the gain that the last interval to tell of friction gave; keep this one's."""
    g0, g1, g2 = solve(lower, m[WITH], m[WITH + 2], m[WITH + 4])
    share = (g0 * m[WITH] + g1 * m[WITH + 2] + g2 * m[WITH + 4]) / m[SPREAD]
    b0, b1, b2, told = m[TOLD_GAIN], m[TOLD_GAIN + 1], m[TOLD_GAIN + 2], m[TOLD_SHARE]
    # Gain and share of a friction whose variance is 1, all else being the same.
    over = 1.0 / ((1.0 - share) * m[SPREAD])
    m[TOLD_GAIN], m[TOLD_GAIN + 1], m[TOLD_GAIN + 2] = g0 * over, g1 * over, g2 * over
    m[TOLD_SHARE] = share * over
    if told > 0.0:
        scale = m[SPREAD] / (1.0 + told * m[SPREAD])
        g0, g1, g2 = b0 * scale, b1 * scale, b2 * scale
    return g0, g1, g2


@inlined
def _fill_with_offsets(m, dy):
    """Fill SEEN with the covariance of the accelerations with each offset that is not known."""
    for k in range(int(m[OFFSETS]), int(m[OFFSETS + 1])):
        at, spread = OFFSET_CROSS + 12 * k, OFFSET_SPREAD + 10 * k
        for i in range(3):
            total = dy[i, 12] * m[spread] + dy[i, 13] * m[spread + 1]
            for j in range(12):
                total += dy[i, j] * m[at + j]
            m[SEEN + 3 * k + i] = total


@inlined
def _correct_state(m, lower, a0, a1, a2):
    """Correct angles and rates by the accelerations, each with the optimal gain."""
    for i in range(6):
        g0, g1, g2 = solve(lower, m[ROWS + i], m[ROWS + 12 + i], m[ROWS + 24 + i])
        m[GAIN + i], m[GAIN + 12 + i], m[GAIN + 24 + i] = g0, g1, g2
        m[X + i] -= g0 * a0 + g1 * a1 + g2 * a2
        m[CROSS + i] -= g0 * m[WITH] + g1 * m[WITH + 2] + g2 * m[WITH + 4]
        m[CROSS + 12 + i] -= g0 * m[WITH + 1] + g1 * m[WITH + 3] + g2 * m[WITH + 5]
        for k in range(int(m[OFFSETS]), int(m[OFFSETS + 1])):
            w = SEEN + 3 * k
            m[OFFSET_CROSS + 12 * k + i] -= g0 * m[w] + g1 * m[w + 1] + g2 * m[w + 2]
    for i in range(6):
        g0, g1, g2 = m[GAIN + i], m[GAIN + 12 + i], m[GAIN + 24 + i]
        for j in range(i, 12):
            left = m[Z + 12 * i + j]
            left -= g0 * m[ROWS + j] + g1 * m[ROWS + 12 + j] + g2 * m[ROWS + 24 + j]
            m[Z + 12 * i + j] = left
            m[Z + 12 * j + i] = left
