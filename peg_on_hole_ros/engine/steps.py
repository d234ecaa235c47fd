"""What one orientation or wrench does, step by step: predict, correct, weigh, fill the row."""

from math import inf, isfinite, nan, pi, sqrt

import numpy as np

from peg_on_hole_ros.engine.state import PLACE, PLACE_R, EngineState, Q, Rules
from peg_on_hole_ros.engine.tuned import KNOWN_MOTION
from peg_on_hole_ros.estimator import filter_steps
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.filter_steps import GATED, RESET, USED
from peg_on_hole_ros.estimator.orientation_noise import forget_noise_ratio
from peg_on_hole_ros.estimator.orientation_update import jumped_lately
from peg_on_hole_ros.estimator.state import RATE
from peg_on_hole_ros.measurements.freshness import is_news
from peg_on_hole_ros.measurements.innovations import add_innovation, forget_innovations
from peg_on_hole_ros.measurements.tuned import WRENCH_NOISE_TEST
from peg_on_hole_ros.measurements.wrench_noise import registry as wrench_noise
from peg_on_hole_ros.measurements.wrench_noise import repeated, rough, saturated
from peg_on_hole_ros.measurements.wrench_noise.received import Received
from peg_on_hole_ros.measurements.wrench_reduction import (
    note_load,
    note_payload,
    reduce_wrench,
    turned_to_peg,
)
from peg_on_hole_ros.mechanics.kernel import compiled, scene_of
from peg_on_hole_ros.monitor import assessment, pose_only
from peg_on_hole_ros.monitor import memory as monitor
from peg_on_hole_ros.monitor.assessment import contacts_of
from peg_on_hole_ros.monitor.place_check import misfit, take_place
from peg_on_hole_ros.monitor.states import NO_STAMP, Mode
from peg_on_hole_ros.monitor.way_in import may_be_plate
from peg_on_hole_ros.outputs import Row

# What an orientation is: a correction, a start where the motion was lost, or a repeated value.
NEWS, BEGINS, OLD = range(3)


@compiled
def restart(e: EngineState, rules: Rules) -> None:
    """Forget the motion; what was learnt stays, and what was counted."""
    d = e.progress
    d.t_ns = d.oriented_ns = NO_STAMP
    d.slid_ns = 0
    wrench_noise.forget(e.wrench_noise)
    d.in_contact = d.touching = d.blind = d.lost = False
    filter_steps.end_estimate(e.filter)
    forget_noise_ratio(e.filter[0].state)
    e.filter[0].state.time_since_jump = inf
    forget_innovations(e.innovations)
    if rules.judged:
        monitor.restart(e.memory)
    else:
        pose_only.restart_unjudged(e.memory)


@compiled
def start_estimate(e: EngineState, rules: Rules, t_ns: int, orientation: np.ndarray) -> None:
    """Start from an orientation, a row of ORIENTATION_WIDTH, of a stamp [ns]."""
    e.progress.t_ns = t_ns
    for i in range(3):
        e.q[i] = orientation[i]
        for j in range(3):
            e.R[i, j] = orientation[3 + 3 * i + j]
    filter_steps.start(e.filter, rules.gates, e.q, e.R)
    record_start(e)


@compiled
def record_start(e: EngineState) -> None:
    """Record a start by an orientation of the present stamp."""
    d = e.progress
    d.oriented_ns, d.lost = d.t_ns, False
    e.counts.joints_used += 1


@compiled
def is_after_silence(e: EngineState, rules: Rules, t_ns: int) -> bool:
    """Return whether a wrench comes after a silence, which is counted."""
    # The estimate stands where the wrench before, or the start, has left it.
    silent = (t_ns - e.progress.t_ns) * 1e-9 > rules.max_gap
    e.counts.gap += silent
    return silent


@compiled
def advance(e: EngineState, rules: Rules, t_ns: int) -> None:
    """Predict up to a stamp [ns]."""
    dt = time_to_predict(e, rules, t_ns)
    if dt > 0.0:
        filter_steps.predict(e.filter, dt)
        check_upright(e, rules)


@compiled
def time_to_predict(e: EngineState, rules: Rules, t_ns: int) -> float:
    """Come to a stamp [ns]; return the time to be predicted [s], 0 where there is none."""
    d = e.progress
    dt = (t_ns - d.t_ns) * 1e-9
    d.t_ns = t_ns
    if not d.lost and t_ns - d.oriented_ns > rules.lost_ns:
        _lose(e, rules)
    return 0.0 if d.lost else dt


@compiled
def check_upright(e: EngineState, rules: Rules) -> None:
    """Lose a motion beyond a quarter turn: there is no tilt, and the outputs would be wrong."""
    if not -0.5 * pi < e.filter[0].state.mixture_mean[0] < 0.5 * pi:
        _lose(e, rules)


@compiled
def _lose(e, rules):
    """Forget a motion that nothing is known of; the next orientation begins another."""
    t_ns = e.progress.t_ns
    restart(e, rules)
    e.progress.t_ns, e.progress.lost = t_ns, True
    e.counts.motion_lost += 1


@compiled
def correct(
    e: EngineState, rules: Rules, stamp: int, orientation: np.ndarray, lateness: float
) -> None:
    """
    Correct by an orientation.

    Parameters
    ----------
    e : EngineState
    rules : Rules
    stamp : int
        Of the orientation [ns].
    orientation : ndarray, shape (ORIENTATION_WIDTH,)
    lateness : float
        How long before the estimate's stamp it was [s].

    """
    kind = classify_orientation(e, rules, stamp, orientation, lateness)
    if kind == BEGINS:
        filter_steps.start(e.filter, rules.gates, e.q, e.R)
        record_start(e)
    elif kind == NEWS:
        since = (e.progress.t_ns - e.progress.oriented_ns) * 1e-9
        result, nis = filter_steps.correct(e.filter, rules.gates, e.q, e.R)
        record_orientation(e, rules, orientation, result, nis)
        placed = orientation[PLACE.start] == orientation[PLACE.start]
        if result == USED and placed and lateness == 0.0:
            depth, variance = -orientation[PLACE.start + 2], orientation[PLACE_R.stop - 1]
            filter_steps.update_from_depth(e.filter, depth, variance, since)


@compiled
def classify_orientation(
    e: EngineState, rules: Rules, stamp: int, orientation: np.ndarray, lateness: float
) -> int:
    """Put an orientation into `q` and `R`, as of now; return NEWS, BEGINS or OLD."""
    kalman: FilterRecord = e.filter[0]
    s, kind = kalman.state, NEWS
    for i in range(3):
        e.q[i] = orientation[i]
        for j in range(3):
            e.R[i, j] = rules.joints_variance * orientation[3 + 3 * i + j]
    if e.progress.lost:
        kind = BEGINS
        turned = lateness * rules.gates.initial_rate_stddev
        for i in range(3):
            e.R[i, i] += turned * turned
    elif is_news(e.fresh, stamp, e.q, e.R[0, 0], s.mixture_mean, s.mixture_covariance[0, 0]):
        for i in range(3):
            e.q[i] += lateness * s.mixture_mean[RATE + i]
            for j in range(3):
                e.R[i, j] += lateness * lateness * s.mixture_covariance[RATE + i, RATE + j]
    else:
        kind = OLD
        e.counts.joints_dropped_repeated_value += 1
    return kind


@compiled
def record_orientation(
    e: EngineState, rules: Rules, orientation: np.ndarray, result: int, nis: float
) -> None:
    """Record what became of an orientation, see `filter_steps.gate_orientation`."""
    d, s, memory = e.progress, e.filter[0].state, e.memory
    if s.noise_ratio > WRENCH_NOISE_TEST.noisy:
        e.counts.joints_noisy += 1
        d.noise = sqrt(s.noise_ratio)
    if isfinite(nis):
        known = result == USED and rules.white
        e.counts.innovations_too_large += add_innovation(
            e.innovations, nis, s.innovation, known, d.in_contact, d.touching
        )
    if result == GATED:
        e.counts.joints_gated += 1
        return
    e.counts.joints_used += 1
    d.oriented_ns, d.blind = d.t_ns, False
    if rules.judged:
        for i in range(3):
            for j in range(3):
                e.R[i, j] *= s.noise_ratio
        foreseen = result == USED
        assessment.take_orientation(memory, rules.monitor, d.t_ns, e.q, e.R, foreseen)
        if orientation[PLACE.start] == orientation[PLACE.start]:
            _note_place(e, orientation, rules.monitor.around)
    if result >= RESET:
        e.counts.filter_restarted += 1
        restart_mode(e, rules)


@compiled
def restart_mode(e: EngineState, rules: Rules) -> None:
    """Forget the mode: the estimate has begun anew."""
    if rules.judged:
        monitor.restart_mode(e.memory)
        e.memory.declared.refuted = True
    else:
        pose_only.take_as_closed(e.memory)


@compiled
def begin_mode_anew(e: EngineState, rules: Rules) -> None:
    """Forget mode and alarms: they rest on another zero."""
    if rules.judged:
        monitor.begin_mode_anew(e.memory)


@compiled
def _note_place(e, orientation, around):
    estimate, place = e.filter[0].record, e.memory.place
    scene = estimate.scene
    R = orientation[3:12].reshape(3, 3)
    S = orientation[PLACE_R].reshape(3, 3)
    found = misfit(
        orientation[Q],
        R,
        orientation[PLACE],
        S,
        scene.d,
        scene.D,
        estimate.diameter_variance,
        around,
    )
    take_place(place, found)


@compiled
def admit_wrench(e: EngineState, rules: Rules) -> bool:
    """Count a wrench, and note whether the motion is a guess; return whether it is published."""
    d = e.progress
    if d.lost:
        e.counts.wrench_dropped_without_orientation += 1
        return False
    e.counts.wrench_used += 1
    # Without any orientation for long, the motion is a guess, and is not published.
    since = (d.t_ns - d.oriented_ns - rules.delay_ns) * 1e-9
    if since > rules.max_joint_gap or e.fresh.still or _on_either_side(e):
        e.counts.joints_gap += not d.blind
        d.blind = True
    return True


@compiled
def _on_either_side(e):
    """Return whether the tilt, for want of orientations, may be above gamma0 or below."""
    s, gamma0 = e.filter[0].state, e.filter[0].record.scene.gamma0
    variance = s.mixture_covariance[0, 0]
    off = s.mixture_mean[0] - gamma0
    vague, near = KNOWN_MOTION.vague_tilt, KNOWN_MOTION.near_transition
    return variance > (vague * gamma0) ** 2 and off * off < near * near * variance


@compiled
def _zeros_are_loaded(e, wrench):
    """Return whether a wrench is of zeros that are not those of a free peg, by more than noise."""
    kalman: FilterRecord = e.filter[0]
    for i in range(6):
        if wrench[i] != 0.0:
            return False
        e.wrench[i] = 0.0
    q, gravity = kalman.state.mixture_mean, filter_steps.gravity(e.filter)
    reduce_wrench(e.reduction, e.wrench, q, gravity, e.u)
    mass, weight, left = scene_of(kalman.scene).m, turned_to_peg(q, gravity), 0.0
    for i in range(3):
        left += (e.u[i] + mass * weight[i]) ** 2
    return left > (KNOWN_MOTION.loaded * KNOWN_MOTION.loaded) * 3.0 * e.variance[0]


@compiled
def reduce(e: EngineState, t_ns: int, wrench: np.ndarray, silent: bool) -> ContactSet:
    """Put a wrench as received into `u`; return which contacts it is weighed with."""
    in_air = e.memory.declared.mode == Mode.OPEN
    settings = e.filter[0].settings
    e.wrench_noise.repeated.loaded = _zeros_are_loaded(e, wrench)
    received = Received(t_ns, wrench, e.variance, in_air, e.fresh.oriented, settings)
    wrench_noise.follow(e.wrench_noise, received)
    e.counts.wrench_stands_still += repeated.is_off(e.wrench_noise.repeated)
    e.counts.wrench_saturated += saturated.is_off(e.wrench_noise.saturated)
    e.counts.wrench_noisy += rough.factor(e.wrench_noise.rough) > 1.0
    times = wrench_noise.factor(e.wrench_noise)
    for i in range(6):
        e.wrench[i] = wrench[i]
        for j in range(6):
            e.filter[0].noise[i, j] = times * e.covariance[i, j]
    q, gravity = e.filter[0].state.mixture_mean, filter_steps.gravity(e.filter)
    reduce_wrench(e.reduction, e.wrench, q, gravity, e.u)
    if e.filter[0].accuracies.stated != 0:
        note_payload(e.filter[0].accuracies, q, gravity)
        since = e.filter[0].state.time_since_wrench
        note_load(e.filter[0].accuracies, e.reduction, e.wrench, e.variance, since)
    # What has touched before a silence need not touch after it.
    if silent or e.progress.blind or wrench_noise.is_off(e.wrench_noise):
        return ContactSet.UNKNOWN
    return contacts_of(e.memory)


@compiled
def fill_row(e: EngineState, rules: Rules, t_ns: int, contacts: ContactSet, row: Row) -> None:
    """Fill in what is published after a wrench that was weighed with some contacts."""
    d, memory = e.progress, e.memory
    e.counts.wrench_spike += e.filter[0].state.misfits == 1
    d.in_contact = contacts == ContactSet.THREE
    estimate = e.filter[0].record
    blind = d.blind or wrench_noise.is_off(e.wrench_noise)
    if rules.judged:
        misfits = e.innovations.misfit
        assessment.assess(estimate, memory, rules.monitor, t_ns, misfits, blind, row)
        undecided = may_be_plate(memory.way, memory.declared.mode, memory.evidence)
        e.counts.contact_may_be_plate += undecided
    else:
        pose_only.assess_pose_only(estimate, memory, rules.monitor, t_ns, blind, row)
    # Of a peg at rest friction leans one way for long, which is no wrong setting. One that is
    # wrong makes the mode doubtful as well, and is not to hide behind that.
    if contacts != ContactSet.THREE or row.reactions_determined > 0.0:
        d.slid_ns = t_ns
    doubtful = rules.judged and memory.declared.mode == Mode.UNKNOWN
    slides = contacts == ContactSet.THREE and t_ns - d.slid_ns < KNOWN_MOTION.rests_ns
    d.touching = slides or doubtful
    if e.innovations.large or jumped_lately(e.filter[0].state, e.filter[0].settings):
        # What the motion contradicts is not known, however small its spread.
        row.reactions_determined = 0.0
    _fill_settings(e, rules, row)


@compiled
def _fill_settings(e, rules, row):
    """Fill in innovations, tare, bias and tilt."""
    t, s = e.innovations, e.filter[0].state
    row.nis_median = t.median
    row.nis_drift = t.drift if rules.white else nan
    row.joints_noise = sqrt(s.noise_ratio)
    for i in range(6):
        row.bias[i] = e.tared[i]
    bias, tilt, steps = e.filter[0].places.bias, e.filter[0].places.tilt, e.reduction
    if bias >= 0:
        for i in range(6):
            row.bias[i] = s.mixture_mean[bias + i] + steps.sign * steps.tare[i]
            variance = s.mixture_covariance[bias + i, bias + i]
            row.bias_stddev[i] = sqrt(max(variance, 0.0))
    if tilt >= 0:
        for i in range(2):
            row.hole_tilt[i] = s.mixture_mean[tilt + i]
            variance = s.mixture_covariance[tilt + i, tilt + i]
            row.hole_tilt_stddev[i] = sqrt(max(variance, 0.0))
