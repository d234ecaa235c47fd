"""A trend: a number with its rate and what drives that, followed by a Kalman filter."""

from math import exp, fabs, sqrt

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.tuned import RATE_TREND
from peg_on_hole_ros.typed_record import Record

# The acceleration is an Ornstein-Uhlenbeck process (Singer, IEEE Trans. AES-6, 1970).
# Beyond this a number is refused like one that is none: its square's square is not finite.
LARGEST = 1e60


class Trend(Record):
    """
    A number that is followed.

    Attributes
    ----------
    value, rate : float
    drive : float
        What drives the rate: the acceleration; or, after `carry_driven`, by how much the value
        changes with another number.
    p00, p01, p02, p11, p12, p22 : float
        Covariance of value, rate and drive, the upper triangle. Where p00 is 0 the trend has not
        begun.

    """

    value: float
    rate: float
    drive: float
    p00: float
    p01: float
    p02: float
    p11: float
    p12: float
    p22: float


@compiled
def is_number(value: float) -> bool:
    """Return whether a value is finite, and stays so where it is squared twice."""
    return fabs(value) < LARGEST


@compiled
def begin(
    trend: Trend, value: float, variance: float, rate_variance: float, drive_variance: float
) -> None:
    """Begin with a value, at rate and drive of zero that are known to a variance."""
    trend.value, trend.rate, trend.drive = value, 0.0, 0.0
    trend.p00, trend.p01, trend.p02 = variance, 0.0, 0.0
    trend.p11, trend.p12, trend.p22 = rate_variance, 0.0, drive_variance


@compiled
def forget_trend(trend: Trend) -> None:
    """Begin a trend anew with the next value."""
    begin(trend, 0.0, 0.0, 0.0, 0.0)


@compiled
def carry(
    trend: Trend,
    dt: float,
    acceleration: float,
    memory: float,
    tremble: float = RATE_TREND.tremble,
) -> None:
    """
    Carry a trend over a time.

    Parameters
    ----------
    trend : Trend
        Changed.
    dt : float
        [s].
    acceleration, memory : float
        Standard deviation and correlation time [s] of the acceleration.
    tremble : float
        White noise of the rate, per root of a second.

    """
    kept = exp(-dt / memory)
    b = 0.5 * dt * dt
    x, v, a = trend.value, trend.rate, trend.drive
    p00, p01, p02 = trend.p00, trend.p01, trend.p02
    p11, p12, p22 = trend.p11, trend.p12, trend.p22
    trend.value, trend.rate, trend.drive = x + dt * v + b * a, v + dt * a, kept * a
    c01 = p01 + dt * p11 + b * p12
    c02 = p02 + dt * p12 + b * p22
    trend.p00 = p00 + dt * (p01 + c01) + b * (p02 + c02)
    trend.p01 = c01 + dt * c02
    trend.p02 = kept * c02
    trend.p11 = p11 + dt * (2.0 * p12 + dt * p22) + tremble * tremble * dt
    trend.p12 = kept * (p12 + dt * p22)
    trend.p22 = kept * kept * p22 + (1.0 - kept * kept) * acceleration * acceleration


@compiled
def carry_driven(trend: Trend, dt: float, grown: float, tremble: float) -> None:
    """Carry a trend over a time [s] in which the number that drives it has grown by so much."""
    p01, p02, p12 = trend.p01, trend.p02, trend.p12
    trend.value += dt * trend.rate + grown * trend.drive
    c01 = p01 + dt * trend.p11 + grown * p12
    c02 = p02 + dt * p12 + grown * trend.p22
    trend.p00 += dt * (p01 + c01) + grown * (p02 + c02)
    trend.p01, trend.p02 = c01, c02
    trend.p11 += tremble * tremble * dt


@compiled
def correct(
    trend: Trend,
    residual: float,
    variance: float,
    since: float,
    acceleration: float,
    jump_at: float = RATE_TREND.jump,
) -> bool:
    """
    Correct a trend by what its value was off.

    Parameters
    ----------
    trend : Trend
        Changed.
    residual, variance : float
        Of what was measured; not taken where one is no number.
    since : float
        Time since the last one [s].
    acceleration : float
        Standard deviation of the acceleration after a jump.
    jump_at : float
        Square of how many standard deviations off are a jump of the rate.

    Returns
    -------
    bool
        Whether it has jumped.

    """
    if not (is_number(residual) and is_number(variance)):
        return True
    s = trend.p00 + variance
    jumped = residual * residual > jump_at * s
    if jumped:
        jump = residual / max(since, 1e-4)
        trend.p11 += jump * jump
        trend.p01 += since * jump * jump
        trend.p00 += residual * residual
        trend.p22 = max(trend.p22, acceleration * acceleration)
        s = trend.p00 + variance
    over = 1.0 / s
    g0, g1, g2 = trend.p00 * over, trend.p01 * over, trend.p02 * over
    trend.value += g0 * residual
    trend.rate += g1 * residual
    trend.drive += g2 * residual
    p01, p02 = trend.p01, trend.p02
    trend.p00 *= variance * over
    trend.p01 *= variance * over
    trend.p02 *= variance * over
    trend.p11 -= g1 * p01
    trend.p12 -= g1 * p02
    trend.p22 -= g2 * p02
    return jumped


@compiled
def rate_after(trend: Trend, t: float, memory: float) -> tuple[float, float]:
    """Return rate and its variance a time [s] after the last value."""
    kept = exp(-t / memory)
    b = memory * (1.0 - kept)
    rate = trend.rate + b * trend.drive
    variance = trend.p11 + 2.0 * b * trend.p12 + b * b * trend.p22
    return rate, variance


@compiled
def mean_after(trend: Trend, t: float, memory: float, variance: float) -> tuple[float, float]:
    """
    Return the value a time [s] after the last one, and its variance if nothing new drives it.

    The value counts as known now to a variance.
    """
    u = t / memory
    b = memory * memory * (exp(-u) - 1.0 + u)
    x = trend.value + t * trend.rate + b * trend.drive
    spread = variance + t * (2.0 * trend.p01 + t * trend.p11)
    spread += b * (2.0 * trend.p02 + 2.0 * t * trend.p12 + b * trend.p22)
    return x, spread


@compiled
def value_after(trend: Trend, t: float, acceleration: float, memory: float) -> tuple[float, float]:
    """
    Return the value and its variance a time [s] after the last one; parameters as for `carry`.

    Source: Singer 1970, the covariance of a target with exponentially correlated acceleration.
    """
    x, variance = mean_after(trend, t, memory, trend.p00)
    u = t / memory
    kept = exp(-u)
    # Near zero the closed form is a difference of large numbers.
    if u < 0.1:
        q = 0.1 * u**5
    else:
        q = 1.0 - kept * kept + 2.0 * u + 2.0 / 3.0 * u**3 - 2.0 * u * u - 4.0 * u * kept
    variance += acceleration * acceleration * memory**4 * q
    return x, variance + RATE_TREND.tremble * RATE_TREND.tremble * t**3 / 3.0


@compiled
def rate_stddev(trend: Trend) -> float:
    """Return the standard deviation of the rate."""
    return sqrt(max(trend.p11, 1e-18))
