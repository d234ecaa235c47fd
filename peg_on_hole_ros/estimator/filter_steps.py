"""A held peg's estimate, compiled: start, predict, gate, correct, weigh, end."""

from math import isfinite, sqrt

from peg_on_hole_ros.estimator import bias_in_air, depth_update, mixture
from peg_on_hole_ros.estimator.fill_estimate import fill_estimate
from peg_on_hole_ros.estimator.filter_record import FilterMemory, FilterRecord
from peg_on_hole_ros.estimator.orientation_noise import track_orientation_noise
from peg_on_hole_ros.estimator.orientation_update import (
    jump_to,
    note_departure,
    orientation_nis,
    pass_time,
    release_still_turns,
    update_from_orientation,
)
from peg_on_hole_ros.estimator.scene_at_mean import tilted_gravity
from peg_on_hole_ros.estimator.settings import Gates
from peg_on_hole_ros.estimator.start import forget_air, start_mixture
from peg_on_hole_ros.estimator.state import FRICTION, OPEN_BEGIN
from peg_on_hole_ros.estimator.stated_accuracy import follow_accuracies, steady_friction_variance
from peg_on_hole_ros.estimator.wrench_update import update_from_wrench
from peg_on_hole_ros.mechanics.kernel import compiled, scene_of
from peg_on_hole_ros.typed_record import Floats

# What becomes of an orientation; LOST: the covariance was no longer one.
USED, GATED, RESET, LOST = range(4)


@compiled
def start(memory: FilterMemory, gates: Gates, q: Floats, R: Floats) -> None:
    """Start from an orientation q [rad] with the stated covariance R, at unknown rates."""
    kalman: FilterRecord = memory[0]
    start_mixture(kalman, q, kalman.state.noise_ratio * R, gates.initial_rate_stddev)
    kalman.refused = 0
    kalman.tilt_inflation[:] = 0.0
    fill_estimate(kalman)


@compiled
def end_estimate(memory: FilterMemory) -> None:
    """End the motion; what was estimated of friction and open quantities begins the next one."""
    kalman: FilterRecord = memory[0]
    state = kalman.state
    if state.time_since_start > 0.0:
        mean, C = state.mixture_mean, state.mixture_covariance
        # A friction that is known stays as stated, without what rounding makes of it.
        if kalman.friction_open:
            kalman.start_friction = mean[FRICTION]
            kalman.start_friction_stddev = sqrt(max(C[FRICTION, FRICTION], 0.0))
        for i in range(OPEN_BEGIN, kalman.places.reactions):
            kalman.open_mean[i - OPEN_BEGIN] = mean[i]
            kalman.open_stddev[i - OPEN_BEGIN] = sqrt(max(C[i, i], 0.0))
    kalman.refused = 0
    kalman.wrench[:] = 0.0


@compiled
def predict(memory: FilterMemory, dt: float) -> None:
    """Predict by dt [s]."""
    kalman: FilterRecord = memory[0]
    mixture.predict(kalman, dt)
    pass_time(kalman.state, dt)
    _combine(kalman)


@compiled
def gate_orientation(
    memory: FilterMemory, gates: Gates, q: Floats, R: Floats
) -> tuple[int, float]:
    """
    Compare an orientation with the estimate, without any correction; a jump widens the estimate.

    Returns
    -------
    result : int
        USED, GATED, RESET or LOST: what has to become of it.
    nis : float
        Normalised innovation squared, 3 degrees of freedom.

    """
    kalman: FilterRecord = memory[0]
    release_still_turns(kalman)
    nis = orientation_nis(kalman, q, R)
    track_orientation_noise(kalman, q, R)
    if not isfinite(nis):
        return LOST, nis
    if nis > gates.gate_threshold:
        further = note_departure(kalman, R)
        # One alone is an outlier; a second in a row indicates a jump.
        jumped = kalman.refused > 0 and further and jump_to(kalman, q, R, gates.gate_threshold)
        if not jumped:
            kalman.refused += 1
            return (GATED if kalman.refused <= gates.gate_reset_count else RESET), nis
    kalman.refused = 0
    return USED, nis


@compiled
def use_orientation(memory: FilterMemory, q: Floats, R: Floats) -> None:
    """Correct by an orientation that is used."""
    kalman: FilterRecord = memory[0]
    update_from_orientation(kalman, q, R)
    _combine(kalman)


@compiled
def correct(memory: FilterMemory, gates: Gates, q: Floats, R: Floats) -> tuple[int, float]:
    """Correct with an orientation, or start from it; return what `gate_orientation` does."""
    result, nis = gate_orientation(memory, gates, q, R)
    if result == USED:
        use_orientation(memory, q, R)
    elif result != GATED:
        if result == RESET:
            end_estimate(memory)
        start(memory, gates, q, R)
    return result, nis


@compiled
def update_from_depth(memory: FilterMemory, depth: float, variance: float, since: float) -> None:
    """Correct by a measured depth [m], [m^2], so long after the one before [s]."""
    kalman: FilterRecord = memory[0]
    if depth_update.update_from_depth(kalman, depth, variance, since):
        _combine(kalman)


@compiled
def correct_by_wrench(memory: FilterMemory, u: Floats, contact_set: int) -> None:
    """Correct by a wrench on the peg, weighed with a ContactSet, and fill in the record."""
    kalman: FilterRecord = memory[0]
    kalman.wrench[:] = u
    if not isfinite(kalman.state.mixture_mean[0]):
        return
    if bias_in_air.corrects_bias(kalman, contact_set):
        bias_in_air.add_bias_process_noise(kalman)
        bias_in_air.update_bias_in_air(kalman)
    else:
        forget_air(kalman.state)
    stated = kalman.accuracies.stated != 0
    friction_before = steady_friction_variance(kalman) if stated else 0.0
    update_from_wrench(kalman, contact_set)
    follow_accuracies(kalman, friction_before)
    inflate_tilt_variance(kalman)
    fill_estimate(kalman)


@compiled
def _combine(kalman: FilterRecord) -> None:
    mixture.combine(kalman.state)
    inflate_tilt_variance(kalman)


@compiled
def inflate_tilt_variance(kalman: FilterRecord) -> None:
    """
    Increase the variance of a tilt that has moved by more than its estimation accounts for.

    When the filter estimates the hole's tilt and its variance falls by v, the mean should move by
    about sqrt(v). If it moves further, something else moves it, for example gears that bend: it
    may as well be where it began, however much is estimated from there on.
    """
    first, state = kalman.places.tilt, kalman.state
    if first < 0 or kalman.estimated[first] == 0.0:
        return
    C, significance = state.mixture_covariance, kalman.settings.significance
    for i in range(first, first + 2):
        begun = kalman.open_stddev[i - OPEN_BEGIN]
        moved = state.mixture_mean[i] - kalman.open_mean[i - OPEN_BEGIN]
        fallen = max(begun * begun - C[i, i], 0.0)
        more = max(kalman.tilt_inflation[i - first], moved * moved - significance**2 * fallen)
        if not (more > 0.0 and C[i, i] > 0.0):
            continue
        kalman.tilt_inflation[i - first] = more
        # All that depends on the tilt moves with it.
        along = C[i].copy() / C[i, i]
        for a in range(state.width):
            for b in range(state.width):
                C[a, b] += more * along[a] * along[b]


@compiled
def fill(memory: FilterMemory) -> None:
    """Fill in the record."""
    fill_estimate(memory[0])


@compiled
def gravity(memory: FilterMemory) -> tuple[float, float, float]:
    """Return gravity in the axes of the hole at its estimated tilt [m/s^2]."""
    kalman: FilterRecord = memory[0]
    return tilted_gravity(scene_of(kalman.scene), kalman.state.mixture_mean, kalman.places)
