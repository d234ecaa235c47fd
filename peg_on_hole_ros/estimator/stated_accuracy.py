"""
What stated accuracies make of the reactions, beside the filter, which does not learn them.

A gain that is off, a sensor that is turned or a peg that is thinner than stated moves the
reactions along their own columns of the six equations, so that no innovation shows it. Each source
is one error that lasts. It moves the reactions by the weighted least squares of the last wrench,
with friction as it is estimated. It moves friction by the mean over all wrenches that friction was
learnt from, each with the share by which it lessened the variance of friction.
"""

from math import cos, isfinite, sin, sqrt

import numpy as np

from peg_on_hole_ros.estimator.accuracy_record import (
    AXES,
    CROSSTALKS,
    DIAMETERS,
    GAINS,
    LAG,
    OF_FRICTION,
    PAYLOADS,
    PLACES,
    ROWS,
    SOURCES,
    TILTS,
    Accuracies,
    AccuracyScratch,
    Kind,
)
from peg_on_hole_ros.estimator.contact_sets import registry
from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.state import FRICTION
from peg_on_hole_ros.estimator.wrench_update import reaction_variance
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.linear_algebra import TORQUE, factor_cholesky

_KIND_OF = np.zeros(SOURCES, np.int64)
for _first, _kind in (
    (GAINS, Kind.GAIN),
    (CROSSTALKS, Kind.CROSSTALK),
    (PLACES, Kind.SENSOR_PLACE),
    (AXES, Kind.SENSOR_AXES),
    (PAYLOADS, Kind.PAYLOAD),
    (TILTS, Kind.ORIENTATION),
    (DIAMETERS, Kind.DIAMETER),
    (LAG, Kind.LOW_PASS),
):
    _KIND_OF[_first:] = _kind
# Half of the variance of a gain is common to all channels, as of an amplifier or a reference load.
_HALF = sqrt(0.5)


@compiled
def follow_accuracies(kalman: FilterRecord, friction_before: float) -> None:
    """
    Fill in what stated accuracies make of reactions and friction, after an update by a wrench.

    Parameters
    ----------
    kalman : FilterRecord
        `scratch` is as the update of a component left it; `record.accuracy` is filled in, and
        `friction_moved` goes on.
    friction_before : float
        `steady_friction_variance` before the update [-].

    """
    stated, found = kalman.accuracies, kalman.record.accuracy
    found.stated = stated.stated
    if stated.stated == 0:
        return
    found.by_kind[:, :] = 0.0
    many = registry.solved_reactions(kalman.state.contact_set)
    share = _friction_share(kalman, many > 0, friction_before)
    if many > 0:
        _fill_sensitivities(kalman, many)
        _fill_effects(kalman)
        _accumulate(kalman, many, share)
    found.friction = 0.0
    for j in range(SOURCES):
        found.friction += kalman.friction_moved[j] * kalman.friction_moved[j]
    for i in range(3):
        found.reactions[i] = 0.0
        for k in range(found.by_kind.shape[0]):
            found.reactions[i] += found.by_kind[k, i]


@compiled
def steady_friction_variance(kalman: FilterRecord) -> float:
    """
    Return the variance of friction in all modes but the top one, if there are several.

    In the top mode friction walks with every step, and each wrench takes that back: it corrects
    the friction of the mixture by none of it.
    """
    state, modes = kalman.state, kalman.settings.modes
    weight, mean, square = 0.0, 0.0, 0.0
    for j in range(state.components):
        if modes > 1 and j % modes == modes - 1:
            continue
        friction = state.x[j, FRICTION]
        weight += state.weight[j]
        mean += state.weight[j] * friction
        square += state.weight[j] * (state.P[j, FRICTION, FRICTION] + friction * friction)
    mean /= weight
    return max(square / weight - mean * mean, 0.0)


@compiled
def _friction_share(kalman: FilterRecord, in_contact: bool, before: float) -> float:
    """
    Return the share by which this wrench has corrected friction, by its variance before and after.

    The variance rises and falls as hypotheses drift apart and are given up: it counts where it is
    less than ever.
    """
    after = steady_friction_variance(kalman)
    kalman.friction_least += max(before - kalman.friction_variance, 0.0)
    kalman.friction_variance = after
    learnt = kalman.friction_open and kalman.estimated[FRICTION] > 0.0
    if not in_contact or not learnt:
        return 0.0
    least, kalman.friction_least = kalman.friction_least, min(after, kalman.friction_least)
    return 1.0 - after / least if 0.0 < after < least else 0.0


@compiled
def _fill_sensitivities(kalman: FilterRecord, many: int) -> None:
    """Fill in the derivatives of reactions and friction by errors of residual and wrench."""
    work = kalman.scratch.accuracy
    white, gram, over, solved = work.white, work.gram, work.over, work.solved
    _whiten_columns(kalman)
    for k in range(many):
        for m in range(k + 1):
            gram[k, m] = 0.0
            for i in range(6):
                gram[k, m] += white[k, i] * white[m, i]
        gram[k, k] += 1.0 / reaction_variance(kalman)
    _invert(work, many)
    for k in range(3):
        work.by_friction[k] = 0.0
        for i in range(6):
            solved[k, i] = 0.0
            for m in range(many if k < many else 0):
                solved[k, i] += over[k, m] * white[m, i]
            work.by_friction[k] += solved[k, i] * white[OF_FRICTION, i]
    _solve_friction(work, many)
    _whiten_back(work)
    _pass_on(kalman.scratch.applied_jacobian[:, 3:9], work.by_residual, work.by_wrench, 0)
    _pass_on(kalman.accuracies.sensor_map, work.by_wrench, work.by_sensor, 3)


@compiled
def _whiten_columns(kalman: FilterRecord) -> None:
    """Fill in the columns of reactions and friction, whitened by the noise of the residual."""
    work, scratch, n = kalman.scratch.accuracy, kalman.scratch, kalman.places.reactions
    factor, white, E = work.factor, work.white, scratch.jacobian
    for i in range(6):
        for j in range(i + 1):
            factor[i, j] = scratch.noise[i, j]
    factor_cholesky(factor, 6)
    for a in range(6):
        work.over_pivot[a] = 1.0 / factor[a, a]
        for k in range(ROWS):
            t = E[a, FRICTION if k == OF_FRICTION else n + k]
            for q in range(a):
                t -= factor[a, q] * white[k, q]
            white[k, a] = t * work.over_pivot[a]


@compiled
def _solve_friction(work: AccuracyScratch, many: int) -> None:
    """Fill in the row of friction: what of its column the reactions do not explain."""
    row, told = work.solved[OF_FRICTION], 0.0
    for i in range(6):
        row[i] = work.white[OF_FRICTION, i]
        for k in range(many):
            row[i] -= work.by_friction[k] * work.white[k, i]
        told += row[i] * row[i]
    over = 1.0 / told if told > 0.0 else 0.0
    for i in range(6):
        row[i] *= over


@compiled
def _invert(work: AccuracyScratch, many: int) -> None:
    """Fill in the inverse of `gram`, of whose size `many` rows count."""
    gram, over = work.gram, work.over
    factor_cholesky(gram, many)
    # The inverse of the factor, then its product with itself.
    for j in range(many):
        for i in range(j, many):
            t = 1.0 if i == j else 0.0
            for q in range(j, i):
                t -= gram[i, q] * over[q, j]
            over[i, j] = t / gram[i, i]
    for i in range(many):
        for j in range(i + 1):
            t = 0.0
            for q in range(i, many):
                t += over[q, i] * over[q, j]
            over[i, j] = t
        for j in range(i):
            over[j, i] = over[i, j]


@compiled
def _whiten_back(work: AccuracyScratch) -> None:
    """Fill in `by_residual` by what is `solved` of whitened residuals."""
    out, factor, solved = work.by_residual, work.factor, work.solved
    for i in range(5, -1, -1):
        for k in range(ROWS):
            t = solved[k, i]
            for q in range(i + 1, 6):
                t -= factor[q, i] * out[k, q]
            out[k, i] = t * work.over_pivot[i]


@compiled
def _pass_on(matrix: np.ndarray, rows: np.ndarray, out: np.ndarray, lower: int) -> None:
    """Fill in rows times a matrix, of which columns from `lower` on begin with so many zeros."""
    for k in range(ROWS):
        for j in range(6):
            t = 0.0
            for i in range(lower if j >= 3 else 0, 6):
                t += rows[k, i] * matrix[i, j]
            out[k, j] = t


@compiled
def _fill_effects(kalman: FilterRecord) -> None:
    """Fill in what one standard deviation of each source makes of reactions and friction."""
    stated, scratch = kalman.accuracies, kalman.scratch
    work = scratch.accuracy
    _fill_channels(stated, work)
    _fill_pose(stated, work)
    if stated.payload_kg > 0.0:
        _fill_payload(stated, work)
    x, E, places = kalman.state.mixture_mean, scratch.jacobian, kalman.places
    # What is stated of tilt and clearance themselves takes the place of what they come from.
    tilt = stated.orientation if places.tilt < 0 else 0.0
    across = tilt / max(sin(x[0]), 1e-6)
    diameter = _clearance_off(kalman) if places.clearance < 0 else 0.0
    for k in range(ROWS):
        along, turned, thicker = 0.0, 0.0, 0.0
        for i in range(6):
            by = work.by_residual[k, i]
            along += by * E[i, 0]
            turned += by * (E[i, 1] - cos(x[0]) * E[i, 2])
            thicker += by * scratch.by_diameter[i]
        work.effect[TILTS, k] = tilt * along
        work.effect[TILTS + 1, k] = across * turned
        work.effect[DIAMETERS, k] = diameter * thicker


@compiled
def _clearance_off(kalman: FilterRecord) -> float:
    """Return what the clearance may be off by: both diameters, and contacts that give [m]."""
    stated, gives = kalman.accuracies, 0.0
    if kalman.places.compliance < 0:
        # Where K and B press in on either side, the peg has that much more room.
        for i in range(kalman.places.reactions, kalman.places.reactions + 3):
            gives += stated.compliance * max(kalman.state.mixture_mean[i], 0.0)
    return sqrt(2.0 * stated.diameter * stated.diameter + gives * gives)


@compiled
def _fill_channels(stated: Accuracies, work: AccuracyScratch) -> None:
    """Fill in the effects of gains, crosstalk and lag, channel by channel of the sensor."""
    load, by = stated.load, work.by_sensor
    own = _HALF * stated.gain
    for k in range(ROWS):
        work.effect[GAINS + 6, k] = work.effect[LAG, k] = 0.0
    for i in range(6):
        first = 0 if i < 3 else 3
        others = 0.0
        for j in range(first, first + 3):
            others += load[j] * load[j] if j != i else 0.0
        spoken = stated.crosstalk * sqrt(others)
        for k in range(ROWS):
            work.effect[GAINS + i, k] = own * load[i] * by[k, i]
            work.effect[GAINS + 6, k] += own * load[i] * by[k, i]
            work.effect[CROSSTALKS + i, k] = spoken * by[k, i]
            work.effect[LAG, k] += stated.behind[i] * by[k, i]


@compiled
def _fill_pose(stated: Accuracies, work: AccuracyScratch) -> None:
    """Fill in the effects of the sensor's place and axes."""
    load, by, turn = stated.load, work.by_sensor, stated.sensor_axes
    M = stated.sensor_map
    F_x = M[0, 0] * load[0] + M[0, 1] * load[1] + M[0, 2] * load[2]
    F_y = M[1, 0] * load[0] + M[1, 1] * load[1] + M[1, 2] * load[2]
    F_z = M[2, 0] * load[0] + M[2, 1] * load[1] + M[2, 2] * load[2]
    for k in range(ROWS):
        _fill_moments(work, k, PLACES, stated.sensor_place, (F_x, F_y, F_z))
        for i in range(3):
            j, m = (i + 1) % 3, (i + 2) % 3
            # A turn about an axis: e_i x v has v_j in place m, and -v_m in place j.
            turned = by[k, m] * load[j] - by[k, j] * load[m]
            turned += by[k, TORQUE + m] * load[TORQUE + j]
            turned -= by[k, TORQUE + j] * load[TORQUE + m]
            work.effect[AXES + i, k] = turn * turned


@compiled
def _fill_payload(stated: Accuracies, work: AccuracyScratch) -> None:
    """Fill in the effects of mass and place of the payload."""
    w, r, by = stated.weight, stated.payload_arm, work.by_wrench
    for k in range(ROWS):
        heavier = by[k, 0] * w[0] + by[k, 1] * w[1] + by[k, 2] * w[2]
        heavier += by[k, 3] * (r[1] * w[2] - r[2] * w[1])
        heavier += by[k, 4] * (r[2] * w[0] - r[0] * w[2])
        heavier += by[k, 5] * (r[0] * w[1] - r[1] * w[0])
        work.effect[PAYLOADS, k] = stated.payload_mass * heavier
        _fill_moments(work, k, PAYLOADS + 1, stated.payload_place, (w[0], w[1], w[2]))


@compiled
def _fill_moments(
    work: AccuracyScratch, k: int, first: int, moved: float, force: tuple[float, float, float]
) -> None:
    """Fill in the effects of a force that is moved along each axis of the peg [m], [N]."""
    F_x, F_y, F_z = force
    m_x, m_y, m_z = work.by_wrench[k, 3], work.by_wrench[k, 4], work.by_wrench[k, 5]
    work.effect[first, k] = moved * (m_z * F_y - m_y * F_z)
    work.effect[first + 1, k] = moved * (m_x * F_z - m_z * F_x)
    work.effect[first + 2, k] = moved * (m_y * F_x - m_x * F_y)


@compiled
def _accumulate(kalman: FilterRecord, many: int, share: float) -> None:
    """Let friction follow each source by a share, and add up what becomes of the reactions."""
    work, moved = kalman.scratch.accuracy, kalman.friction_moved
    found = kalman.record.accuracy.by_kind
    for j in range(SOURCES):
        if kalman.accuracies.payload_kg == 0.0 and PAYLOADS <= j < TILTS:
            continue
        kind, effect = _KIND_OF[j], work.effect[j]
        followed = moved[j] + share * (effect[OF_FRICTION] - moved[j])
        # One wrench that says nothing is not to stay for good.
        moved[j] = followed if isfinite(followed) else moved[j]
        K = effect[0] - work.by_friction[0] * moved[j]
        B1 = effect[1] - work.by_friction[1] * moved[j]
        B2 = effect[2] - work.by_friction[2] * moved[j]
        if many == 2:
            # N_B stands as two halves.
            B1 = B2 = 0.5 * B1
        found[kind, 0] += K * K
        found[kind, 1] += B1 * B1
        found[kind, 2] += B2 * B2
