"""All that one wrench shows of mode and forecast, by one compiled call on the filter's memory."""

from math import fabs, hypot, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import MonitorOptions
from peg_on_hole_ros.estimator.forces import rim_load
from peg_on_hole_ros.estimator.record import Estimate
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitor.contacts import (
    CLOSED,
    FREE,
    LOST_B1,
    LOST_B2,
    LOST_K,
    MOST,
    OTHER,
    below,
    load_evidence,
    misfit_evidence,
    opening_evidence,
    weigh,
)
from peg_on_hole_ros.monitor.leftover_wrench import carried_load, stands_out
from peg_on_hole_ros.monitor.trend import rest_probability, time_to_reach

# Reactions beyond this many times the largest that a rim can wedge are rounding, not reactions.
ABSURD = 10.0
# A forecast knows a learnt clearance no better than to this share of its stated spread: what the
# way there tells of it is one thing with friction and with how the motion goes on.
FORECAST_CLEARANCE = 0.05
# Reactions that pull by more than this many standard deviations are those of other contacts.
PULL = 3.0


class Settings(NamedTuple):
    """The options that compiled code needs, as one tuple of floats; see `MonitorOptions`."""

    threshold: float
    rate: float
    correlation: float
    rest_speed: float
    acceleration: float
    memory: float
    force_stddev: float
    free_acceleration: float
    clearance_floor: float


def settings(
    options: MonitorOptions, force_stddev: float, clearance_stddev: float = 0.0
) -> np.ndarray:
    """Return the options as an array, with the noise of a carried force [N]; clearance [m]."""
    return np.array(
        Settings(
            options.contact_force_threshold,
            options.mode_change_rate,
            options.evidence_time,
            options.rest_speed,
            options.forecast_acceleration_stddev,
            options.forecast_acceleration_time,
            force_stddev,
            options.free_acceleration,
            FORECAST_CLEARANCE * clearance_stddev,
        )
    )


def force_noise(scene: Scene, wrench_covariance: np.ndarray) -> float:
    """Return the standard deviation of a force that the rim carries, by the wrench's noise [N]."""
    noise = np.diagonal(wrench_covariance)
    over_radius = 2 / scene.peg_diameter
    return sqrt(noise[:3].max() + noise[3:].max() * over_radius**2)


class Shown(NamedTuple):
    """
    What is known after one wrench.

    Attributes
    ----------
    three_point, two_point, opened, stuck, free, other : float
        Probabilities, together 1.
    below : float
        Probability that gamma is below gamma0, clearance included.
    time, time_stddev : float
        Until gamma0 [s]; time below zero: there is none.
    wedged : float
        What a rim of this tilt may wedge against what it carries [N].
    usable : float
        1 where the reactions of three contacts are numbers to use.
    lost_K, lost_B1, lost_B2 : float
        Probability that this contact alone has opened.

    """

    three_point: float
    two_point: float
    opened: float
    stuck: float
    free: float
    other: float
    below: float
    time: float
    time_stddev: float
    wedged: float
    usable: float
    lost_K: float
    lost_B1: float
    lost_B2: float


WIDTH = len(Shown._fields)


@compiled
def wedged_load(estimate: Estimate, force_stddev: float) -> float:
    """Return what a rim of this tilt may wedge against what it carries [N]."""
    force, couple = rim_load(estimate)
    # A squeezed peg feels a couple and no force: over the peg's radius it counts as one.
    carried = hypot(force, 2.0 * couple / estimate.scene.d)
    tilt = max(estimate.motion.gamma, estimate.scene.gamma0)
    return (carried + force_stddev) / sin(min(tilt, 0.5 * pi))


@compiled
def gamma0_slope(estimate: Estimate) -> float:
    """Return by how much gamma0 changes with the clearance [rad/m]."""
    # cos(gamma0) = 1 - clearance / D.
    return 1.0 / (estimate.scene.D * sin(estimate.scene.gamma0))


@compiled
def gamma0_variance(estimate: Estimate) -> float:
    """Return the variance that the clearance leaves gamma0 [rad^2]."""
    slope = gamma0_slope(estimate)
    return max(estimate.diameter_variance, 0.0) * slope * slope


@compiled
def below_gamma0(estimate: Estimate) -> float:
    """Return the probability that gamma is below gamma0."""
    motion = estimate.motion
    variance = max(motion.covariance[0, 0] + gamma0_variance(estimate), 1e-24)
    return below((estimate.scene.gamma0 - motion.gamma) / sqrt(variance))


@compiled
def finite_reactions(estimate: Estimate, determinant: float, wedged: float) -> bool:
    """Return whether the equations gave reactions that are more than rounding."""
    N = estimate.reactions.normal
    largest = max(fabs(N[0]), fabs(N[1]), fabs(N[2]))
    return determinant == determinant and largest <= ABSURD * wedged


@compiled
def pushing(estimate: Estimate) -> bool:
    """Return whether the reactions may be those of contacts that push."""
    reactions, push = estimate.reactions, True
    for i in range(3):
        variance = max(reactions.covariance[i, i], 0.0)
        push = push and -PULL * sqrt(variance) < reactions.normal[i]
    return push


@compiled
def new_share(estimate: Estimate, i: int) -> float:
    """
    Return which share of what a reaction says of its contact is news at each sample.

    What friction and clearance make of a reaction stays: however often it says so, it says it
    once. By more than PULL standard deviations, they do not explain it.
    """
    reactions = estimate.reactions
    N, variance = reactions.normal[i], max(reactions.covariance[i, i], 1e-18)
    if N < 0.0 and PULL * PULL * variance < N * N:
        return 1.0
    by_friction, by_diameter = reactions.by_friction[i], reactions.by_diameter[i]
    lasting = by_friction * by_friction + by_diameter * by_diameter
    return max(0.0, 1.0 - lasting / variance)


@compiled
def show(
    estimate: Estimate, hypotheses: np.ndarray, means: np.ndarray, motion: np.ndarray,
    options: np.ndarray, dt: float, since: float, nis: float, determinant: float,
    displaced: float, out: np.ndarray,
) -> None:  # fmt: skip
    """
    Weigh the hypotheses with what a wrench shows.

    Parameters
    ----------
    estimate : Estimate
    hypotheses, means, motion : ndarray
        Of `contacts.no_knowledge`, `carried.new_means` and `trend.new_trend`.
    options : ndarray
        From `settings`.
    dt, since : float
        Since the last wrench, and since the last orientation [s].
    nis : float
        Running mean of the normalised innovation squared.
    determinant : float
        Of the six equations, over its frictionless value.
    displaced : float
        `place.Misfit.evidence` of the last place that was measured; 0: none was.
    out : ndarray
        Filled in the order of `Shown`.

    """
    o = options
    D, gamma0 = estimate.scene.D, estimate.scene.gamma0
    wedged = wedged_load(estimate, o[6])
    spread0 = gamma0_variance(estimate)
    under = below_gamma0(estimate)
    finite = finite_reactions(estimate, determinant, wedged)
    lost_K = lost_B1 = lost_B2 = 0.0
    rest = rest_probability(motion, o[3], D)
    if finite:
        # At rest friction may be anything within its cone, and the equations' reactions are moot.
        moves, N, C = 1.0 - rest, estimate.reactions.normal, estimate.reactions.covariance
        lost_K = moves * new_share(estimate, 0) * opening_evidence(N[0], C[0, 0])
        lost_B1 = moves * new_share(estimate, 1) * opening_evidence(N[1], C[1, 1])
        lost_B2 = moves * new_share(estimate, 2) * opening_evidence(N[2], C[2, 2])
    other = misfit_evidence(nis) if nis >= 0.0 else 0.0
    # A rim that touches is told from noise, from a zero of the sensor that is not known, and from
    # a holder that moves the peg in the air.
    carried, _ = carried_load(estimate, means, dt, o[2])
    moved = estimate.scene.m * o[7]
    squares = stands_out(estimate, means, o[0] * o[0] + moved * moved, o[2], estimate.work)
    load = load_evidence(squares) if carried == carried else 0.0
    p = hypotheses
    above = 1.0 - under
    # Below gamma0 there is only the hole to touch: elsewhere a load is the sensor's.
    outside = displaced * under
    load = min(load, load * (1.0 - outside / MOST)) - outside
    displaced *= above
    if displaced > 0.0:
        # A motion that fits three contacts is no evidence for them where the peg does not stand.
        other = max(other, 0.0)
    weigh(p, dt, o[1], o[2], load, lost_K, lost_B1, lost_B2, other, displaced, rest)
    out[0] = p[CLOSED] * above * (1.0 - rest)
    out[1] = (1.0 - p[FREE]) * under
    out[2] = (p[LOST_K] + p[LOST_B1] + p[LOST_B2]) * above
    out[3] = p[CLOSED] * above * rest
    out[4] = p[FREE]
    out[5] = p[OTHER] * above
    out[6] = under
    spread0 += (o[8] * gamma0_slope(estimate)) ** 2
    time, stddev = time_to_reach(motion, gamma0, spread0, o[4], o[5])
    out[7] = time - since if time > since else -1.0
    out[8] = stddev
    out[9] = wedged
    out[10] = 1.0 if finite and pushing(estimate) else 0.0
    out[11], out[12], out[13] = p[LOST_K] * above, p[LOST_B1] * above, p[LOST_B2] * above
