"""Prediction where no step is to be relied on: constant rates, which follow innovations."""

from math import exp, log

from peg_on_hole_ros.estimation.kernel.acceleration import bridged_density
from peg_on_hole_ros.estimation.kernel.carry import add_walk
from peg_on_hole_ros.estimation.kernel.correction import white_innovation
from peg_on_hole_ros.estimation.kernel.lean import MOST_SURPRISE, follow_lean, lean
from peg_on_hole_ros.estimation.kernel.memory import (
    ACCELERATION,
    BRIDGED,
    LEAN,
    RATE_NOISE,
    RATES,
    SCALES,
    SPREAD,
    WITHOUT_STEP,
    X,
    process_of,
)
from peg_on_hole_ros.estimation.kernel.prediction import predict_free
from peg_on_hole_ros.estimation.kernel.slip import bridged_scales
from peg_on_hole_ros.mechanics.kernel import compiled, inlined, scene_of

# How fast the rates' random walk follows the innovations: in so many of them by a factor of e
# where they are half as large again as stated.
ADAPTATION = 0.1
# How fast it follows their mean, squared: rates that change make innovations lean one way long
# before any one of them surprises.
LEANING = 0.05
# Rates of up to so much [rad/s] walk by what is configured at least; faster ones change by more
# within a time. A walk that lets a steady change of the rates lag by no more than what is stated
# of them grows with the 4/5 power of that change.
SLOW_RATES = 0.2
GROWS = 0.8
# The tilt's rate walks by this share of it: a peg that hardly closes may turn a lot.
TILT_WALK = 0.5
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
        Memory; SCALES is filled for the reactions.
    slopes : ndarray, shape (3 or more, 14)
        Scratch.
    dt : float
        [s].

    """
    _bridge(m, slopes, dt, m[RATE_NOISE])
    process = process_of(m)
    bridged_scales(scene_of(m), m, process.slip_velocity_scale, process.slip_widening)


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
        m[SCALES + i] = process_of(m).slip_velocity_scale
    noise = max(m[RATE_NOISE], least)
    if m[WITHOUT_STEP] > ONE_WRENCH:
        m[RATE_NOISE] = noise
    _bridge(m, slopes, dt, noise)


@inlined
def walk_density(m, noise, i):
    """Return how a rate may wander that is bridged, and how it did of late [rad^2/s^3]."""
    walk = TILT_WALK * noise if i == 0 else noise
    return walk * walk + bridged_density(m[ACCELERATION + i])


@inlined
def _bridge(m, slopes, dt, noise):
    m[BRIDGED] = 1.0
    predict_free(m, slopes, dt, 0.0)
    for i in range(3):
        add_walk(m, i, walk_density(m, noise, i), dt)


@compiled
def adapt_rate_noise(m, nis):
    """
    Let the rates' random walk follow an innovation after `bridge`.

    At constant rates the innovations alone tell how much a peg accelerates: by their size, and by
    how they lean. With each, the random walk grows and falls by exp(ADAPTATION (nis / 3 - 1) +
    LEANING (lean - 1)), where lean is the square of their white mean over its expectation. It
    falls no lower than is configured for rates like these: innovations tell of a slow change too
    late.

    Parameters
    ----------
    m : ndarray
        Memory, with the innovation and its root at RESIDUAL and S.
    nis : float
        Its square.

    """
    follow_lean(m, LEAN, white_innovation(m))
    m[RATE_NOISE] = adapted_noise(m, m[RATE_NOISE], LEAN, nis, X + 3, RATES, 13)


@inlined
def adapted_noise(m, noise, leans, nis, rates, variances, stride):
    """Return a random walk that has followed an innovation; places of lean, rates, variances."""
    # One that is no number surprises most, and the random walk stays one.
    surprise = nis / 3.0 if nis < 3.0 * MOST_SURPRISE else MOST_SURPRISE
    leant = min(lean(m, leans), MOST_SURPRISE)
    grown = noise * exp(ADAPTATION * (surprise - 1.0) + LEANING * (leant - 1.0))
    return min(max(grown, least_noise(m, rates, variances, stride)), MOST_RATE_NOISE)


@inlined
def least_noise(m, rates, variances, stride):
    """Return the least random walk of rates like these; places of rates and variances."""
    faster = 0.0
    for i in range(3):
        # Less what noise makes of it in the mean.
        faster += m[rates + i] * m[rates + i] - m[variances + stride * i]
    faster /= SLOW_RATES * SLOW_RATES
    # Beside an uncertain clearance steps are believed again soon, and such bounds alarm falsely.
    grows = growth(faster) if m[SPREAD + 3] == 0.0 else 1.0
    return process_of(m).slow_rate_noise * grows


@inlined
def growth(square):
    """Return by how much a walk grows with its rates, of these over SLOW_RATES, squared."""
    return exp(0.5 * GROWS * log(square)) if square > 1.0 else 1.0
