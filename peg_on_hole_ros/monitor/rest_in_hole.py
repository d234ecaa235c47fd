"""Whether a peg in the hole moves along it, by its tilt: at rest or sliding, and how fast."""

from math import exp, fabs, sqrt

from peg_on_hole_ros.estimator.hole_geometry import depth_at
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.contact_probabilities import normal_cdf
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.monitor.trend import Trend, begin, carry, correct, forget_trend, is_number
from peg_on_hole_ros.monitor.tuned import FOLLOWED_MOTION, REST_IN_HOLE
from peg_on_hole_ros.typed_record import Record

# On two points the tilt determines the depth (`hole_geometry.depth_at`). docs/jamming.md, "In
# the hole", derives what is read.


class DepthTrend(Record):
    """
    What orientations have shown of the motion along the hole.

    Attributes
    ----------
    tilt : Trend
        [rad].
    rests : float
        Probability that a peg that is pushed rests.

    """

    tilt: Trend
    rests: float


@compiled
def _depth_slope(d: float, D: float, gamma: float, variance: float) -> float:
    """
    Return by how much the depth falls with the tilt [m/rad].

    Upright it has no bound: a tilt that is hardly known determines no depth, and must not seem to.
    """
    return -depth_at(d, D, max(fabs(gamma), sqrt(max(variance, 0.0)), REST_IN_HOLE.upright))[1]


@compiled
def forget_depth(depth: DepthTrend) -> None:
    """Forget the motion: what comes next has nothing to do with it."""
    forget_trend(depth.tilt)
    depth.rests = 0.0


@compiled
def follow_depth(
    depth: DepthTrend, tilt: float, variance: float, since: float, settings: MonitorSettings
) -> None:
    """
    Process an orientation.

    Parameters
    ----------
    depth : DepthTrend
        Changed.
    tilt, variance : float
        As measured [rad], [rad^2].
    since : float
        After the last orientation [s]; below zero: there was none.
    settings : MonitorSettings

    """
    if not (is_number(tilt) and is_number(variance)):
        return
    d, D, followed = settings.peg_diameter, settings.hole_diameter, depth.tilt
    begun = followed.p00 > 0.0 and since >= 0.0
    slope = _depth_slope(d, D, followed.value if begun else tilt, 4.0 * variance)
    if not begun:
        depth.rests = REST_IN_HOLE.begins
    # In the mean over a peg that rests, and keeps to that, and one that moves.
    changes = REST_IN_HOLE.changes * sqrt(1.0 - depth.rests)
    acceleration = min(
        FOLLOWED_MOTION.turn_share * settings.forecast_acceleration_stddev, changes / slope
    )
    if begun:
        carry(followed, since, acceleration, REST_IN_HOLE.lasts)
        correct(followed, tilt - followed.value, variance, since, acceleration)
    else:
        begin(followed, tilt, variance, 1.0, acceleration * acceleration)
    speed, speed_variance = _speed(depth, d, D)
    depth.rests = _probability_of_rest(speed, speed_variance)


@compiled
def _speed(depth: DepthTrend, d: float, D: float) -> tuple[float, float]:
    """Return speed into the hole and its variance [m/s], [m^2/s^2]."""
    tilt = depth.tilt
    slope = _depth_slope(d, D, tilt.value, tilt.p00)
    return -slope * tilt.rate, max(slope * slope * tilt.p11, 1e-18)


@compiled
def _probability_of_rest(speed: float, variance: float) -> float:
    """Return the probability of rest against half of a normal distribution of speeds."""
    # What is pushed slides in, and not out.
    wide = variance + REST_IN_HOLE.speed * REST_IN_HOLE.speed
    odds = REST_IN_HOLE.begins / (1.0 - REST_IN_HOLE.begins) * sqrt(wide / variance)
    odds *= exp(max(-0.5 * speed * speed * (1.0 / variance - 1.0 / wide), -50.0))
    odds /= 2.0 * max(normal_cdf(speed * REST_IN_HOLE.speed / sqrt(variance * wide)), 1e-12)
    return min(max(odds / (1.0 + odds), REST_IN_HOLE.least), 1.0 - REST_IN_HOLE.least)


@compiled
def rests(depth: DepthTrend) -> float:
    """Return the probability that a peg that is pushed rests; see `follow_depth`."""
    return depth.rests if depth.tilt.p00 > 0.0 else REST_IN_HOLE.begins


@compiled
def along_share(depth: DepthTrend, d: float, D: float, around: float) -> float:
    """
    Return which share of the friction is along the hole, if the peg slides.

    Parameters
    ----------
    depth : DepthTrend
    d, D : float
        Diameters [m].
    around : float
        Speed of the peg's surface about its axis [m/s].

    """
    if depth.tilt.p00 == 0.0:
        return 1.0
    speed, variance = _speed(depth, d, D)
    speed2 = speed * speed + variance
    return sqrt(speed2 / (speed2 + around * around))
