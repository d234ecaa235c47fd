"""Prediction where a slip is not told from none: constant rates, which follow innovations."""

from math import exp

from peg_on_hole_ros.estimation.acceleration import bridged_density
from peg_on_hole_ros.estimation.kernel import predict_free
from peg_on_hole_ros.estimation.memory import PROCESS, RATE_NOISE, Z
from peg_on_hole_ros.mechanics.kernel import compiled, inlined

# How fast the rates' random walk follows the innovations: in so many of them by a factor of e
# where they are half as large again as stated.
ADAPTATION = 0.1
# One innovation squared counts as this much at most, over its expectation.
MOST_SURPRISE = 5.0
# A held peg turns round from 60 rad/s^2 to its opposite within a millisecond at most
# [rad/s^1.5].
MOST_RATE_NOISE = 3.0


@compiled
def bridge(m, slopes, dt):
    """
    Predict over dt at constant rates, uncertain by RATE_NOISE and by how they changed of late.

    Parameters
    ----------
    m : ndarray
        Memory.
    slopes : ndarray, shape (3 or more, 14)
        Scratch.
    dt : float
        [s].

    """
    predict_free(m, slopes, dt, m[RATE_NOISE] * m[RATE_NOISE])
    for i in range(3):
        # As `carry` adds a random walk.
        more, at = dt * bridged_density(m, i), Z + 13 * i
        m[at] += dt * dt * more
        m[at + 3] += dt * more
        m[at + 36] += dt * more
        m[at + 39] += more


@inlined
def adapt_rate_noise(m, nis):
    """
    Let the rates' random walk follow an innovation squared after `bridge`.

    At constant rates the innovations alone tell how much a peg accelerates. The random walk grows
    and falls by exp(ADAPTATION (nis / 3 - 1)) with each, from what is configured upwards.
    """
    surprise = min(nis / 3.0, MOST_SURPRISE)
    grown = m[RATE_NOISE] * exp(ADAPTATION * (surprise - 1.0))
    m[RATE_NOISE] = min(max(grown, m[PROCESS + 8]), MOST_RATE_NOISE)
