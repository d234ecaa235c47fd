"""A start of the estimate from an orientation, at unknown rates."""

from math import exp

import numpy as np

from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.mixture import combine
from peg_on_hole_ros.estimator.orientation import (
    fill_orientation_jacobian,
    fill_orientation_residual,
)
from peg_on_hole_ros.estimator.settings import Settings
from peg_on_hole_ros.estimator.state import (
    ACCELERATION,
    FRICTION,
    OPEN_BEGIN,
    RATE,
    AirBatch,
    State,
)
from peg_on_hole_ros.estimator.tuned import MIXTURE_WEIGHTS
from peg_on_hole_ros.estimator.update import copy_component
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.typed_record import Floats


@compiled
def unmeasured_acceleration(settings: Settings) -> float:
    """Return the standard deviation of accelerations before any wrench [rad/s^2]."""
    stddev: float = settings.mode_stddev[max(settings.modes - 2, 0)]
    return min(stddev, 1.0 / settings.settling)


@compiled
def start_mixture(kalman: FilterRecord, q: Floats, R: Floats, rate_stddev: float) -> None:
    """
    Start from an orientation, at unknown rates.

    Parameters
    ----------
    kalman : FilterRecord
        With means and standard deviations at the start; its state is filled.
    q : ndarray, shape (3,)
        gamma, psi, phi [rad].
    R : ndarray, shape (3, 3)
        Their covariance [rad^2].
    rate_stddev : float
        [rad/s].

    """
    state = kalman.state
    _weigh_frictions(kalman)
    for j in range(state.components):
        _start_component(kalman, j, q, R, rate_stddev)
        _spread_offsets(kalman, j, q)
    _gather(kalman)
    state.evidence_share, state.load = 1.0, 0.0
    state.friction_floor[:] = 0.0
    state.time_since_start, state.time_in_contact = 0.0, -1.0
    state.time_since_wrench = state.time_since_orientation = 0.0
    forget_air(state)
    state.start_rate_variance = rate_stddev * rate_stddev
    state.nis_orientation = state.nis_wrench = np.nan
    state.innovation_before[:] = np.nan
    state.orientations[:, :] = np.nan
    combine(state)


@compiled
def _weigh_frictions(kalman: FilterRecord) -> None:
    """Fill in friction's hypotheses, those that are none, and the weights of all components."""
    state, settings = kalman.state, kalman.settings
    modes, hypotheses = settings.modes, state.hypotheses
    shut = modes > 1 and hypotheses > 1 and settings.top_waits > 0.0
    total = 0.0
    for g in range(hypotheses):
        own = _prior(kalman, g)
        state.alive[g] = 1.0 if own > 0.0 else 0.0
        for j in range(g * modes, g * modes + modes):
            state.weight[j] = own / modes
            if shut and j == g * modes + modes - 1:
                state.weight[j] = MIXTURE_WEIGHTS.least_weight * own
            total += state.weight[j]
    for j in range(modes * hypotheses):
        state.weight[j] /= total


@compiled
def _friction(kalman: FilterRecord, g: int) -> tuple[float, float]:
    """Return friction of a hypothesis at a start, and how many deviations that is off."""
    settings, hypotheses = kalman.settings, kalman.state.hypotheses
    off = -settings.reach + g * _spacing(kalman) if hypotheses > 1 else 0.0
    return max(kalman.start_friction + off * kalman.start_friction_stddev, 0.0), off


@compiled
def _spacing(kalman: FilterRecord) -> float:
    spacing: float = 2.0 * kalman.settings.reach / max(kalman.state.hypotheses - 1, 1)
    return spacing


@compiled
def _prior(kalman: FilterRecord, g: int) -> float:
    """Return the weight of a hypothesis before any wrench, beside those of the others."""
    f, off = _friction(kalman, g)
    # One without friction is a peg as well, where no other is left.
    return exp(-0.5 * off * off) if f > 0.0 or g == kalman.state.hypotheses - 1 else 0.0


@compiled
def _own_variance(kalman: FilterRecord) -> float:
    """Return the variance of friction of each hypothesis at a start."""
    wide = 0.5 * _spacing(kalman) if kalman.state.hypotheses > 1 else 1.0
    return (wide * kalman.start_friction_stddev) ** 2


@compiled
def _all_frictions(kalman: FilterRecord) -> tuple[float, float]:
    """Return mean and variance of friction over all hypotheses at a start."""
    total, mean, square = 0.0, 0.0, 0.0
    for g in range(kalman.state.hypotheses):
        f, _ = _friction(kalman, g)
        own = _prior(kalman, g)
        total += own
        mean += own * f
        square += own * f * f
    mean /= total
    return mean, max(square / total - mean * mean, 0.0) + _own_variance(kalman)


@compiled
def _gather(kalman: FilterRecord) -> None:
    """Let the first friction hypothesis stand for all until the contacts tell them apart."""
    state, modes = kalman.state, kalman.settings.modes
    mean, variance = _all_frictions(kalman)
    total = 0.0
    for j in range(modes):
        total += state.weight[j]
    state.gathered = 1 if state.hypotheses > 1 else 0
    if total == 0.0:
        # It is none of those that are followed, and stands for them with their weights.
        last = state.components - modes
        for j in range(modes):
            state.weight[j] = state.weight[last + j]
            total += state.weight[j]
    for j in range(state.components):
        if j >= modes:
            state.weight[j] = 0.0
            continue
        state.weight[j] /= total
        state.x[j, FRICTION], state.P[j, FRICTION, FRICTION] = mean, variance
    for g in range(state.hypotheses):
        state.alive[g] = 1.0 if g == 0 else 0.0


@compiled
def split(kalman: FilterRecord) -> None:
    """Follow every friction hypothesis by itself, from the first wrench in contact on."""
    state, modes = kalman.state, kalman.settings.modes
    if state.gathered == 0:
        return
    state.gathered = 0
    _, variance = _all_frictions(kalman)
    walked = max(state.P[0, FRICTION, FRICTION] - variance, 0.0) + _own_variance(kalman)
    total = 0.0
    for g in range(state.hypotheses):
        total += _prior(kalman, g)
    # The first comes last: it is what the others are made of.
    for g in range(state.hypotheses - 1, -1, -1):
        f, _ = _friction(kalman, g)
        own = _prior(kalman, g) / total
        state.alive[g] = 1.0 if own > 0.0 else 0.0
        for k in range(modes):
            j = g * modes + k
            if g > 0:
                copy_component(state.x[j], state.P[j], state.x[k], state.P[k], state.width)
                state.friction_floor[j] = state.friction_floor[k]
            state.x[j, FRICTION], state.P[j, FRICTION, FRICTION] = f, walked
            state.weight[j] = own * state.weight[k]
    combine(state)


@compiled
def _start_component(
    kalman: FilterRecord, j: int, q: Floats, R: Floats, rate_stddev: float
) -> None:
    """Fill in mean and covariance of a component, but for friction."""
    n, x, P = kalman.places.reactions, kalman.state.x[j], kalman.state.P[j]
    for i in range(n + 3):
        x[i] = 0.0
        for k in range(n + 3):
            P[i, k] = 0.0
    for i in range(3):
        x[i] = q[i]
        for k in range(3):
            P[i, k] = R[i, k]
        P[RATE + i, RATE + i] = rate_stddev * rate_stddev
        P[ACCELERATION + i, ACCELERATION + i] = unmeasured_acceleration(kalman.settings) ** 2
    for i in range(OPEN_BEGIN, n):
        x[i], P[i, i] = kalman.open_mean[i - OPEN_BEGIN], kalman.open_stddev[i - OPEN_BEGIN] ** 2


@compiled
def _spread_offsets(kalman: FilterRecord, component: int, q: Floats) -> None:
    """Make the angles of a component as uncertain as tilt and delay leave them."""
    places, scratch = kalman.places, kalman.scratch
    x, P = kalman.state.x[component], kalman.state.P[component]
    n, E = places.reactions, scratch.jacobian
    for place, width in ((places.tilt, 2), (places.delay, 1)):
        if place < 0:
            continue
        fill_orientation_jacobian(x, places, n, E)
        for i in range(3):
            for k in range(3):
                for j in range(place, place + width):
                    P[i, k] += E[i, j] * P[j, j] * E[k, j]
            for j in range(place, place + width):
                P[i, j] = -E[i, j] * P[j, j]
                P[j, i] = P[i, j]
        if place == places.delay:
            for i in range(3):
                P[i, i] += P[RATE + i, RATE + i] * P[place, place]
    fill_orientation_jacobian(x, places, n, E)
    fill_orientation_residual(x, places, q, E, scratch.residual)
    for i in range(3):
        x[i] += scratch.residual[i]


@compiled
def forget_air(state: State) -> None:
    """Forget the wrenches that were gathered in the air."""
    for batch in range(3):
        forget_batch(state.air[batch])


@compiled
def forget_batch(batch: AirBatch) -> None:
    """Empty a batch."""
    batch.time, batch.wrenches = 0.0, 0
    batch.load[:] = 0.0
