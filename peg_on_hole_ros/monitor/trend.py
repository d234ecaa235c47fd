"""The motion as a smooth trend: tilt and turning with rate and acceleration, extrapolated."""

from math import erf, exp, fabs, floor, pi, sqrt

import numpy as np

from peg_on_hole_ros.mechanics.kernel import compiled

# A held peg moves as smoothly as its holder. The estimator must not assume that: its components
# leave the peg's accelerations open from one wrench to the next, and so know the tilt's rate to
# some 0.02 rad/s. Of drawn insertions that slide, orientations over tens of milliseconds tell it
# twice as well just below gamma0, and ten times as well where depth hangs on it most.
#
# One channel is position, rate, acceleration and the upper triangle of their covariance, 9 places.
# The acceleration is an Ornstein-Uhlenbeck process (Singer, IEEE Trans. AES-6, 1970).
CHANNEL = 9
# The tilt twice: as steady as the forecast takes it to be, and quick to follow a peg that brakes.
TILT, TURN, QUICK_TILT = 0, CHANNEL, 2 * CHANNEL
# psi and phi of the last orientation, and the turn that all of them add up to.
LAST = 3 * CHANNEL
# What the tilt's acceleration has lately been, squared [rad^2/s^4].
LATELY = LAST + 3
# The tilt as last measured, its variance, and the time since the one before; 0: it was taken.
MEASURED = LATELY + 1
# For how long the quick tilt has not jumped [s].
CALM = MEASURED + 3
SIZE = CALM + 1
# Beyond this a number is refused like one that is none: its square's square is not finite.
LARGEST = 1e60
# A forecast further ahead says nothing [s].
LONGEST = 30.0
SQRT2 = sqrt(2.0)
# White noise of the rates beside it: what a holder trembles [rad/s per root of a second].
_TREMBLE = 0.002
# A jump of the rate, as at touch-down and where the peg sticks: 1 of 2000 by chance.
_JUMP = 12.0
# How much quicker turning is than tilting, and the quick tilt than the steady one.
TURN_SHARE = 10.0


def new_trend() -> np.ndarray:
    """Return the memory of a trend that has seen nothing."""
    return np.zeros(SIZE)


@compiled
def is_number(value: float) -> bool:
    """Return whether a value is finite, and stays so where it is squared twice."""
    return fabs(value) < LARGEST


@compiled
def start(m: np.ndarray, at: int, value: float, variance: float, acceleration: float) -> None:
    """Begin a channel with a value, at an unknown rate."""
    for i in range(CHANNEL):
        m[at + i] = 0.0
    m[at], m[at + 3], m[at + 6], m[at + 8] = value, variance, 1.0, acceleration * acceleration


@compiled
def carry(
    m: np.ndarray,
    at: int,
    dt: float,
    acceleration: float,
    memory: float,
    tremble: float = _TREMBLE,
) -> None:
    """Carry a channel over dt [s]."""
    kept = exp(-dt / memory)
    b = 0.5 * dt * dt
    x, v, a = m[at], m[at + 1], m[at + 2]
    p00, p01, p02 = m[at + 3], m[at + 4], m[at + 5]
    p11, p12, p22 = m[at + 6], m[at + 7], m[at + 8]
    m[at], m[at + 1], m[at + 2] = x + dt * v + b * a, v + dt * a, kept * a
    c01 = p01 + dt * p11 + b * p12
    c02 = p02 + dt * p12 + b * p22
    m[at + 3] = p00 + dt * (p01 + c01) + b * (p02 + c02)
    m[at + 4] = c01 + dt * c02
    m[at + 5] = kept * c02
    m[at + 6] = p11 + dt * (2.0 * p12 + dt * p22) + tremble * tremble * dt
    m[at + 7] = kept * (p12 + dt * p22)
    m[at + 8] = kept * kept * p22 + (1.0 - kept * kept) * acceleration * acceleration


@compiled
def correct(
    m: np.ndarray,
    at: int,
    residual: float,
    variance: float,
    since: float,
    acceleration: float,
    jump_at: float = _JUMP,
) -> bool:
    """Correct a channel by what its position was off, a number; return whether it has jumped."""
    if not (is_number(residual) and is_number(variance)):
        return True
    s = m[at + 3] + variance
    jumped = residual * residual > jump_at * s
    if jumped:
        jump = residual / max(since, 1e-4)
        m[at + 6] += jump * jump
        m[at + 4] += since * jump * jump
        m[at + 3] += residual * residual
        m[at + 8] = max(m[at + 8], acceleration * acceleration)
        s = m[at + 3] + variance
    over = 1.0 / s
    g0, g1, g2 = m[at + 3] * over, m[at + 4] * over, m[at + 5] * over
    m[at] += g0 * residual
    m[at + 1] += g1 * residual
    m[at + 2] += g2 * residual
    p01, p02 = m[at + 4], m[at + 5]
    m[at + 3] *= variance * over
    m[at + 4] *= variance * over
    m[at + 5] *= variance * over
    m[at + 6] -= g1 * p01
    m[at + 7] -= g1 * p02
    m[at + 8] -= g2 * p02
    return jumped


@compiled
def follow(
    m: np.ndarray,
    since: float,
    q: np.ndarray,
    R: np.ndarray,
    ratio: float,
    acceleration: float,
    memory: float,
) -> None:
    """
    Take an orientation.

    Parameters
    ----------
    m : ndarray
        Memory, from `new_trend`.
    since : float
        Time since the last orientation [s]; below zero: there was none that counts.
    q : ndarray, shape (3,)
        gamma, psi, phi [rad]; psi and phi may be off by turns.
    R : ndarray, shape (3, 3)
        Covariance [rad^2].
    ratio : float
        d / D: turning is psi + phi d / D, what psi and phi slip together at the rim over D/2.
    acceleration, memory : float
        Standard deviation [rad/s^2] and correlation time [s] of the tilt's acceleration.

    """
    variance = R[1, 1] + ratio * (2.0 * R[1, 2] + ratio * R[2, 2])
    m[MEASURED], m[MEASURED + 1] = q[0], R[0, 0]
    m[MEASURED + 2] = m[MEASURED + 2] + since if since > 0.0 else -1.0
    if since < 0.0:
        start(m, TILT, q[0], R[0, 0], acceleration)
        start(m, QUICK_TILT, q[0], R[0, 0], TURN_SHARE * acceleration)
        start(m, TURN, 0.0, variance, TURN_SHARE * acceleration)
        m[LAST], m[LAST + 1], m[LAST + 2], m[LATELY] = q[1], q[2], 0.0, 0.0
        m[CALM] = 0.0
        return
    quick = TURN_SHARE * acceleration
    carry(m, QUICK_TILT, since, quick, memory)
    jumped = correct(m, QUICK_TILT, q[0] - m[QUICK_TILT], R[0, 0], since, quick)
    m[CALM] = 0.0 if jumped else m[CALM] + since
    acceleration = sqrt(acceleration * acceleration + m[LATELY])
    carry(m, TILT, since, acceleration, memory)
    carry(m, TURN, since, quick, memory)
    correct(m, TILT, q[0] - m[TILT], R[0, 0], since, acceleration)
    sure = max(m[TILT + 2] * m[TILT + 2] - m[TILT + 8], 0.0)
    m[LATELY] += min(since / memory, 1.0) * (sure - m[LATELY])
    psi, phi = q[1] - m[LAST], q[2] - m[LAST + 1]
    m[LAST], m[LAST + 1] = q[1], q[2]
    # psi and phi alone are hardly known at a small tilt and may both jump; their sum is known.
    both = psi + phi
    both -= 2.0 * pi * floor(both / (2.0 * pi) + 0.5)
    phi -= 2.0 * pi * floor(phi / (2.0 * pi) + 0.5)
    m[LAST + 2] += both + (ratio - 1.0) * phi
    residual = m[LAST + 2] - m[TURN]
    correct(m, TURN, residual, variance, since, quick)


@compiled
def rest_probability(m: np.ndarray, speed: float, D: float) -> float:
    """Return the probability that no contact moves faster than a speed [m/s]."""
    limit = speed / D
    return _within(m, QUICK_TILT, limit) * _within(m, TURN, 2.0 * limit)


@compiled
def _within(m, at, limit):
    spread = SQRT2 * sqrt(max(m[at + 6], 1e-18))
    return 0.5 * (erf((limit - m[at + 1]) / spread) + erf((limit + m[at + 1]) / spread))


@compiled
def rate_after(m: np.ndarray, at: int, t: float, memory: float) -> tuple[float, float]:
    """Return rate and its variance a time [s] after the last orientation."""
    kept = exp(-t / memory)
    b = memory * (1.0 - kept)
    rate = m[at + 1] + b * m[at + 2]
    variance = m[at + 6] + 2.0 * b * m[at + 7] + b * b * m[at + 8]
    return rate, variance


@compiled
def position_after(
    m: np.ndarray, at: int, t: float, acceleration: float, memory: float
) -> tuple[float, float]:
    """
    Return position and its variance a time [s] after the last orientation.

    Source: Singer 1970, the covariance of a target with exponentially correlated acceleration.
    """
    u = t / memory
    kept = exp(-u)
    b = memory * memory * (kept - 1.0 + u)
    x = m[at] + t * m[at + 1] + b * m[at + 2]
    variance = m[at + 3] + t * (2.0 * m[at + 4] + t * m[at + 6])
    variance += b * (2.0 * m[at + 5] + 2.0 * t * m[at + 7] + b * m[at + 8])
    # Near zero the closed form is a difference of large numbers.
    if u < 0.1:
        q = 0.1 * u**5
    else:
        q = 1.0 - kept * kept + 2.0 * u + 2.0 / 3.0 * u**3 - 2.0 * u * u - 4.0 * u * kept
    variance += acceleration * acceleration * memory**4 * q
    return x, variance + _TREMBLE * _TREMBLE * t**3 / 3.0


@compiled
def time_to_reach(
    m: np.ndarray, level: float, level_variance: float, acceleration: float, memory: float
) -> tuple[float, float]:
    """
    Return the time until the tilt falls to a level, and its standard deviation.

    Parameters
    ----------
    m : ndarray
        Memory.
    level, level_variance : float
        [rad], [rad^2].
    acceleration, memory : float
        As for `follow`.

    Returns
    -------
    time, stddev : float
        After the last orientation [s]; -1 where the tilt is below the level, does not surely fall
        (by two standard deviations of its rate), or comes to rest before.

    """
    margin, rate = m[TILT] - level, m[TILT + 1]
    if margin <= 0.0 or not rate < -2.0 * sqrt(max(m[TILT + 6], 0.0)):
        return -1.0, 0.0
    # Newton's steps from the side where the tilt is still above; it falls ever slower or faster.
    acceleration = sqrt(acceleration * acceleration + m[LATELY])
    t = 0.0
    for _ in range(50):
        kept = exp(-t / memory)
        now = margin + t * rate + memory * memory * (kept - 1.0 + t / memory) * m[TILT + 2]
        speed = rate + memory * (1.0 - kept) * m[TILT + 2]
        if speed >= 0.05 * rate or t > LONGEST:
            return -1.0, 0.0
        step = -now / speed
        t = max(t + step, 0.0)
        if fabs(step) < 1e-7:
            _, variance = position_after(m, TILT, t, acceleration, memory)
            return t, sqrt(max(variance + level_variance, 0.0)) / -speed
    return -1.0, 0.0
