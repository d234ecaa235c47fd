"""The peg at constant rates beside the steps, told by its orientations alone."""

from math import sqrt

from peg_on_hole_ros.estimation.kernel.acceleration import bridged_density, follow_rates_at
from peg_on_hole_ros.estimation.kernel.bridging import (
    SLOW_RATES,
    adapted_noise,
    growth,
    least_noise,
)
from peg_on_hole_ros.estimation.kernel.lean import follow_lean
from peg_on_hole_ros.estimation.kernel.memory import (
    ACCELERATION,
    BESIDE_ACCELERATION,
    BESIDE_LEAN,
    BESIDE_P,
    BESIDE_RATE_NOISE,
    BESIDE_SINCE,
    BESIDE_X,
    CHANGES_SEEN,
    CROSS,
    GAIN,
    LEAN,
    RATE_NOISE,
    RATES,
    RATES_KNOWN,
    RESIDUAL,
    SINCE_CORRECTION,
    R,
    X,
    Z,
)
from peg_on_hole_ros.estimation.kernel.symmetric import factors
from peg_on_hole_ros.mechanics.kernel import compiled, inlined

# Rates are constant while innovations leave their walk below so many times its least. Others are
# behind the peg, which steps are not.
STEADY = 2.0


@compiled
def correct_beside(m, dt):
    """
    Correct the constant rates beside the estimate with the orientation that it is corrected with.

    They walk, follow innovations and accelerate by the rules by which the estimate's own do where
    it is bridged, but always: no step has a part in them, nor the noise of any wrench.

    Parameters
    ----------
    m : ndarray
        Memory before the estimate's own correction, with its residual at RESIDUAL, R, and
        RATES_KNOWN as the last correction left it.
    dt : float
        Time since that [s].

    """
    _advance(m, dt)
    m[BESIDE_SINCE] = 0.0
    e0 = m[RESIDUAL] + m[X] - m[BESIDE_X]
    e1 = m[RESIDUAL + 1] + m[X + 1] - m[BESIDE_X + 1]
    e2 = m[RESIDUAL + 2] + m[X + 2] - m[BESIDE_X + 2]
    p, r = BESIDE_P, R
    l10, l20, l21, d0, d1, d2 = factors(
        m[p] + m[r], m[p + 6] + m[r + 3], m[p + 7] + m[r + 4],
        m[p + 12] + m[r + 6], m[p + 13] + m[r + 7], m[p + 14] + m[r + 8],
    )  # fmt: skip
    o0, o1, o2 = 1.0 / sqrt(d0), 1.0 / sqrt(d1), 1.0 / sqrt(d2)
    e1 -= l10 * e0
    e2 -= l20 * e0 + l21 * e1
    white = e0 * o0, e1 * o1, e2 * o2
    nis = white[0] * white[0] + white[1] * white[1] + white[2] * white[2]
    follow_lean(m, BESIDE_LEAN, white)
    m[BESIDE_RATE_NOISE] = adapted_noise(
        m, m[BESIDE_RATE_NOISE], BESIDE_LEAN, nis, BESIDE_X + 3, p + 21, 7
    )
    for i in range(6):
        g0 = m[p + 6 * i]
        g1 = m[p + 6 * i + 1] - l10 * g0
        g2 = m[p + 6 * i + 2] - l20 * g0 - l21 * g1
        m[GAIN + i], m[GAIN + 6 + i], m[GAIN + 12 + i] = g0 * o0, g1 * o1, g2 * o2
    for i in range(6):
        g0, g1, g2 = m[GAIN + i], m[GAIN + 6 + i], m[GAIN + 12 + i]
        m[BESIDE_X + i] += g0 * white[0] + g1 * white[1] + g2 * white[2]
        for j in range(i + 1):
            left = m[p + 6 * i + j]
            left -= g0 * m[GAIN + j] + g1 * m[GAIN + 6 + j] + g2 * m[GAIN + 12 + j]
            m[p + 6 * i + j] = left
            m[p + 6 * j + i] = left
    follow_rates_at(m, BESIDE_ACCELERATION, BESIDE_X + 3, dt)


@compiled
def take_beside(m, dt):
    """
    Take the constant rates for the estimate, if they are constant and better known.

    Parameters
    ----------
    m : ndarray
        Memory before an interval that is to be bridged after one that was not; angles, rates, how
        they accelerate and walk are changed, and are then apart from all else.
    dt : float
        The interval, which SINCE_CORRECTION already contains [s].

    Returns
    -------
    bool
        Whether they were taken.

    """
    if m[RATES_KNOWN] == 0.0:
        return False
    least = least_noise(m, BESIDE_X + 3, BESIDE_P + 21, 7)
    if m[BESIDE_RATE_NOISE] > STEADY * least:
        return False
    _advance(m, m[SINCE_CORRECTION] - dt)
    theirs, own = _volume(m, BESIDE_P + 21, 6), _volume(m, RATES, 12)
    # Neither where one is no number, nor where rates are known for sure.
    if not (theirs > 0.0 and theirs < own):
        return False
    for i in range(6):
        m[X + i] = m[BESIDE_X + i]
        m[CROSS + i] = m[CROSS + 12 + i] = 0.0
        for j in range(6):
            m[Z + 12 * i + j] = m[BESIDE_P + 6 * i + j]
            m[Z + 12 * i + 6 + j] = m[Z + 12 * (6 + j) + i] = 0.0
    for i in range(CHANGES_SEEN + 1 - ACCELERATION):
        m[ACCELERATION + i] = m[BESIDE_ACCELERATION + i]
    for i in range(3):
        m[LEAN + i] = m[BESIDE_LEAN + i]
    m[RATE_NOISE] = m[BESIDE_RATE_NOISE]
    return True


@inlined
def _advance(m, until):
    """Predict to so long after the last correction [s]."""
    p, h = BESIDE_P, until - m[BESIDE_SINCE]
    m[BESIDE_SINCE] = until
    for i in range(3):
        m[BESIDE_X + i] += h * m[BESIDE_X + 3 + i]
        for j in range(i + 1):
            total = m[p + 6 * i + j] + h * (m[p + 6 * i + 3 + j] + m[p + 6 * j + 3 + i])
            total += h * h * m[p + 21 + 6 * i + j]
            m[p + 6 * i + j] = total
            m[p + 6 * j + i] = total
    for i in range(3):
        for j in range(3):
            total = m[p + 6 * i + 3 + j] + h * m[p + 21 + 6 * i + j]
            m[p + 6 * i + 3 + j] = total
            m[p + 6 * (3 + j) + i] = total
    # A peg that is bridged for long hardly closes (`bridging.TILT_WALK`). One that steps describe
    # is braked as it comes near gamma0, by more the faster it closes, with the square of its rate.
    tilt = m[BESIDE_X + 3] / SLOW_RATES
    grows = growth(tilt * tilt)
    for i in range(3):
        noise = m[BESIDE_RATE_NOISE] * (grows if i == 0 else 1.0)
        walk = h * (noise * noise + bridged_density(m[BESIDE_ACCELERATION + i]))
        m[p + 7 * i] += h * h * walk / 3.0
        m[p + 7 * i + 3] += 0.5 * h * walk
        m[p + 6 * (3 + i) + i] += 0.5 * h * walk
        m[p + 21 + 7 * i] += walk


@inlined
def _volume(m, at, stride):
    """Return the determinant of the rates' covariance at a place."""
    _, _, _, d0, d1, d2 = factors(
        m[at], m[at + stride], m[at + stride + 1],
        m[at + 2 * stride], m[at + 2 * stride + 1], m[at + 2 * stride + 2],
    )  # fmt: skip
    return d0 * d1 * d2
