"""Prediction where no step is to be relied on: constant rates, which follow innovations."""

from math import exp

from peg_on_hole_ros.estimation.acceleration import bridged_density
from peg_on_hole_ros.estimation.kernel import predict_free
from peg_on_hole_ros.estimation.memory import BRIDGED, PROCESS, RATE_NOISE, SCALES, WITHOUT_STEP, Z
from peg_on_hole_ros.mechanics.kernel import compiled, inlined

# How fast the rates' random walk follows the innovations: in so many of them by a factor of e
# where they are half as large again as stated.
ADAPTATION = 0.1
# One innovation squared counts as this much at most, over its expectation.
MOST_SURPRISE = 5.0
# A held peg turns round from 60 rad/s^2 to its opposite within a millisecond at most
# [rad/s^1.5].
MOST_RATE_NOISE = 3.0
# Where there is no step for longer than this [s], it is not one wrench: the peg may turn round.
ONE_WRENCH = 0.0025


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
    _bridge(m, slopes, dt, m[RATE_NOISE])


@compiled
def bridge_without_step(m, slopes, dt, least):
    """
    Predict so where the equations have no step, as under a wrench that noise has moved there.

    For a moment that tells nothing of how the rates change; after ONE_WRENCH the walk lasts.

    Parameters
    ----------
    m, slopes, dt
        As for `bridge`; the time is added to WITHOUT_STEP.
    least : float
        Least random walk of the rates [rad/s^1.5].

    """
    m[WITHOUT_STEP] += dt
    for i in range(3):
        m[SCALES + i] = m[PROCESS + 2]
    noise = max(m[RATE_NOISE], least)
    if m[WITHOUT_STEP] > ONE_WRENCH:
        m[RATE_NOISE] = noise
    _bridge(m, slopes, dt, noise)


@inlined
def _bridge(m, slopes, dt, noise):
    m[BRIDGED] = 1.0
    predict_free(m, slopes, dt, noise * noise)
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
    # One that is no number surprises most, and the random walk stays one.
    surprise = nis / 3.0 if nis < 3.0 * MOST_SURPRISE else MOST_SURPRISE
    grown = m[RATE_NOISE] * exp(ADAPTATION * (surprise - 1.0))
    m[RATE_NOISE] = min(max(grown, m[PROCESS + 8]), MOST_RATE_NOISE)
