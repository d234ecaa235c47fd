"""A bias of the sensor by the balance of forces, where no step is believed that would tell it."""

from peg_on_hole_ros.estimation.kernel.memory import (
    GAIN,
    GAINS,
    OFFSET,
    OFFSET_CROSS,
    OFFSET_SPREAD,
    OFFSETS,
    ROWS,
    SEEN,
    WITH,
)
from peg_on_hole_ros.estimation.kernel.offsets import BIAS, CAREFUL
from peg_on_hole_ros.estimation.kernel.symmetric import factors, solve, times
from peg_on_hole_ros.mechanics.kernel import compiled

_END = BIAS.stop


@compiled
def learn_bias(m, off, of_constants, of_state, friction, corrected):
    """
    Correct the bias by how far the forces are out of balance, and what it shares with all else.

    Accelerations are linear in a wrench, so that a tangent by a bias stays one, wherever friction
    is taken to be; one by friction does not, and would call known what is not. Where steps are
    hidden by what is not known of the bias, only this tells of it.

    Parameters
    ----------
    m : ndarray
        Memory, all else already corrected: SEEN holds the covariance of the accelerations with
        the offsets, ROWS with state and wrench, and WITH with friction and peg diameter; of
        friction that which the gain of the state has left.
    off : tuple of 3 float
        The accelerations, less those that are expected [rad/s^2].
    of_constants, of_state : tuple of 6 float
        Covariance of that for what is one number all along, and for angles and rates; as for
        `symmetric.factors`.
    friction : tuple of 3 float
        The gain of friction, zero where it was not learnt.
    corrected : bool
        Whether angles and rates were; their gain is in GAIN.

    """
    end = int(m[OFFSETS + 1])
    s00, s10, s11, s20, s21, s22 = of_constants
    t00, _, t11, _, _, t22 = of_state
    a0, a1, a2 = off
    g0, g1, g2 = friction
    # Friction has more than the error that all share.
    f0 = m[WITH] - (s00 - t00) * g0
    f1 = m[WITH + 2] - (s11 - t11) * g1
    f2 = m[WITH + 4] - (s22 - t22) * g2
    lower = factors(s00, s10, s11, s20, s21, s22)
    for k in range(_END):
        w, g = SEEN + 3 * k, GAINS + 3 * k
        g0, g1, g2 = solve(lower, m[w], m[w + 1], m[w + 2])
        m[g], m[g + 1], m[g + 2] = CAREFUL * g0, CAREFUL * g1, CAREFUL * g2
        m[OFFSET + k] -= m[g] * a0 + m[g + 1] * a1 + m[g + 2] * a2
    for j in range(12):
        r0, r1, r2 = m[ROWS + j], m[ROWS + 12 + j], m[ROWS + 24 + j]
        if corrected and j < 6:
            h0, h1, h2 = times(of_state, m[GAIN + j], m[GAIN + 12 + j], m[GAIN + 24 + j])
            r0, r1, r2 = r0 - h0, r1 - h1, r2 - h2
        for k in range(_END):
            g = GAINS + 3 * k
            m[OFFSET_CROSS + 12 * k + j] -= m[g] * r0 + m[g + 1] * r1 + m[g + 2] * r2
    for k in range(_END):
        g, at = GAINS + 3 * k, OFFSET_SPREAD + 10 * k
        m[at] -= m[g] * f0 + m[g + 1] * f1 + m[g + 2] * f2
        m[at + 1] -= m[g] * m[WITH + 1] + m[g + 1] * m[WITH + 3] + m[g + 2] * m[WITH + 5]
        o0, o1, o2 = times(of_constants, m[g], m[g + 1], m[g + 2])
        w = SEEN + 3 * k
        o0, o1, o2 = m[w] - o0, m[w + 1] - o1, m[w + 2] - o2
        for l in range(end):
            if k < l < _END:
                continue
            w, h = SEEN + 3 * l, GAINS + 3 * l
            left = m[at + 2 + l] - (m[g] * m[w] + m[g + 1] * m[w + 1] + m[g + 2] * m[w + 2])
            # A tilt has no gain.
            if l < _END:
                left -= m[h] * o0 + m[h + 1] * o1 + m[h + 2] * o2
            m[at + 2 + l] = m[OFFSET_SPREAD + 10 * l + 2 + k] = left
