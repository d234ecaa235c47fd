"""What all dangers are judged by at a wrench: contact, motion, and the push on the peg."""

from typing import NamedTuple

from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.closing_push import Pushed
from peg_on_hole_ros.monitor.evidence import Shown
from peg_on_hole_ros.monitor.motion_now import Moving, Passed
from peg_on_hole_ros.monitor.motion_trend import Measured
from peg_on_hole_ros.monitor.rest_in_hole import DepthTrend
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.monitor.trend import is_number


class Situation(NamedTuple):
    """
    A wrench, and what is known of the peg at its stamp.

    Attributes
    ----------
    estimate : Estimate
    shown : Shown
        Probabilities of the contacts.
    depth : DepthTrend
    measured : Measured
        The last orientation; `since` is zero once it has been taken.
    moving : Moving
    pushed : Pushed
    settings : MonitorSettings
    passed : Passed

    """

    estimate: Estimate
    shown: Shown
    depth: DepthTrend
    measured: Measured
    moving: Moving
    pushed: Pushed
    settings: MonitorSettings
    passed: Passed


@compiled
def in_contact(shown: Shown) -> float:
    """Return the probability that rim or hole touch the peg: nothing else can jam it."""
    return shown.on_hole


@compiled
def touches(shown: Shown) -> bool:
    """Return whether the peg touches the hole: without contact nothing is remembered."""
    return not in_contact(shown) < 0.5


@compiled
def is_inside(shown: Shown) -> bool:
    """Return whether the peg is in the hole, where there are no three contacts."""
    return shown.below > 0.5


@compiled
def on_rim(shown: Shown) -> float:
    """Return the probability that the peg touches above gamma0, on three contacts or fewer."""
    # Rounding may leave a difference below zero.
    return max(in_contact(shown) - in_hole(shown), 0.0)


@compiled
def in_hole(shown: Shown) -> float:
    """Return the probability that the peg touches below gamma0."""
    return shown.two_point


@compiled
def horizon_on_rim(shown: Shown, horizon: float) -> float:
    """Return for how long a horizon [s] looks ahead: a forecast ends with three contacts."""
    return min(horizon, shown.time) if shown.time >= 0.0 else horizon


@compiled
def reactions_usable(estimate: Estimate, shown: Shown) -> bool:
    """Return whether reactions and their variances are numbers to use."""
    normal, covariance, usable = estimate.reactions.normal, estimate.reactions.covariance, True
    for i in range(3):
        usable = usable and is_number(normal[i]) and is_number(covariance[i, i])
    return usable and shown.usable
