"""One implicit step of the three-degree-of-freedom motion, with its exact derivatives."""

from math import fabs, sqrt

from peg_on_hole_ros.mechanics.kernel import accelerate_with_derivatives, compiled

CONVERGED = 0
FAILED = 1

# Newton's quadratic convergence leaves the rate far below its standard deviation (1e-4 rad/s and
# more) times the 1e-6 to which this kernel is held against the reference filter.
RATE_TOLERANCE = 1e-11
MAX_ITERATIONS = 12
MAX_HALVINGS = 12


@compiled
def solve3(a, r0, r1, r2):
    """Solve a 3x3 system by cofactors; the iteration matrices here are well conditioned."""
    c0 = a[1, 1] * a[2, 2] - a[1, 2] * a[2, 1]
    c1 = a[1, 2] * a[2, 0] - a[1, 0] * a[2, 2]
    c2 = a[1, 0] * a[2, 1] - a[1, 1] * a[2, 0]
    over = 1.0 / (a[0, 0] * c0 + a[0, 1] * c1 + a[0, 2] * c2)
    d01 = a[0, 2] * a[2, 1] - a[0, 1] * a[2, 2]
    d02 = a[0, 1] * a[1, 2] - a[0, 2] * a[1, 1]
    d11 = a[0, 0] * a[2, 2] - a[0, 2] * a[2, 0]
    d12 = a[0, 2] * a[1, 0] - a[0, 0] * a[1, 2]
    d21 = a[0, 1] * a[2, 0] - a[0, 0] * a[2, 1]
    d22 = a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]
    return (
        (c0 * r0 + d01 * r1 + d02 * r2) * over,
        (c1 * r0 + d11 * r1 + d12 * r2) * over,
        (c2 * r0 + d21 * r1 + d22 * r2) * over,
    )


@compiled
def implicit_euler(p, scales, x, u, h, x1, y, dy, iteration, slopes, work):
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
    y, dy : ndarray, shape (6,), (6, 12)
        Filled with accelerations and reactions at the end, and their derivatives.
    iteration : ndarray, shape (3, 3)
        Scratch: the iteration matrix.
    slopes : ndarray, shape (3, 12)
        Filled with the derivatives of the rates at the end by the state at the start and by u.
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
            for i in range(3):
                for j in range(3):
                    iteration[i, j] = -h * (dy[i, 3 + j] + h * dy[i, j])
                iteration[i, i] += 1.0
            if sqrt(trial) <= RATE_TOLERANCE + 1e-13 * size:
                for j in range(12):
                    if 3 <= j < 6:
                        s0, s1, s2 = 1.0 * (j == 3), 1.0 * (j == 4), 1.0 * (j == 5)
                    else:
                        s0, s1, s2 = h * dy[0, j], h * dy[1, j], h * dy[2, j]
                    g0, g1, g2 = solve3(iteration, s0, s1, s2)
                    slopes[0, j], slopes[1, j], slopes[2, j] = g0, g1, g2
                return CONVERGED, evaluation + 1
            merit = trial
            v0, v1, v2 = x1[3], x1[4], x1[5]
            d0, d1, d2 = solve3(iteration, -r0, -r1, -r2)
            fraction = 1.0
            halvings = 0
        else:
            fraction *= 0.5
            halvings += 1
            if halvings > MAX_HALVINGS:
                return FAILED, evaluation + 1
    return FAILED, MAX_ITERATIONS + MAX_HALVINGS
