"""Reactions as closed contacts can have them: they push, and never pull."""

import numpy as np

from peg_on_hole_ros.estimator.record import REACTIONS, WORK, Y
from peg_on_hole_ros.mechanics.kernel import compiled

# A pass leaves of what is still to go the square of the correlation of those that would pull.
PASSES = 1000
# It is done where a pass moves none by more than this share of a standard deviation.
SMALL = 1e-10


@compiled
def fill_pushing(m: np.ndarray, out: np.ndarray, normal: int) -> None:
    """
    Fill in the reactions nearest to the estimated ones of which none is below zero.

    Nearest in units of their covariance: what one may not pull moves the others as far as they
    vary with it. In these units the true reactions, which push, are never farther from it than
    from the estimate, so that the covariance that was found still covers it. Dual coordinate
    ascent of Hildreth (Naval Research Logistics Quarterly 4, 1957, 79-85).

    Parameters
    ----------
    m : ndarray
        Record, see `record`.
    out : ndarray
        Filled at three places.
    normal : int
        Their first: N_K, N_B1, N_B2 [N].

    """
    least = 0.0
    for i in range(3):
        out[normal + i] = m[Y + 3 + i]
        least = min(least, m[Y + 3 + i])
    if least == 0.0:
        return
    at = REACTIONS + 21
    for i in range(3):
        m[WORK + i] = 0.0
    for _ in range(PASSES):
        moved = 0.0
        for i in range(3):
            variance = m[at + 7 * i]
            if variance <= 0.0:
                continue
            step = max(-m[WORK + i], -out[normal + i] / variance)
            m[WORK + i] += step
            moved = max(moved, step * step * variance)
            for j in range(3):
                out[normal + j] += m[at + 6 * i + j] * step
        if moved <= SMALL * SMALL:
            break
    for i in range(3):
        out[normal + i] = max(out[normal + i], 0.0)
