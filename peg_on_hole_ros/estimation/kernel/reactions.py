"""Normal reactions and slip speeds at an estimate, with their covariance."""

from math import isfinite, nan

from peg_on_hole_ros.estimation.kernel.memory import (
    ANSWERS,
    ON_CONTACTS,
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
    process_of,
    times_covariance,
)
from peg_on_hole_ros.estimation.kernel.slip import bridged_scales
from peg_on_hole_ros.estimation.kernel.slow_reactions import balance_reactions
from peg_on_hole_ros.estimation.kernel.weighing import SURPRISE_LIMIT, weigh_accelerations
from peg_on_hole_ros.mechanics.kernel import (
    accelerate,
    accelerate_with_derivatives,
    compiled,
    scene_of,
)


@compiled
def react(m, dy, acceleration_stddev):
    """
    Fill Y with the reactions of three-point contact at the estimate, and REACTIONS.

    Where the last prediction was off contacts, no step has tied the rates to the wrench; where the
    six equations' answer has accelerations that a held peg cannot have, the slip points elsewhere,
    and with it all that follows. Its direction is then as unknown as that of a slow slip.

    Parameters
    ----------
    m : ndarray
        Memory: the mean is filled in at Y, and its covariance at REACTIONS.
    dy : ndarray, shape (6, 14)
        Scratch.
    acceleration_stddev : float
        Of each angle at most, beside what `acceleration_variance` adds [rad/s^2].

    Returns
    -------
    float
        Determinant over its frictionless value; NaN where the equations have no finite answer.

    """
    x, u, y = m[X : X + 6], m[U : U + 6], m[Y : Y + 6]
    scales, work = m[SCALES : SCALES + 3], m[WORK:]
    p, process = scene_of(m), process_of(m)
    determinant, told = nan, False
    if m[ON_CONTACTS] > 0.0 and m[SLOW] == 0.0:
        determinant = accelerate_with_derivatives(p, scales, x, u, work, y, dy)
        told = _fuse(m, dy, acceleration_stddev)
    if not told and m[SLOW] == 0.0:
        bridged_scales(p, m, process.slip_velocity_scale, process.slip_widening)
    if not told:
        determinant = accelerate(p, scales, x, u, work, y)
        balance_reactions(p, m, dy, acceleration_stddev)
    # A sum is finite only if all of its terms are.
    total = determinant
    for i in range(6):
        total += y[i]
        for j in range(6):
            total += m[REACTIONS + 6 * i + j]
    return determinant if isfinite(total) else nan


@compiled
def _fuse(m, dy, acceleration_stddev):
    """
    Weigh the six equations' answer at Y, with its derivatives, against how a held peg accelerates.

    Near the singular set the equations trade huge accelerations for huge reactions; force balance
    with a bounded acceleration does not. As a Bayesian update with accelerations as the rates went
    of late, within how much they changed, the two are one formula, without a switch.

    Returns
    -------
    bool
        Whether these accelerations are what a held peg can have.

    """
    uncertain = times_covariance(m, dy, 6)
    for i in range(6):
        for j in range(i + 1):
            total = covariance_entry(m, dy, i, j, uncertain)
            m[REACTIONS + 6 * i + j] = total
            m[REACTIONS + 6 * j + i] = total
    fill_lasting(m, uncertain)
    for i in range(6):
        m[ANSWERS + i] = m[Y + i]
    weigh_accelerations(m, 0, uncertain, acceleration_stddev)
    for i in range(6):
        m[Y + i] = m[ANSWERS + i]
    return m[SURPRISE] <= SURPRISE_LIMIT
