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
    state, settings = kalman.state, kalman.settings
    modes, hypotheses = settings.modes, state.hypotheses
    spacing = 2.0 * settings.reach / max(hypotheses - 1, 1)
    total = 0.0
    for g in range(hypotheses):
        off = -settings.reach + g * spacing if hypotheses > 1 else 0.0
        f = max(kalman.start_friction + off * kalman.start_friction_stddev, 0.0)
        # One without friction is a peg as well, where no other is left.
        state.alive[g] = 1.0 if f > 0.0 or g == hypotheses - 1 else 0.0
        own = exp(-0.5 * off * off) * state.alive[g]
        wide = (0.5 * spacing if hypotheses > 1 else 1.0) * kalman.start_friction_stddev
        shut = modes > 1 and hypotheses > 1 and settings.top_waits > 0.0
        for j in range(g * modes, g * modes + modes):
            state.weight[j] = own / modes
            if shut and j == g * modes + modes - 1:
                state.weight[j] = MIXTURE_WEIGHTS.least_weight * own
            total += state.weight[j]
            _start_component(kalman, j, q, R, rate_stddev)
            state.x[j, FRICTION], state.P[j, FRICTION, FRICTION] = f, wide * wide
            _spread_offsets(kalman, j, q)
    for j in range(modes * hypotheses):
        state.weight[j] /= total
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
    batch.load_by_tilt[:, :] = 0.0
