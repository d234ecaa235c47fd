"""The linearly implicit (Rosenbrock-)Euler step: one linear system, no iteration."""

from math import fabs, inf

from peg_on_hole_ros.estimation.steps.implicit_euler import (
    CONVERGED,
    FAILED,
    inverse_of,
    times_column,
)
from peg_on_hole_ros.mechanics.kernel import WIDTH, accelerate_with_derivatives, compiled

# No rate of a held peg grows so within a step; past a kink the tangent of friction says it does.
_LARGEST_GROWTH = 1e3

# Share of the step along which second derivatives are taken, from the exact first ones. What it
# leaves of the third derivatives, and rounding over it, are both near 1e-6 of a slope.
_ALONG = 1e-6


@compiled
def linearly_implicit_euler(p, scales, x, u, h, x1, y, dy, slopes, stage, work):
    """
    Advance the state by one linearly implicit Euler step under a wrench held in peg axes.

    The first of Newton's iterations for the implicit Euler step, taken whole: of first order and
    L-stable, at a fixed cost. It sees friction only as its tangent at the start, so a slip that
    comes to rest or turns round within the step is carried past its kink.

    Parameters
    ----------
    p, scales, x, u, h, x1, work
        As for `implicit_euler`.
    y, dy : ndarray, shape (6,), (6, WIDTH)
        Filled with accelerations and reactions at the start, and their derivatives.
    slopes : ndarray, shape (>= 3, WIDTH)
        Filled with the derivatives of the rates at the end by state, wrench, friction and peg
        diameter: those of the step itself, with the second derivatives that its matrix brings in.
    stage : ndarray, shape (>= 96,)
        Scratch.

    Returns
    -------
    status : int
        CONVERGED, or FAILED where the end is not finite or no motion of a held peg.
    evaluations : int
        Of the six equations: 2, the second for the slopes alone.

    """
    accelerate_with_derivatives(p, scales, x, u, work, y, dy)
    row0, row1, row2 = inverse_of(h, dy)
    r0 = h * (y[0] + h * (dy[0, 0] * x[3] + dy[0, 1] * x[4] + dy[0, 2] * x[5]))
    r1 = h * (y[1] + h * (dy[1, 0] * x[3] + dy[1, 1] * x[4] + dy[1, 2] * x[5]))
    r2 = h * (y[2] + h * (dy[2, 0] * x[3] + dy[2, 1] * x[4] + dy[2, 2] * x[5]))
    x1[3] = x[3] + times_column(row0, r0, r1, r2)
    x1[4] = x[4] + times_column(row1, r0, r1, r2)
    x1[5] = x[5] + times_column(row2, r0, r1, r2)
    for i in range(3):
        x1[i] = x[i] + h * x1[3 + i]
    moved, y_moved, dy_moved = stage[:6], stage[6:12], stage[12 : 12 + 6 * WIDTH].reshape(6, WIDTH)
    for i in range(6):
        moved[i] = x[i] + _ALONG * (x1[i] - x[i])
    accelerate_with_derivatives(p, scales, moved, u, work, y_moved, dy_moved)
    total = x1[0] + x1[1] + x1[2] + x1[3] + x1[4] + x1[5]
    for j in range(WIDTH):
        r0, r1, r2 = h * dy[0, j], h * dy[1, j], h * dy[2, j]
        if 3 <= j < 6:
            r0 += h * h * dy[0, j - 3]
            r1 += h * h * dy[1, j - 3]
            r2 += h * h * dy[2, j - 3]
        # The matrix of the step depends on the state too.
        r0 += h * (dy_moved[0, j] - dy[0, j]) / _ALONG
        r1 += h * (dy_moved[1, j] - dy[1, j]) / _ALONG
        r2 += h * (dy_moved[2, j] - dy[2, j]) / _ALONG
        slopes[0, j] = times_column(row0, r0, r1, r2)
        slopes[1, j] = times_column(row1, r0, r1, r2)
        slopes[2, j] = times_column(row2, r0, r1, r2)
        total += slopes[0, j] + slopes[1, j] + slopes[2, j]
    for i in range(3):
        slopes[i, 3 + i] += 1.0
    growth = 0.0
    for i in range(3):
        for j in range(3, 6):
            growth = max(growth, fabs(slopes[i, j]))
    # A NaN fails the comparison.
    good = fabs(total) < inf and growth < _LARGEST_GROWTH
    return (CONVERGED if good else FAILED), 2
