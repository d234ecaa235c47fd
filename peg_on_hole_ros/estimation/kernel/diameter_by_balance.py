"""The peg diameter by the balance of forces, where it may turn what friction makes of them."""

from peg_on_hole_ros.estimation.kernel.memory import (
    CROSS,
    GAIN,
    OFFSET_SPREAD,
    OFFSETS,
    ROWS,
    SEEN,
    SPREAD,
    WITH,
)
from peg_on_hole_ros.estimation.kernel.offsets import CAREFUL
from peg_on_hole_ros.estimation.kernel.parameters import (
    learns_bias,
    learns_clearance,
    move_diameter,
)
from peg_on_hole_ros.estimation.kernel.symmetric import factors, solve, times
from peg_on_hole_ros.mechanics.kernel import compiled, inlined

# A peg diameter that makes more than this share of how far the forces may be out of balance,
# squared, is learnt from it in friction's place. With a half, align with 0.02 mm, told 10 um too
# little, has its reactions covered in 72 % where a fifth and a tenth have 81 %; with a twentieth
# align with 0.1 mm, f 0.05 loses 4 %.
OUTWEIGHS = 0.2


@inlined
def diameter_outweighs(m, dy, of_constants):
    """
    Return whether the balance of forces is to teach the peg diameter, and not friction.

    Parameters
    ----------
    m : ndarray
        Memory.
    dy : ndarray, shape (6, 14)
        Derivatives of accelerations and reactions by state, wrench, friction and peg diameter.
    of_constants : tuple of 6 float
        Covariance of the accelerations for what is one number all along, as for
        `symmetric.factors`.

    """
    if not learns_clearance(m) or learns_bias(m):
        return False
    s00, s10, s11, s20, s21, s22 = of_constants
    e0, e1, e2 = dy[0, 13], dy[1, 13], dy[2, 13]
    g0, g1, g2 = solve(factors(s00, s10, s11, s20, s21, s22), e0, e1, e2)
    return m[SPREAD + 3] * (g0 * e0 + g1 * e1 + g2 * e2) > OUTWEIGHS


@compiled
def learn_diameter(m, off, of_constants, of_state, corrected):
    """
    Correct the peg diameter by how far the forces are out of balance, with a share of the gain.

    The levers of the contacts change with the diameter, and turn what friction makes of the
    forces. Where they are hardly known, a filter takes each turn for news of friction, which
    moves to where it makes up for the diameter.

    Parameters
    ----------
    m : ndarray
        Memory, the state already corrected: ROWS holds the covariance of the accelerations with
        state and wrench, WITH with friction and peg diameter, and SEEN with the offsets.
    off : tuple of 3 float
        The accelerations, less those that are expected [rad/s^2].
    of_constants, of_state : tuple of 6 float
        Covariance of that for what is one number all along, and for angles and rates; as for
        `symmetric.factors`.
    corrected : bool
        Whether angles and rates were; their gain is in GAIN.

    """
    a0, a1, a2 = off
    s00, s10, s11, s20, s21, s22 = of_constants
    w0, w1, w2 = m[WITH + 1], m[WITH + 3], m[WITH + 5]
    g0, g1, g2 = solve(factors(s00, s10, s11, s20, s21, s22), w0, w1, w2)
    g0, g1, g2 = CAREFUL * g0, CAREFUL * g1, CAREFUL * g2
    move_diameter(m, -(g0 * a0 + g1 * a1 + g2 * a2))
    for j in range(12):
        r0, r1, r2 = m[ROWS + j], m[ROWS + 12 + j], m[ROWS + 24 + j]
        if corrected and j < 6:
            h0, h1, h2 = times(of_state, m[GAIN + j], m[GAIN + 12 + j], m[GAIN + 24 + j])
            r0, r1, r2 = r0 - h0, r1 - h1, r2 - h2
        m[CROSS + 12 + j] -= g0 * r0 + g1 * r1 + g2 * r2
    m[SPREAD + 1] -= g0 * m[WITH] + g1 * m[WITH + 2] + g2 * m[WITH + 4]
    m[SPREAD + 2] = m[SPREAD + 1]
    h0, h1, h2 = times(of_constants, g0, g1, g2)
    m[SPREAD + 3] -= g0 * (2.0 * w0 - h0) + g1 * (2.0 * w1 - h1) + g2 * (2.0 * w2 - h2)
    for k in range(int(m[OFFSETS]), int(m[OFFSETS + 1])):
        w = SEEN + 3 * k
        m[OFFSET_SPREAD + 10 * k + 1] -= g0 * m[w] + g1 * m[w + 1] + g2 * m[w + 2]
