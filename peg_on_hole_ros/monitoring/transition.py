"""The end of three-point contact: how likely it has come, and how soon it will."""

from math import sin, sqrt

from peg_on_hole_ros.monitoring.mode import normal_probability
from peg_on_hole_ros.options import MonitorOptions


def gamma0_stddev(gamma0: float, hole_diameter: float, clearance_stddev: float) -> float:
    """
    Return the standard deviation of gamma0 that comes from the clearance [rad].

    cos(gamma0) = 1 - clearance/D, so d(gamma0) = d(clearance) / (D sin(gamma0)).
    """
    return clearance_stddev / (hole_diameter * sin(gamma0))


def transition_probability(gamma, gamma_stddev, gamma0, gamma0_stddev) -> float:
    """Return the probability that gamma is below gamma0, both normal and independent [rad]."""
    spread = sqrt(gamma_stddev**2 + gamma0_stddev**2)
    return normal_probability((gamma0 - gamma) / max(spread, 1e-12))


def time_to_transition(margin, rate, margin_variance, rate_variance, covariance):
    """
    Return time until gamma reaches gamma0 at the present rate, and its standard deviation.

    Parameters
    ----------
    margin : float
        gamma - gamma0 [rad].
    rate : float
        gamma' [rad/s].
    margin_variance, rate_variance, covariance : float
        Of margin and rate.

    Returns
    -------
    (float, float) or None
        [s]; None without a closing motion, that is unless the rate is below zero by two of its
        standard deviations.

    """
    if margin <= 0 or not rate < -2 * sqrt(rate_variance):
        return None
    time = -margin / rate
    variance = (margin_variance + time * time * rate_variance + 2 * time * covariance) / rate**2
    return time, sqrt(max(variance, 0.0))


class TransitionFlag:
    """True once three-point contact has become two-point contact, with hysteresis."""

    def __init__(self, options: MonitorOptions):
        self.options = options
        self.raised = False

    def restart(self):
        """Lower the flag."""
        self.raised = False

    def update(self, probability: float, touching: bool) -> bool:
        """Take the probability that gamma is below gamma0 and return the flag."""
        if self.raised:
            self.raised = probability > self.options.transition_probability_off
        else:
            self.raised = touching and probability > self.options.transition_probability_on
        return self.raised
