"""Which step the prediction takes, and how far a long one may be trusted."""

from math import fabs, inf, sqrt

from peg_on_hole_ros.estimation.steps.implicit_euler import FAILED, implicit_euler
from peg_on_hole_ros.estimation.steps.linearly_implicit import linearly_implicit_euler
from peg_on_hole_ros.estimation.steps.second_order import sdirk2
from peg_on_hole_ros.mechanics.kernel import accelerate, compiled, inlined

IMPLICIT_EULER, LINEARLY_IMPLICIT, SECOND_ORDER = 0, 1, 2
INTEGRATORS = {
    "implicit_euler": IMPLICIT_EULER,
    "linearly_implicit": LINEARLY_IMPLICIT,
    "second_order": SECOND_ORDER,
}

# Beside CONVERGED and FAILED of `implicit_euler`: a step that was found, with too large an error.
INACCURATE = FAILED + 1

# Shorter steps carry no error estimate: at the rates of force sensors, 0.5 kHz and more, what the
# wrench's noise moves is far above what a step errs, and the estimate would cost a third more.
LONG_STEP = 2.5e-3


@compiled
def take_step(integrator, p, scales, x, u_stage, u, h, x1, y, dy, slopes, stage, work):
    """
    Advance the state by one step of the chosen method; see the methods for the parameters.

    u is the wrench at the end, u_stage that at the first stage of the second order.

    Returns
    -------
    status : int
        CONVERGED or FAILED.
    evaluations : int
        Of the six equations.

    """
    if integrator == LINEARLY_IMPLICIT:
        return linearly_implicit_euler(p, scales, x, u, h, x1, y, dy, slopes, stage, work)
    if integrator == SECOND_ORDER:
        return sdirk2(p, scales, x, u_stage, u, h, x1, y, dy, slopes, stage, work)
    return implicit_euler(p, scales, x, u, h, x1, y, dy, slopes, work)


@compiled
def step_error(integrator, p, scales, x, u_begin, u, h, x1, y, slopes, stage, work):
    """
    Return the estimated error of the rates after a step, the largest of the three.

    What separates the step from the trapezoidal rule over the same interval. That rule lets stiff
    friction ring; the slopes of the rates by the rates take this out, as the step itself does
    (Hairer and Wanner, Solving Ordinary Differential Equations II, IV.8).

    Parameters
    ----------
    integrator, p, scales, x, u, h, x1, y, slopes, stage, work
        As given to `take_step`, and as it has left them.
    u_begin : ndarray, shape (6,)
        Wrench at the begin of the step; on a ramp it is not that at the end [N], [N m].

    Returns
    -------
    error : float
        [rad/s]; infinite where the equations have no answer.
    evaluations : int
        Of the six equations.

    """
    begin, end = stage[:6], stage[6:12]
    count = 1
    accelerate(p, scales, x, u_begin, work, begin)
    for i in range(6):
        end[i] = y[i]
    if integrator == LINEARLY_IMPLICIT:
        accelerate(p, scales, x1, u, work, end)
        count = 2
    r0 = x1[3] - x[3] - 0.5 * h * (begin[0] + end[0])
    r1 = x1[4] - x[4] - 0.5 * h * (begin[1] + end[1])
    r2 = x1[5] - x[5] - 0.5 * h * (begin[2] + end[2])
    e0 = fabs(slopes[0, 3] * r0 + slopes[0, 4] * r1 + slopes[0, 5] * r2)
    e1 = fabs(slopes[1, 3] * r0 + slopes[1, 4] * r1 + slopes[1, 5] * r2)
    e2 = fabs(slopes[2, 3] * r0 + slopes[2, 4] * r1 + slopes[2, 5] * r2)
    # A maximum would lose a NaN.
    return (max(e0, e1, e2) if e0 + e1 + e2 < inf else inf), count


@compiled
def contact_speed_gain(p, x, x1):
    """Return how much speed a contact gains between two states, along or around the rim [m/s]."""
    along = p.D * fabs(x1[3] - x[3])
    around = 0.5 * fabs(p.D * (x1[4] - x[4]) + p.d * (x1[5] - x[5]))
    return max(along, around)


@inlined
def friction_slack(p, friction_variance, slopes):
    """Return how much speed a contact may gain in a step by what friction may be off by [m/s]."""
    return (
        3.0
        * sqrt(max(friction_variance, 0.0))
        * max(
            p.D * fabs(slopes[0, 12]),
            0.5 * fabs(p.D * slopes[1, 12] + p.d * slopes[2, 12]),
        )
    )
