"""The implicit Euler step, the default of `choice`, with its exact derivatives."""

from math import fabs, sqrt

from peg_on_hole_ros.mechanics.kernel import WIDTH, accelerate_with_derivatives, compiled, inlined

CONVERGED = 0
FAILED = 1

# Newton's quadratic convergence leaves the rate far below its standard deviation (1e-4 rad/s and
# more) times the 1e-6 to which this kernel is held against the reference filter.
RATE_TOLERANCE = 1e-11
MAX_ITERATIONS = 12
MAX_HALVINGS = 12


@inlined
def _entry(h, dy, i, j):
    return -h * (dy[i, 3 + j] + h * dy[i, j])


@inlined
def _matrix(h, dy):
    """Return the iteration matrix, by rows."""
    return (
        (1.0 + _entry(h, dy, 0, 0), _entry(h, dy, 0, 1), _entry(h, dy, 0, 2)),
        (_entry(h, dy, 1, 0), 1.0 + _entry(h, dy, 1, 1), _entry(h, dy, 1, 2)),
        (_entry(h, dy, 2, 0), _entry(h, dy, 2, 1), 1.0 + _entry(h, dy, 2, 2)),
    )


@inlined
def determinant_of(h, dy):
    """Return the determinant of the iteration matrix."""
    (a00, a01, a02), (a10, a11, a12), (a20, a21, a22) = _matrix(h, dy)
    c0, c1, c2 = a11 * a22 - a12 * a21, a12 * a20 - a10 * a22, a10 * a21 - a11 * a20
    return a00 * c0 + a01 * c1 + a02 * c2


@inlined
def inverse_of(h, dy):
    """Return the inverse of the iteration matrix, by rows: 3x3, well conditioned, by cofactors."""
    (a00, a01, a02), (a10, a11, a12), (a20, a21, a22) = _matrix(h, dy)
    c0, c1, c2 = a11 * a22 - a12 * a21, a12 * a20 - a10 * a22, a10 * a21 - a11 * a20
    over = 1.0 / (a00 * c0 + a01 * c1 + a02 * c2)
    return (
        (over * c0, over * (a02 * a21 - a01 * a22), over * (a01 * a12 - a02 * a11)),
        (over * c1, over * (a00 * a22 - a02 * a20), over * (a02 * a10 - a00 * a12)),
        (over * c2, over * (a01 * a20 - a00 * a21), over * (a00 * a11 - a01 * a10)),
    )


@inlined
def times_column(row, r0, r1, r2):
    """Return a row of three times a column."""
    return row[0] * r0 + row[1] * r1 + row[2] * r2


@inlined
def fill_slopes(h, dy, row0, row1, row2, slopes):
    """Fill the derivatives of the rates at the end, (3, 14), from `inverse_of`; may be in dy."""
    for j in range(WIDTH):
        d0, d1, d2 = h * dy[0, j], h * dy[1, j], h * dy[2, j]
        slopes[0, j] = times_column(row0, d0, d1, d2)
        slopes[1, j] = times_column(row1, d0, d1, d2)
        slopes[2, j] = times_column(row2, d0, d1, d2)
    for j in range(3):
        slopes[0, 3 + j], slopes[1, 3 + j], slopes[2, 3 + j] = row0[j], row1[j], row2[j]


@compiled
def implicit_euler(p, scales, x, u, h, x1, y, dy, slopes, work):
    """
    Advance the state by one implicit Euler step under a wrench held in peg axes.

    Newton's method with a line search: without one it overshoots the kink of dry friction into
    solutions that are not the motion's.

    Parameters
    ----------
    p : SceneScalars
    scales : ndarray, shape (3,)
        Velocity scales of friction at K, B1, B2 [m/s].
    x : ndarray, shape (6,)
        State at the start [rad], [rad/s].
    u : ndarray, shape (6,)
        Applied wrench about the mass centre, peg axes [N], [N m].
    h : float
        Step [s], above 0.
    x1 : ndarray, shape (6,)
        Filled with the state at the end.
    y, dy : ndarray, shape (6,), (6, 14)
        Filled with accelerations and reactions at the end, and their derivatives.
    slopes : ndarray, shape (3, 14)
        Filled with the derivatives of the rates at the end by the state at the start, by u, and
        by friction and peg diameter.
    work : ndarray
        From `kernel.workspace`.

    Returns
    -------
    status : int
        CONVERGED or FAILED; after FAILED x1 holds nothing of use.
    iterations : int
        Evaluations of the six equations.

    """
    v0, v1, v2 = x[3], x[4], x[5]
    d0 = d1 = d2 = 0.0
    merit = -1.0
    fraction = 1.0
    halvings = 0
    for evaluation in range(MAX_ITERATIONS + MAX_HALVINGS):
        x1[3] = v0 + fraction * d0
        x1[4] = v1 + fraction * d1
        x1[5] = v2 + fraction * d2
        x1[0] = x[0] + h * x1[3]
        x1[1] = x[1] + h * x1[4]
        x1[2] = x[2] + h * x1[5]
        accelerate_with_derivatives(p, scales, x1, u, work, y, dy)
        r0 = x1[3] - x[3] - h * y[0]
        r1 = x1[4] - x[4] - h * y[1]
        r2 = x1[5] - x[5] - h * y[2]
        trial = r0 * r0 + r1 * r1 + r2 * r2
        size = h * (fabs(y[0]) + fabs(y[1]) + fabs(y[2]))
        # A NaN (a tilt below gamma0) fails the comparison, and the step is halved.
        if merit < 0.0 and trial != trial:
            return FAILED, evaluation + 1
        if merit < 0.0 or trial < merit or trial <= RATE_TOLERANCE * RATE_TOLERANCE:
            row0, row1, row2 = inverse_of(h, dy)
            if sqrt(trial) <= RATE_TOLERANCE + 1e-13 * size:
                fill_slopes(h, dy, row0, row1, row2, slopes)
                return CONVERGED, evaluation + 1
            merit = trial
            v0, v1, v2 = x1[3], x1[4], x1[5]
            d0 = -times_column(row0, r0, r1, r2)
            d1 = -times_column(row1, r0, r1, r2)
            d2 = -times_column(row2, r0, r1, r2)
            fraction = 1.0
            halvings = 0
        else:
            fraction *= 0.5
            halvings += 1
            if halvings > MAX_HALVINGS:
                return FAILED, evaluation + 1
    return FAILED, MAX_ITERATIONS + MAX_HALVINGS
