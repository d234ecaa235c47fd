"""Reactions where no slip has a sure direction: a balance of forces, friction its noise."""

from math import fabs, sqrt

from peg_on_hole_ros.estimation.kernel.forces import rim_load
from peg_on_hole_ros.estimation.kernel.memory import (
    ACCELERATION,
    ANSWERS,
    FRICTION,
    LASTING,
    REACTIONS,
    SCALES,
    SPREAD,
    SURPRISE,
    WORK,
    U,
    X,
    Y,
    covariance_entry,
    fill_lasting,
    times_covariance,
)
from peg_on_hole_ros.estimation.kernel.parameters import LEAST_FRICTION, friction_known_to
from peg_on_hole_ros.estimation.kernel.slow_friction import (
    WAYS,
    answers_to_friction,
    unknown_friction,
)
from peg_on_hole_ros.estimation.kernel.weighing import (
    SURPRISE_LIMIT,
    weigh_accelerations,
    weigh_loads,
)
from peg_on_hole_ros.mechanics.kernel import (
    accelerate,
    compiled,
    inlined,
    slopes_of_answer,
    with_friction,
)

# Balance of forces without a direction of friction: passes from the load to where its slopes are
# taken, how many standard deviations above the reactions friction's noise is taken at, and their
# least share of the load.
PASSES = 3
UPPER = 0.5
LEAST_LOAD = 0.2
# Before any balance reactions are this share of those that carry the load and hold it by friction,
# within all of them.
CARRIED = 0.2
# Share of what is not known of friction's direction by which the gain is weighed; the rest is in
# the covariance alone. The three directions are mostly turned together, as the slopes by the rates
# have it: with all of it in the gain a peg at rest is told worse, with none a slow closing.
WEIGHED = 0.2
# What friction makes of reactions is taken over so many deviations of it, where one is more than
# this share of it.
LOWER, HARDLY_KNOWN = 2.0, 0.05


@compiled
def balance_reactions(p, m, dy, acceleration_stddev):
    """
    Weigh the balance of forces against how fast a held peg can accelerate, friction being noise.

    Where no slip has a sure direction the six equations' answer at the estimate may be anything:
    near the singular set a slip turned a little makes reactions ten times as large, and slopes
    taken there say nothing of the true ones. So the equations A y = r are straightened where
    accelerations and reactions can be: at the followed acceleration and the load, then where the
    last pass has them. What state, wrench, friction and its direction leave unknown of A y - r is
    the noise of that balance, and the prior of the accelerations is weighed against it. Friction
    is unknown by as much as reactions UPPER standard deviations higher make of it: its noise grows
    with them, and an estimate that is too low would otherwise be too sure as well. So would one
    that pulls, which may be the answer of a slip that points elsewhere: its size counts.

    Reactions go up faster with less friction than they go down with more. Where friction is hardly
    known, what it makes of them is half of what they differ by at a friction two deviations lower.

    Parameters
    ----------
    m : ndarray
        Memory, with the variance across the slips at ACROSS. The mean is filled in at Y, its
        covariance at REACTIONS, and LASTING.
    p, dy, acceleration_stddev
        As for `reactions.react`; dy is changed.

    """
    low, hardly = ANSWERS + 12, not friction_known_to(m, HARDLY_KNOWN)
    if hardly:
        lower = max(p.f - LOWER * sqrt(m[SPREAD]), LEAST_FRICTION)
        _balance(with_friction(p, lower), m, dy, acceleration_stddev)
        for i in range(6):
            m[low + i] = m[ANSWERS + i]
    _balance(p, m, dy, acceleration_stddev)
    if hardly:
        _secant(m, low)
    growth = max(1.0, m[SURPRISE] / SURPRISE_LIMIT)
    for i in range(36):
        m[REACTIONS + i] *= growth
    for i in range(6):
        m[Y + i] = m[ANSWERS + i]


@compiled
def _balance(p, m, dy, acceleration_stddev):
    """Fill ANSWERS, REACTIONS, LASTING and SURPRISE at the friction of a scene."""
    x, u, y, work = m[X : X + 6], m[U : U + 6], m[Y : Y + 6], m[WORK:]
    scales, answer = m[SCALES : SCALES + 3], m[ANSWERS + 6 : ANSWERS + 12]
    accelerate(p, scales, x, u, work, answer)
    force, couple = rim_load(m)
    load = force + 2.0 * couple / p.d
    holding = load * (1.0 + 1.0 / max(p.f, LEAST_FRICTION))
    for i in range(3):
        y[i], y[3 + i] = m[ACCELERATION + i], load
    answers_to_friction(p, m)
    for _ in range(PASSES):
        slopes_of_answer(p, scales, x, u, work, y, dy)
        unknown_friction(m)
        uncertain = times_covariance(m, dy, 6)
        for i in range(6):
            for j in range(i + 1):
                total = covariance_entry(m, dy, i, j, uncertain)
                for n in range(WAYS):
                    total += WEIGHED * m[FRICTION + 6 * n + i] * m[FRICTION + 6 * n + j]
                m[REACTIONS + 6 * i + j] = total
                m[REACTIONS + 6 * j + i] = total
        fill_lasting(m, uncertain)
        for i in range(6):
            m[ANSWERS + i] = answer[i]
        weigh_accelerations(m, WAYS, uncertain, acceleration_stddev)
        _add_unweighed(m)
        weigh_loads(m, CARRIED * holding, holding, uncertain)
        for i in range(3):
            upper = UPPER * sqrt(max(m[REACTIONS + 7 * (3 + i)], 0.0))
            y[i] = m[ANSWERS + i]
            y[3 + i] = max(fabs(m[ANSWERS + 3 + i]) + upper, LEAST_LOAD * load)


@inlined
def _add_unweighed(m):
    """Add to REACTIONS what of friction's noise had no part in the gain."""
    for i in range(6):
        for j in range(6):
            total = 0.0
            for n in range(WAYS):
                total += m[FRICTION + 6 * n + i] * m[FRICTION + 6 * n + j]
            m[REACTIONS + 6 * i + j] += (1.0 - WEIGHED) * total


@inlined
def _secant(m, low):
    """Take friction's part of the covariance from the answer at a lower one, if that is more."""
    more = 0.0
    for i in range(6):
        m[low + i] = (m[low + i] - m[ANSWERS + i]) / LOWER
        if i >= 3:
            more += m[low + i] * m[low + i] - m[LASTING + i] * m[LASTING + i]
    if more > 0.0:
        for i in range(6):
            for j in range(6):
                secant = m[low + i] * m[low + j]
                m[REACTIONS + 6 * i + j] += secant - m[LASTING + i] * m[LASTING + j]
        for i in range(6):
            m[LASTING + i] = m[low + i]
