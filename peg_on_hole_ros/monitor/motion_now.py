"""How the peg moves at a wrench, and what time has passed: what the causes of jamming share."""

from math import fabs, sqrt
from typing import NamedTuple

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.contact_probabilities import normal_cdf
from peg_on_hole_ros.monitor.motion_trend import MotionTrend
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.monitor.trend import rate_after
from peg_on_hole_ros.monitor.tuned import FOLLOWED_MOTION


class Passed(NamedTuple):
    """
    What time has passed at a wrench.

    Attributes
    ----------
    dt : float
        Since the last wrench [s].
    since : float
        Since the last orientation [s].

    """

    dt: float
    since: float


class Moving(NamedTuple):
    """
    How the peg moves.

    Attributes
    ----------
    rate : float
        Of the tilt [rad/s].
    turn, turn_variance : float
        About the axis [rad/s].
    rest_rate : float
        A rate that counts as none [rad/s].
    closing, rest : float
        Probabilities that the tilt falls, and that the peg rests.
    known : bool
        Whether the tilt's trend has a direction.

    """

    rate: float
    turn: float
    turn_variance: float
    rest_rate: float
    closing: float
    rest: float
    known: bool


@compiled
def moving_now(motion: MotionTrend, since: float, settings: MonitorSettings) -> Moving:
    """Return how the peg moves a time [s] after the last orientation."""
    rest_rate, memory = settings.rest_rate, settings.forecast_acceleration_time
    rate, rate_variance = rate_after(motion.quick_tilt, since, memory)
    turn, turn_variance = rate_after(motion.turn, since, memory)
    spread = sqrt(max(rate_variance, 1e-18))
    turn_spread = sqrt(max(turn_variance, 1e-18))
    closing = normal_cdf((-rest_rate - rate) / spread)
    rest = 1.0 - closing - normal_cdf((rate - rest_rate) / spread)
    turn_rest = normal_cdf((2.0 * rest_rate - turn) / turn_spread)
    rest *= max(turn_rest - normal_cdf((-2.0 * rest_rate - turn) / turn_spread), 0.0)
    # Just after a jolt the trend has no direction: that is no motion that could lead anywhere.
    # One of 2000 orientations looks like a jolt by chance, and gives a peg at rest a rate.
    known = fabs(rate) > 3.0 * spread and motion.calm >= FOLLOWED_MOTION.calm
    return Moving(rate, turn, turn_variance, rest_rate, closing, rest, known)
