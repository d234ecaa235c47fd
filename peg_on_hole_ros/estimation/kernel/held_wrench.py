"""The wrench over an interval: as measured at its end, or a ramp up to that."""

from math import fabs, sqrt

from peg_on_hole_ros.estimation.kernel.memory import (
    CHANGE,
    CROSS,
    ENDS,
    JUMP,
    JUMPED,
    NOISE,
    RAMP,
    WEIGHT,
    U,
    Z,
    process_of,
)
from peg_on_hole_ros.estimation.steps.choice import SECOND_ORDER
from peg_on_hole_ros.estimation.steps.second_order import SHARE
from peg_on_hole_ros.mechanics.kernel import compiled, inlined

# Noise alone changes a wrench by more than this, its covariances' part squared, in 5 of 100 cases
# (six normal variables).
JUMP_LIMIT = 12.6
# Variance of the mean of a change that comes at any one time of an interval, over its square,
# where it was taken for a ramp.
AT_ANY_TIME = 1.0 / 12.0


@inlined
def _size(m, at):
    """Return how large a change of the wrench is in units of its noise, squared."""
    size = 0.0
    for i in range(6):
        for j in range(6):
            size += m[WEIGHT + 6 * i + j] * m[at + i] * m[at + j]
    return size


@compiled
def hold_wrench(m, u):
    """
    Start on a new wrench: its noise is independent of the state's error so far.

    The wrench of an interval is measured at its end, and held. Where it changed by more than its
    noise, as it does when friction turns round, it is a ramp from the one before. Of a change that
    goes on as in the interval before that is all; what is new may have come at any time within,
    and so the mean is off by it, with a mean square of a twelfth.

    Parameters
    ----------
    m : ndarray
        Memory.
    u : ndarray, shape (6,)
        Wrench about the mass centre, peg axes [N], [N m].

    """
    any_before = 0.0
    for i in range(6):
        any_before += fabs(m[U + i])
        change = u[i] - m[U + i]
        m[JUMP + i] = change - m[CHANGE + i]
        m[CHANGE + i] = change
        m[U + i] = u[i]
    size, new = _size(m, CHANGE), _size(m, JUMP)
    # Two noises differ by twice the covariance of one. Before the first wrench there is none.
    share = 0.0
    if any_before > 0.0 and size > 2.0 * JUMP_LIMIT:
        share = process_of(m).wrench_jump * sqrt(1.0 - 2.0 * JUMP_LIMIT / size)
    off = sqrt(AT_ANY_TIME * (new / size if new < size else 1.0))
    for i in range(6):
        m[RAMP + i] = share * m[CHANGE + i]
        m[JUMP + i] = off * m[RAMP + i]
    m[RAMP + 6], m[RAMP + 7] = 0.0, 1.0
    for i in range(6):
        for j in range(6):
            m[Z + 12 * i + 6 + j] = 0.0
            m[Z + 12 * (6 + i) + j] = 0.0
            m[Z + 12 * (6 + i) + 6 + j] = m[NOISE + 6 * i + j]
        m[CROSS + 6 + i] = m[CROSS + 18 + i] = 0.0


@inlined
def ramps(m):
    """Return whether the wrench is a ramp over its interval."""
    total = 0.0
    for i in range(6):
        total += fabs(m[RAMP + i])
    return total > 0.0


@inlined
def wrench_of_piece(m, piece, pieces):
    """Fill ENDS with the wrench of one of equal steps: at its end, its first stage, its begin."""
    over = (m[RAMP + 7] - m[RAMP + 6]) / pieces
    begin = m[RAMP + 6] + over * piece
    end = m[RAMP + 6] + over * (piece + 1.0)
    stage = m[RAMP + 6] + over * (piece + SHARE)
    for i in range(6):
        m[ENDS + i] = m[U + i] - (1.0 - end) * m[RAMP + i]
        m[ENDS + 6 + i] = m[U + i] - (1.0 - stage) * m[RAMP + i]
        m[ENDS + 12 + i] = m[U + i] - (1.0 - begin) * m[RAMP + i]


@inlined
def move_wrench(m, share):
    """Move the wrench by a share of its ramp."""
    for i in range(6):
        m[U + i] += share * m[RAMP + i]


@inlined
def add_jump(m, slopes, pieces, h, integrator):
    """Add what JUMP makes of the state; the slopes are those of the last of equal steps."""
    for i in range(3):
        moved = turned = 0.0
        for j in range(6):
            moved += slopes[i, 6 + j] * m[JUMP + j]
            if integrator == SECOND_ORDER:
                turned += slopes[3 + i, 6 + j] * m[JUMP + j]
        m[JUMPED + 3 + i] = pieces * moved
        m[JUMPED + i] = pieces * (turned if integrator == SECOND_ORDER else h * moved)
    for i in range(6):
        for j in range(6):
            m[Z + 12 * i + j] += m[JUMPED + i] * m[JUMPED + j]
