"""All that a filter does for pairs of a wrench and an orientation, in one compiled loop."""

from peg_on_hole_ros.estimation.kernel.correction import innovation
from peg_on_hole_ros.estimation.kernel.cycle import correct_and_follow, predict_or_bridge
from peg_on_hole_ros.estimation.kernel.held_wrench import hold_wrench
from peg_on_hole_ros.estimation.kernel.memory import R
from peg_on_hole_ros.estimation.kernel.reactions import react
from peg_on_hole_ros.mechanics.kernel import compiled


@compiled
def run_steps(
    m, dy, slopes, dt, count, wrenches, angles, covariances, acceleration_stddev,
    free_rate_noise,
):  # fmt: skip
    """
    Hold the wrench, predict, correct and react, for every step, as a peg that slides needs it.

    `filters.contact.ContactFilter` does more: it doubts a friction that leaves no step, judges
    each innovation, and knows which share of a ramp a prediction is, what a step told of a
    clearance before one that is not believed, and when the peg is free. Without any of these the
    two are the same.

    Parameters
    ----------
    m, dy, slopes : ndarray
        A filter's memory, and scratch of shape (6, 14) and (6, 14).
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
        See `reactions.react` [rad/s^2].
    free_rate_noise : float
        Least random walk of the rates where the contact equations give no step [rad/s^1.5].

    Returns
    -------
    int
        How often the six equations were solved by the predictions.

    """
    total = 0
    for k in range(count):
        hold_wrench(m, wrenches[6 * k :])
        _, evaluations = predict_or_bridge(m, dy, slopes, dt, acceleration_stddev, free_rate_noise)
        total += evaluations
        for i in range(9):
            m[R + i] = covariances[9 * k + i]
        correct_and_follow(m, innovation(m, angles[3 * k :]), dt)
        react(m, dy, acceleration_stddev)
    return total
