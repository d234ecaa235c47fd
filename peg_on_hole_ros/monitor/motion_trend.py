"""The motion as smooth trends: tilt and turning with rate and acceleration, extrapolated."""

from math import erf, exp, fabs, floor, pi, sqrt

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.monitor.trend import (
    Trend,
    begin,
    carry,
    correct,
    forget_trend,
    rate_stddev,
    value_after,
)
from peg_on_hole_ros.monitor.tuned import FOLLOWED_MOTION
from peg_on_hole_ros.typed_record import Floats, Record

# A held peg moves as smoothly as its holder. The estimator must not assume that: its components
# leave the peg's accelerations open from one wrench to the next, and so know the tilt's rate to
# some 0.02 rad/s. Of drawn insertions that slide, orientations over tens of milliseconds show it
# twice as well just below gamma0, and ten times as well where depth hangs on it most.

SQRT2 = sqrt(2.0)


class Measured(Record):
    """
    The tilt as it was measured last.

    Attributes
    ----------
    tilt, variance : float
        [rad], [rad^2].
    since : float
        Time since the one before, or since the one that was taken [s]; below zero: there was
        none; 0: this one was taken.

    """

    tilt: float
    variance: float
    since: float


class MotionTrend(Record):
    """
    What orientations have shown of the motion.

    Attributes
    ----------
    tilt : Trend
        As steady as the forecast assumes it to be [rad].
    quick_tilt : Trend
        Quick to follow a peg that brakes [rad].
    turn : Trend
        What psi and phi slip together at the rim over D/2 [rad].
    psi, phi : float
        Of the last orientation [rad].
    turned : float
        The turn that all orientations add up to [rad].
    acceleration2 : float
        What the tilt's acceleration has lately been, squared [rad^2/s^4].
    measured : Measured
    calm : float
        For how long the quick tilt has not jumped [s].

    """

    tilt: Trend
    quick_tilt: Trend
    turn: Trend
    psi: float
    phi: float
    turned: float
    acceleration2: float
    measured: Measured
    calm: float


@compiled
def forget_motion(motion: MotionTrend) -> None:
    """Forget the motion: what comes next has nothing to do with it."""
    for trend in (motion.tilt, motion.quick_tilt, motion.turn):
        forget_trend(trend)
    motion.psi = motion.phi = motion.turned = motion.acceleration2 = motion.calm = 0.0
    motion.measured.tilt = motion.measured.variance = motion.measured.since = 0.0


@compiled
def follow_motion(
    motion: MotionTrend, since: float, q: Floats, R: Floats, settings: MonitorSettings
) -> None:
    """
    Process an orientation.

    Parameters
    ----------
    motion : MotionTrend
        Changed.
    since : float
        Time since the last orientation [s]; below zero: there was none that counts.
    q : ndarray, shape (3,)
        gamma, psi, phi [rad]; psi and phi may be off by turns.
    R : ndarray, shape (3, 3)
        Covariance [rad^2].
    settings : MonitorSettings

    """
    # Turning is psi + phi d / D.
    ratio = settings.peg_diameter / settings.hole_diameter
    acceleration = settings.forecast_acceleration_stddev
    memory, quick = settings.forecast_acceleration_time, FOLLOWED_MOTION.turn_share * acceleration
    variance = R[1, 1] + ratio * (2.0 * R[1, 2] + ratio * R[2, 2])
    measured = motion.measured
    measured.tilt, measured.variance = q[0], R[0, 0]
    measured.since = measured.since + since if since > 0.0 else -1.0
    if since < 0.0:
        begin(motion.tilt, q[0], R[0, 0], 1.0, acceleration * acceleration)
        begin(motion.quick_tilt, q[0], R[0, 0], 1.0, quick * quick)
        begin(motion.turn, 0.0, variance, 1.0, quick * quick)
        motion.psi, motion.phi, motion.turned, motion.acceleration2 = q[1], q[2], 0.0, 0.0
        motion.calm = 0.0
        return
    carry(motion.quick_tilt, since, quick, memory)
    residual = q[0] - motion.quick_tilt.value
    jumped = correct(motion.quick_tilt, residual, R[0, 0], since, quick)
    motion.calm = 0.0 if jumped else motion.calm + since
    acceleration = sqrt(acceleration * acceleration + motion.acceleration2)
    carry(motion.tilt, since, acceleration, memory)
    carry(motion.turn, since, quick, memory)
    correct(motion.tilt, q[0] - motion.tilt.value, R[0, 0], since, acceleration)
    sure = max(motion.tilt.drive * motion.tilt.drive - motion.tilt.p22, 0.0)
    motion.acceleration2 += min(since / memory, 1.0) * (sure - motion.acceleration2)
    psi, phi = q[1] - motion.psi, q[2] - motion.phi
    motion.psi, motion.phi = q[1], q[2]
    # psi and phi alone are hardly known at a small tilt and may both jump; their sum is known.
    both = psi + phi
    both -= 2.0 * pi * floor(both / (2.0 * pi) + 0.5)
    phi -= 2.0 * pi * floor(phi / (2.0 * pi) + 0.5)
    motion.turned += both + (ratio - 1.0) * phi
    correct(motion.turn, motion.turned - motion.turn.value, variance, since, quick)


@compiled
def rest_probability(motion: MotionTrend, rate: float) -> float:
    """Return the probability that no contact moves faster than by a tilt at a rate [rad/s]."""
    # About its axis a peg turns by its radius, and about a rim contact by its diameter.
    return _within(motion.quick_tilt, rate) * _within(motion.turn, 2.0 * rate)


@compiled
def _within(trend: Trend, limit: float) -> float:
    spread = SQRT2 * rate_stddev(trend)
    return 0.5 * (erf((limit - trend.rate) / spread) + erf((limit + trend.rate) / spread))


@compiled
def time_to_reach(
    motion: MotionTrend, level: float, level_variance: float, settings: MonitorSettings
) -> tuple[float, float]:
    """
    Return the time until the tilt falls to a level, and its standard deviation.

    Parameters
    ----------
    motion : MotionTrend
    level, level_variance : float
        [rad], [rad^2].
    settings : MonitorSettings

    Returns
    -------
    time, stddev : float
        After the last orientation [s]; -1 if the tilt is below the level, does not fall by two
        standard deviations of its rate, or comes to rest before.

    """
    tilt, memory = motion.tilt, settings.forecast_acceleration_time
    margin, rate = tilt.value - level, tilt.rate
    if margin <= 0.0 or not rate < -2.0 * sqrt(max(tilt.p11, 0.0)):
        return -1.0, 0.0
    # Newton's steps from the side where the tilt is still above; it falls ever slower or faster.
    acceleration = settings.forecast_acceleration_stddev
    acceleration = sqrt(acceleration * acceleration + motion.acceleration2)
    t = 0.0
    for _ in range(50):
        kept = exp(-t / memory)
        now = margin + t * rate + memory * memory * (kept - 1.0 + t / memory) * tilt.drive
        speed = rate + memory * (1.0 - kept) * tilt.drive
        if speed >= 0.05 * rate or t > FOLLOWED_MOTION.longest:
            return -1.0, 0.0
        step = -now / speed
        t = max(t + step, 0.0)
        if fabs(step) < 1e-7:
            _, variance = value_after(tilt, t, acceleration, memory)
            return t, sqrt(max(variance + level_variance, 0.0)) / -speed
    return -1.0, 0.0
