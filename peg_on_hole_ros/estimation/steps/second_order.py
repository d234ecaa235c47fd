"""A step of second order, L-stable: two implicit Euler stages, each by line-searched Newton."""

from math import sqrt

from peg_on_hole_ros.estimation.steps.implicit_euler import CONVERGED, implicit_euler
from peg_on_hole_ros.mechanics.kernel import WIDTH, compiled

# Alexander's SDIRK of order 2 (SIAM J. Numer. Anal. 14, 1977): both stages with the same share of
# the step, the last one its end, so that a stiff component is gone after one step.
SHARE = 1.0 - 1.0 / sqrt(2.0)
_BEYOND = (1.0 - SHARE) / SHARE


@compiled
def sdirk2(p, scales, x, u_stage, u, h, x1, y, dy, slopes, stage, work):
    """
    Advance the state by one SDIRK step of order 2 under a wrench in peg axes.

    Stage 1 is an implicit Euler step of SHARE h; stage 2 is another from where the first one's
    mean velocity and acceleration lead in the rest of the step.

    Parameters
    ----------
    p, scales, x, u, h, x1, work
        As for `implicit_euler`; u is the wrench at the end.
    u_stage : ndarray, shape (6,)
        Wrench at SHARE of the step [N], [N m].
    y, dy : ndarray, shape (6,), (6, WIDTH)
        Filled with accelerations and reactions at the end, and their derivatives.
    slopes : ndarray, shape (6, WIDTH)
        Filled with the derivatives, by state, wrench, friction and peg diameter, of the rates at
        the end (rows 0 to 2) and of the angles at the end (rows 3 to 5).
    stage : ndarray, shape (>= 90,)
        Scratch.

    Returns
    -------
    status : int
        CONVERGED or FAILED; after FAILED x1 holds nothing of use.
    evaluations : int
        Of the six equations.

    """
    part = SHARE * h
    base, by_start = stage[:6], stage[6 : 6 + 6 * WIDTH].reshape(6, WIDTH)
    status, count = implicit_euler(p, scales, x, u_stage, part, x1, y, dy, slopes, work)
    if status != CONVERGED:
        return status, count
    for i in range(6):
        base[i] = x[i] + _BEYOND * (x1[i] - x[i])
    # Derivatives of the base: angles, then rates.
    for i in range(3):
        for j in range(WIDTH):
            by_start[i, j] = (1.0 - SHARE) * h * slopes[i, j]
            by_start[3 + i, j] = _BEYOND * slopes[i, j]
        by_start[i, i] += 1.0
        by_start[3 + i, 3 + i] += 1.0 - _BEYOND
    status, more = implicit_euler(p, scales, base, u, part, x1, y, dy, slopes, work)
    count += more
    if status != CONVERGED:
        return status, count
    for i in range(3):
        by_base = (
            slopes[i, 0], slopes[i, 1], slopes[i, 2], slopes[i, 3], slopes[i, 4], slopes[i, 5],
        )  # fmt: skip
        for j in range(WIDTH):
            total = slopes[i, j] if j >= 6 else 0.0
            for k in range(6):
                total += by_base[k] * by_start[k, j]
            slopes[i, j] = total
            slopes[3 + i, j] = by_start[i, j] + part * total
    return CONVERGED, count
