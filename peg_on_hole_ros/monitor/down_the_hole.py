"""Whether a peg in the hole moves along it, by its tilt: at rest or sliding, and how fast."""

from math import exp, fabs, sqrt

import numpy as np

from peg_on_hole_ros.estimator.insertion_depth import depth_at
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled
from peg_on_hole_ros.monitor.contacts import below
from peg_on_hole_ros.monitor.trend import is_number

# On two points the tilt tells the depth (`insertion_depth.depth_at`). Two models of the tilt
# are run side by side, and mixed as an IMM (Blom and Bar-Shalom, IEEE Trans. AC-33, 1988): a peg
# at rest, and one whose speed is smooth. docs/jamming.md, "In the hole", derives what is read.

# A peg that slides does so at this speed, and changes it by as much within this time [m/s], [s].
SPEED, CHANGES = 0.02, 0.5
# Rest ends, and a motion too, within this time [s].
LASTS = 0.5
# Contacts that give let a resting peg's tilt creep [rad per root of a second].
_CREEP = 1e-4
# A peg of which nothing is known rests with this probability: most are on their way.
_BEGINS = 0.3
# Smaller tilts are none [rad].
_UPRIGHT = 1e-6
# Odds against rest, or for it, are never beyond this: either may begin at any time.
_LEAST = 1e-6

# Memory: tilt of the peg at rest and its variance; tilt and rate of the sliding one and the upper
# triangle of their covariance; probability of rest.
STILL, SLIDES, RESTS = 0, 2, 7
SIZE = 8
# Where the first variance stands; 0: nothing was followed yet.
_VARIANCE = 1


@compiled
def forget(m: np.ndarray, at: int) -> None:
    """Begin anew with the next orientation."""
    m[at + _VARIANCE] = 0.0


@compiled
def _slope(p, gamma):
    """Return by how much the depth falls with the tilt [m/rad]; upright it has no bound."""
    return -depth_at(p.d, p.D, max(gamma, _UPRIGHT))[1]


@compiled
def follow_depth(
    m: np.ndarray, at: int, p: SceneScalars, tilt: float, variance: float, since: float
) -> None:
    """
    Take an orientation.

    Parameters
    ----------
    m : ndarray
        Memory, of which SIZE places from `at` on.
    at : int
    p : SceneScalars
    tilt, variance : float
        As measured [rad], [rad^2].
    since : float
        After the last orientation [s]; below zero: there was none.

    """
    if not (is_number(tilt) and is_number(variance)):
        return
    a, b = at + STILL, at + SLIDES
    # A tilt that is hardly known tells no depth, and is not to look like one.
    at_least = 2.0 * sqrt(variance)
    fastest = SPEED / _slope(p, max(fabs(m[a]) if m[a + 1] > 0.0 else tilt, at_least))
    fresh = fastest * fastest
    if m[a + 1] == 0.0 or since < 0.0:
        m[a], m[a + 1] = tilt, variance
        m[b], m[b + 1], m[b + 2], m[b + 3], m[b + 4] = tilt, 0.0, variance, 0.0, fresh
        m[at + RESTS] = _BEGINS
        return
    change = 0.5 * (1.0 - exp(-2.0 * since / LASTS))
    rests = m[at + RESTS]
    now = rests * (1.0 - change) + (1.0 - rests) * change
    stays, goes_on = rests * (1.0 - change) / now, (1.0 - rests) * (1.0 - change) / (1.0 - now)
    # What either model knows where it takes over from the other: of a peg at rest no speed.
    g, P = m[a], m[a + 1]
    x, v, p00, p01, p11 = m[b], m[b + 1], m[b + 2], m[b + 3], m[b + 4]
    off = x - g
    m[a] = g + (1.0 - stays) * off
    m[a + 1] = stays * P + (1.0 - stays) * (p00 + stays * off * off)
    x = g + goes_on * off
    stopped = 1.0 - goes_on
    p00 = goes_on * p00 + stopped * (P + goes_on * off * off)
    p01 = goes_on * (p01 + stopped * off * v)
    p11 = goes_on * (p11 + stopped * v * v) + stopped * fresh
    v *= goes_on
    # Carried on.
    m[a + 1] += _CREEP * _CREEP * since
    x += since * v
    p00 += since * (2.0 * p01 + since * p11)
    p01 += since * p11
    p11 += fresh * since / CHANGES
    # Corrected; the likelihoods weigh both.
    s_still, s_slides = m[a + 1] + variance, p00 + variance
    r_still, r_slides = tilt - m[a], tilt - x
    m[a] += m[a + 1] / s_still * r_still
    m[a + 1] *= variance / s_still
    g0, g1 = p00 / s_slides, p01 / s_slides
    m[b], m[b + 1] = x + g0 * r_slides, v + g1 * r_slides
    m[b + 2], m[b + 3], m[b + 4] = (1.0 - g0) * p00, (1.0 - g0) * p01, p11 - g1 * p01
    z = min(r_still * r_still / s_still, 50.0) - min(r_slides * r_slides / s_slides, 50.0)
    odds = (1.0 - now) / now * exp(0.5 * z) * sqrt(s_still / s_slides)
    m[at + RESTS] = min(max(1.0 / (1.0 + odds), _LEAST), 1.0 - _LEAST)


@compiled
def unsettle(m: np.ndarray, at: int, share: float) -> None:
    """Forget a share of what is known of rest, as while no two points carry."""
    m[at + RESTS] += share * (_BEGINS - m[at + RESTS])


@compiled
def stands(
    m: np.ndarray, at: int, p: SceneScalars, horizon: float, slow: float
) -> tuple[float, float]:
    """
    Return the probabilities that the peg rests, and that it slides but stops within a horizon.

    Parameters
    ----------
    m, at, p
        As for `follow_depth`.
    horizon : float
        [s].
    slow : float
        Speed along the hole that counts as none [m/s].

    """
    if m[at + _VARIANCE] == 0.0:
        return _BEGINS, 0.0
    b = at + SLIDES
    slope = _slope(p, max(fabs(m[b]), sqrt(m[b + 2])))
    # Into the hole; only what moves there can stop.
    speed, variance = -slope * m[b + 1], slope * slope * m[b + 4]
    moves = below((speed - slow) / sqrt(variance))
    stops = below((slow - speed) / sqrt(variance + SPEED * SPEED * horizon / CHANGES))
    return m[at + RESTS], (1.0 - m[at + RESTS]) * moves * stops


@compiled
def along_share(m: np.ndarray, at: int, p: SceneScalars, around: float) -> float:
    """
    Return which share of the friction is along the hole, if the peg slides.

    Parameters
    ----------
    m, at, p
        As for `follow_depth`.
    around : float
        Speed of the peg's surface about its axis [m/s].

    """
    if m[at + _VARIANCE] == 0.0:
        return 1.0
    b = at + SLIDES
    slope = _slope(p, max(fabs(m[b]), sqrt(m[b + 2])))
    speed2 = slope * slope * (m[b + 1] * m[b + 1] + m[b + 4])
    return sqrt(speed2 / (speed2 + around * around))
