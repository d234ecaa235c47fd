"""Whether a peg in the hole moves along it, by its tilt: at rest or sliding, and how fast."""

from math import exp, fabs, sqrt

import numpy as np

from peg_on_hole_ros.estimator.insertion_depth import depth_at
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled
from peg_on_hole_ros.monitor.contacts import below
from peg_on_hole_ros.monitor.trend import CHANNEL, carry, correct, is_number, start

# On two points the tilt tells the depth (`insertion_depth.depth_at`). docs/jamming.md, "In the
# hole", derives what is read.

# A peg that is pushed and slides does so at this speed [m/s], and changes it by so much [m/s^2]
# for so long [s].
SPEED, CHANGES, LASTS = 0.04, 0.1, 0.1
# A peg of which nothing is known rests with this probability: most are on their way.
_BEGINS = 0.25
# Smaller tilts are none [rad].
_UPRIGHT = 1e-6
# Nothing is surer than this: rest and motion may begin at any time.
_LEAST = 0.01

# Memory: a channel of `trend`; the probability that a peg that is pushed rests.
RESTS, SIZE = CHANNEL, CHANNEL + 1
_VARIANCE, _RATE, _RATE_VARIANCE = 3, 1, 6


@compiled
def _slope(d, D, gamma, variance):
    """
    Return by how much the depth falls with the tilt [m/rad].

    Upright it has no bound: a tilt that is hardly known tells no depth, and is not to look so.
    """
    return -depth_at(d, D, max(fabs(gamma), sqrt(max(variance, 0.0)), _UPRIGHT))[1]


@compiled
def follow_depth(
    m: np.ndarray, at: int, d: float, D: float, tilt: float, variance: float, since: float,
    acceleration: float,
) -> None:  # fmt: skip
    """
    Take an orientation.

    Parameters
    ----------
    m : ndarray
        Memory, of which SIZE places from `at` on.
    at : int
    d, D : float
        Diameters [m].
    tilt, variance : float
        As measured [rad], [rad^2].
    since : float
        After the last orientation [s]; below zero: there was none.
    acceleration : float
        Of the tilt, where that of the depth allows more [rad/s^2].

    """
    if not (is_number(tilt) and is_number(variance)):
        return
    followed = m[at + _VARIANCE] > 0.0 and since >= 0.0
    slope = _slope(d, D, m[at] if followed else tilt, 4.0 * variance)
    if not followed:
        m[at + RESTS] = _BEGINS
    # In the mean over a peg that rests, and keeps to that, and one that moves.
    changes = CHANGES * sqrt(1.0 - m[at + RESTS])
    acceleration = min(acceleration, changes / slope)
    if followed:
        carry(m, at, since, acceleration, LASTS)
        correct(m, at, tilt - m[at], variance, since, acceleration)
    else:
        start(m, at, tilt, variance, acceleration)
    m[at + RESTS] = _rests(*_speed(m, at, d, D))


@compiled
def _speed(m, at, d, D):
    """Return speed into the hole and its variance [m/s], [m^2/s^2]."""
    slope = _slope(d, D, m[at], m[at + _VARIANCE])
    return -slope * m[at + _RATE], max(slope * slope * m[at + _RATE_VARIANCE], 1e-18)


@compiled
def _rests(speed, variance):
    """Return the probability of rest against half of a normal distribution of speeds."""
    # What is pushed slides in, and not out.
    wide = variance + SPEED * SPEED
    odds = _BEGINS / (1.0 - _BEGINS) * sqrt(wide / variance)
    odds *= exp(max(-0.5 * speed * speed * (1.0 / variance - 1.0 / wide), -50.0))
    odds /= 2.0 * max(below(speed * SPEED / sqrt(variance * wide)), 1e-12)
    return min(max(odds / (1.0 + odds), _LEAST), 1.0 - _LEAST)


@compiled
def rests(m: np.ndarray, at: int) -> float:
    """Return the probability that a peg that is pushed rests; see `follow_depth`."""
    return m[at + RESTS] if m[at + _VARIANCE] > 0.0 else _BEGINS


@compiled
def along_share(m: np.ndarray, at: int, p: SceneScalars, around: float) -> float:
    """
    Return which share of the friction is along the hole, if the peg slides.

    Parameters
    ----------
    m, at
        As for `follow_depth`.
    p : SceneScalars
    around : float
        Speed of the peg's surface about its axis [m/s].

    """
    if m[at + _VARIANCE] == 0.0:
        return 1.0
    speed, variance = _speed(m, at, p.d, p.D)
    speed2 = speed * speed + variance
    return sqrt(speed2 / (speed2 + around * around))
