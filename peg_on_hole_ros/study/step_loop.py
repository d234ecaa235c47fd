"""All that a filter does for pairs of a wrench and an orientation, in one compiled loop."""

from peg_on_hole_ros.estimation import kernel
from peg_on_hole_ros.estimation.kernel import (
    correct,
    hold_wrench,
    innovation,
    predict_contact,
    predict_free,
)
from peg_on_hole_ros.estimation.memory import SLOW, R
from peg_on_hole_ros.estimation.reactions import react
from peg_on_hole_ros.estimation.slow import adapt_rate_noise, predict_slow
from peg_on_hole_ros.estimation.step import CONVERGED
from peg_on_hole_ros.mechanics.kernel import compiled

# `kernel.SLOW` is an outcome, `memory.SLOW` a place.
_SLOW_OUTCOME = kernel.SLOW


@compiled
def run_steps(
    m, dy, slopes, dt, count, wrenches, angles, covariances, acceleration_stddev,
    free_density,
):  # fmt: skip
    """
    Hold the wrench, predict, correct and react, for every step, as `filter.ContactFilter` does.

    Parameters
    ----------
    m, dy, slopes : ndarray
        A filter's memory, and scratch of shape (6, 14) and (3, 14).
    dt : float
        Between two steps [s].
    count : int
    wrenches : ndarray, shape (count * 6,)
        On the peg about its mass centre, peg axes [N], [N m].
    angles : ndarray, shape (count * 3,)
        Measured gamma, psi, phi [rad].
    covariances : ndarray, shape (count * 9,)
        Of the angles [rad^2].
    acceleration_stddev : float
        See `reactions.fuse_reactions` [rad/s^2].
    free_density : float
        Of the rates' random walk where the contact equations give no step [rad^2/s^3].

    Returns
    -------
    int
        How often the six equations were solved by the predictions.

    """
    total = 0
    for k in range(count):
        hold_wrench(m, wrenches[6 * k :])
        m[SLOW] = 0.0
        status, evaluations, _ = predict_contact(m, dy, slopes, dt)
        total += evaluations
        if status != CONVERGED:
            if status == _SLOW_OUTCOME:
                m[SLOW] = 1.0
                predict_slow(m, dy, slopes, dt, acceleration_stddev)
            else:
                predict_free(m, slopes, dt, free_density)
        for i in range(9):
            m[R + i] = covariances[9 * k + i]
        nis = innovation(m, angles[3 * k :])
        if m[SLOW] > 0.0:
            adapt_rate_noise(m, nis)
        correct(m)
        react(m, dy, acceleration_stddev)
    return total
