"""What a wrench does to the state: correction by the contacts that carry, and evidence."""

from math import isfinite, isinf, log

import numpy as np

from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.contact_sets import registry
from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.friction_direction import add_product_noise, fill_product_covariance
from peg_on_hole_ros.estimator.friction_walk import keep_friction_floor
from peg_on_hole_ros.estimator.mixture import (
    combine,
    fill_evidence_share,
    keep_friction_force,
    merge,
    reweigh,
)
from peg_on_hole_ros.estimator.rim_points import correct_by_particles, correct_by_sigma_points
from peg_on_hole_ros.estimator.scratch import Scratch
from peg_on_hole_ros.estimator.start import split, unmeasured_acceleration
from peg_on_hole_ros.estimator.state import ACCELERATION, FRICTION, RATE
from peg_on_hole_ros.estimator.tuned import WRENCH_STEP
from peg_on_hole_ros.estimator.update import copy_component, reset_three, update
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled, scene_of
from peg_on_hole_ros.mechanics.linear_algebra import FORCE, TORQUE, factor_cholesky, length, whiten
from peg_on_hole_ros.typed_record import Floats

_GRAVITY = 9.81
_EQUATIONS = 6.0


@compiled
def rim_load_bound(scene: SceneScalars, u: Floats) -> float:
    """Return an upper bound of what the rim carries under a wrench and the weight [N]."""
    return length(u, FORCE) + 2.0 * length(u, TORQUE) / scene.d + scene.m * _GRAVITY


@compiled
def update_from_wrench(kalman: FilterRecord, contact_set: int) -> None:
    """
    Correct every component by the wrench and the equations of the contacts that carry.

    Parameters
    ----------
    kalman : FilterRecord
        With the wrench on the peg and its noise; mean and covariance are filled in.
    contact_set : int
        Of ContactSet.

    """
    state, settings = kalman.state, kalman.settings
    dt = state.time_since_wrench
    state.time_since_wrench = 0.0
    state.load = rim_load_bound(scene_of(kalman.scene), kalman.wrench)
    state.nis_wrench = np.nan
    driven = isinf(settings.mode_time[0])
    corrects = registry.solved_reactions(contact_set) > 0
    if driven and not registry.may_drive_motion(contact_set):
        corrects = False
    if not corrects or state.time_since_start < settings.settling or _drifts(kalman):
        free = contact_set == ContactSet.NONE
        state.contact_set = ContactSet.NONE if free else ContactSet.UNKNOWN
        state.time_in_contact = -1.0
        _forget_contact(kalman)
        combine(state)
        return
    split(kalman)
    state.contact_set = contact_set  # type: ignore[assignment]
    begins = state.time_in_contact < 0.0
    state.time_in_contact = 0.0 if begins else state.time_in_contact + dt
    if begins:
        for i in range(3):
            state.friction_force2[i] = (state.mixture_mean[FRICTION] * state.load) ** 2
    several = state.alive.sum() > 1.5
    _begin_wrench(kalman, begins)
    nis = _correct_all(kalman, dt, settings.passes if begins else 1, 1.0)
    misfit = nis > settings.outlier * _EQUATIONS and not begins
    state.misfits = state.misfits + 1 if misfit else 0
    if state.misfits == 1:
        _take_back(kalman)
        _correct_all(kalman, dt, 1, nis / _EQUATIONS)
    state.nis_wrench = nis
    if several:
        fill_evidence_share(kalman, max(dt, WRENCH_STEP.least_time))
    reweigh(kalman)
    if several:
        merge(state, settings)
    combine(state)
    keep_friction_force(state)


@compiled
def _drifts(kalman: FilterRecord) -> bool:
    """Return whether the tilt's rate is known less than at a start: no slip has a direction."""
    state = kalman.state
    variance = state.mixture_covariance[RATE, RATE]
    return isfinite(kalman.settings.mode_time[0]) and variance > state.start_rate_variance


@compiled
def reaction_variance(kalman: FilterRecord) -> float:
    """Return the prior variance of each reaction [N^2]."""
    return (kalman.settings.reaction_prior * kalman.state.load) ** 2


@compiled
def _forget_contact(kalman: FilterRecord) -> None:
    """Make the reactions unknown, and accelerations that only a wrench determines."""
    state, settings, n = kalman.state, kalman.settings, kalman.places.reactions
    for j in range(state.components):
        registry.begin_reactions(
            state.contact_set, state.x[j], state.P[j], n, reaction_variance(kalman)
        )
        if isinf(settings.mode_time[j % settings.modes]):
            variance = unmeasured_acceleration(settings) ** 2
            reset_three(state.P[j], ACCELERATION, n + 3, variance)


@compiled
def _begin_wrench(kalman: FilterRecord, begins: bool) -> None:
    """Begin reactions anew, and keep every component as it is before the wrench."""
    state, scratch, settings = kalman.state, kalman.scratch, kalman.settings
    n = kalman.places.reactions
    for i in range(n):
        scratch.estimated[i] = kalman.estimated[i] * settings.wrench_moves
    for i in range(n, n + 3):
        scratch.estimated[i] = kalman.estimated[i]
    for j in range(state.components):
        if state.alive[j // settings.modes] == 0.0:
            continue
        x, P, mode = state.x[j], state.P[j], j % settings.modes
        # The first wrench of a contact is linearised repeatedly, see `_correct_component`.
        scratch.product_covariance[j] = 0.0
        if not begins and settings.products > 0.0:
            fill_product_covariance(P, kalman.places, scratch.product_covariance[j])
        registry.begin_reactions(state.contact_set, x, P, n, reaction_variance(kalman))
        if isinf(settings.mode_time[mode]):
            reset_three(P, ACCELERATION, n + 3, settings.mode_stddev[mode] ** 2)
        copy_component(scratch.x[j], scratch.P[j], x, P, n + 3)


@compiled
def _take_back(kalman: FilterRecord) -> None:
    """Restore every component as it was before the wrench."""
    state, scratch = kalman.state, kalman.scratch
    for j in range(state.components):
        copy_component(state.x[j], state.P[j], scratch.x[j], scratch.P[j], state.width)


@compiled
def _correct_all(kalman: FilterRecord, dt: float, passes: int, wider: float) -> float:
    """Correct every component, with noise of a wider variance; return the mean of their NIS."""
    state, scratch, settings = kalman.state, kalman.scratch, kalman.settings
    nis, several = 0.0, state.alive.sum() > 1.5
    for j in range(state.components):
        scratch.log_likelihood[j] = 0.0
        if state.alive[j // settings.modes] == 0.0:
            continue
        log_likelihood, value = _correct_component(kalman, j, dt, passes, wider)
        nis += state.weight[j] * value
        scratch.log_likelihood[j] = log_likelihood
        if several:
            scratch.cholesky[:, :] = scratch.wrench_noise
            factor_cholesky(scratch.cholesky, 6)
            scratch.log_likelihood[j] += _log_volume(kalman)
            scratch.direction_noise_share[j] = _direction_noise_share(scratch)
    return nis


@compiled
def _correct_component(
    kalman: FilterRecord, j: int, dt: float, passes: int, wider: float
) -> tuple[float, float]:
    """
    Correct one component; return its log likelihood and NIS.

    The first wrench of a contact is linearised repeatedly, since the prior may be far off.
    """
    state, scratch, settings = kalman.state, kalman.scratch, kalman.settings
    scene, w, x, P = scene_of(kalman.scene), kalman.places.reactions + 3, state.x[j], state.P[j]
    middle = settings.mode_stddev[settings.modes // 2]
    mode_stddev = max(settings.mode_stddev[j % settings.modes], middle)
    if settings.sigma_points > 0.0 and passes == 1 and state.contact_set == ContactSet.THREE:
        log_likelihood, nis = correct_by_sigma_points(kalman, j, wider)
        _linearise_for_accuracies(kalman, j, mode_stddev)
        return log_likelihood, nis
    late = max(settings.direction_time / max(dt, WRENCH_STEP.least_time), 1.0)
    before, P_before = scratch.before, scratch.P_before
    if passes > 1:
        copy_component(before, P_before, x, P, w)
    log_likelihood, nis = 0.0, 0.0
    for k in range(passes):
        if k > 0:
            for a in range(w):
                for b in range(w):
                    P[a, b] = P_before[a, b]
        turned = registry.linearise(state.contact_set, kalman, scene, x, P, mode_stddev)
        add_product_noise(
            scratch.by_friction, scratch.product_covariance[j], scratch.direction_noise
        )
        least = keep_friction_floor(kalman, j, turned, max(x[FRICTION], scene.f))
        E, residual, R = scratch.jacobian, scratch.residual, scratch.noise
        for a in range(6):
            t = -residual[a]
            if k > 0:
                for b in range(w):
                    t -= E[a, b] * (before[b] - x[b])
            residual[a] = t
        scratch.wrench_noise[:, :] = R
        for a in range(6):
            for b in range(6):
                R[a, b] = wider * R[a, b] + late * scratch.direction_noise[a, b]
        log_likelihood, nis = update(kalman, scratch.estimated, P, w, 6, least)
        for a in range(w):
            x[a] = (before[a] if passes > 1 else x[a]) + scratch.step[a]
        x[FRICTION] = max(x[FRICTION], 0.0)
    if settings.particles > 0 and passes == 1 and state.contact_set == ContactSet.THREE:
        correct_by_particles(kalman, j, wider)
        _linearise_for_accuracies(kalman, j, mode_stddev)
    return log_likelihood, nis


@compiled
def _linearise_for_accuracies(kalman: FilterRecord, j: int, mode_stddev: float) -> None:
    """Leave the tangents of a component, which `follow_accuracies` needs, where points were."""
    if kalman.accuracies.stated != 0:
        state, scene = kalman.state, scene_of(kalman.scene)
        registry.linearise(state.contact_set, kalman, scene, state.x[j], state.P[j], mode_stddev)


@compiled
def _log_volume(kalman: FilterRecord) -> float:
    """
    Return the logarithm of the volume of wrenches, over their noise, that the reactions span.

    Reactions are new with every wrench, so that the evidence counts each time how much less of
    their wide prior a friction with more volume uses. Those of one motion are no such draws.
    """
    scratch, n = kalman.scratch, kalman.places.reactions
    column, rows, gram, total = scratch.step, scratch.whitened, scratch.gram, 0.0
    many = registry.solved_reactions(kalman.state.contact_set)
    for k in range(many):
        for a in range(6):
            column[a] = scratch.jacobian[a, n + k]
        whiten(scratch.cholesky, 6, column, rows[k])
        for m in range(k + 1):
            gram[k, m] = 0.0
            for a in range(6):
                gram[k, m] += rows[m, a] * rows[k, a]
    factor_cholesky(gram, many)
    for k in range(many):
        total += log(gram[k, k])
    return total


@compiled
def _direction_noise_share(scratch: Scratch) -> float:
    """Return how much friction of unknown direction weighs against the wrench's noise."""
    column, rows, white, total = scratch.step, scratch.whitened, scratch.white, 0.0
    # The trace of inv(L) N inv(L'), with L the Cholesky factor, by columns of both products.
    for k in range(6):
        whiten(scratch.cholesky, 6, scratch.direction_noise[k], rows[k])
    for k in range(6):
        for a in range(6):
            column[a] = rows[a, k]
        whiten(scratch.cholesky, 6, column, white)
        total += white[k]
    return total
