"""What an orientation and a wrench make of the state: the compiled step."""

from math import log, sqrt

import numpy as np

from peg_on_hole_ros.estimator.contact import straighten
from peg_on_hole_ros.estimator.direction import add_product, product_covariance
from peg_on_hole_ros.estimator.free import LEAST_STEP
from peg_on_hole_ros.estimator.mixture import (
    combine,
    friction_told,
    keep_friction_force,
    merge,
    reweigh,
)
from peg_on_hole_ros.estimator.motion import drive
from peg_on_hole_ros.estimator.state import (
    ACCELERATION,
    DELAY,
    FRICTION,
    FRICTION_K,
    OPEN,
    RATE,
    TILT,
)
from peg_on_hole_ros.estimator.two_points import straighten_two_points
from peg_on_hole_ros.estimator.update import (
    lower_root,
    orientation_residual,
    orientation_slopes,
    over_root,
    update,
)
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled
from peg_on_hole_ros.record_types import ScratchRecord, SettingsRecord, StateRecord

_GRAVITY = 9.81
_EQUATIONS = 6.0


@compiled
def _untold(o):
    """Return the deviation of accelerations that no wrench has told of [rad/s^2]."""
    return min(o.level[max(o.levels - 2, 0)], 1.0 / o.settling)


@compiled
def start(
    s: StateRecord, scratch: ScratchRecord, o: SettingsRecord, at: np.ndarray, n: int,
    q: np.ndarray, R: np.ndarray, rate_stddev: float, friction: float, friction_stddev: float,
    open_mean: np.ndarray, open_stddev: np.ndarray,
) -> None:  # fmt: skip
    """
    Start from an orientation, at unknown rates.

    Parameters
    ----------
    s : record of STATE
        Filled.
    scratch : record of SCRATCH
    o : record of SETTINGS
    at : ndarray, shape (6,)
    n : int
    q : ndarray, shape (3,)
        gamma, psi, phi [rad].
    R : ndarray, shape (3, 3)
        Their covariance [rad^2].
    rate_stddev : float
        [rad/s].
    friction, friction_stddev : float
        As stated.
    open_mean, open_stddev : ndarray, shape (n - 10,)
        Of what else is open.

    """
    levels, frictions = o.levels, s.frictions
    spacing = 2.0 * o.reach / max(frictions - 1, 1)
    total = 0.0
    for g in range(frictions):
        off = -o.reach + g * spacing if frictions > 1 else 0.0
        f = max(friction + off * friction_stddev, 0.0)
        # One without friction is a peg as well, where no other is left.
        s.alive[g] = 1.0 if f > 0.0 or g == frictions - 1 else 0.0
        own = np.exp(-0.5 * off * off) * s.alive[g]
        wide = (0.5 * spacing if frictions > 1 else 1.0) * friction_stddev
        shut = levels > 1 and frictions > 1 and o.top_waits > 0.0
        for j in range(g * levels, g * levels + levels):
            s.weight[j] = own / levels
            if shut and j == g * levels + levels - 1:
                s.weight[j] = 1e-9 * own
            total += s.weight[j]
            x, P = s.x[j], s.P[j]
            for i in range(n + 3):
                x[i] = 0.0
                for k in range(n + 3):
                    P[i, k] = 0.0
            for i in range(3):
                x[i] = q[i]
                for k in range(3):
                    P[i, k] = R[i, k]
                P[RATE + i, RATE + i] = rate_stddev * rate_stddev
                P[ACCELERATION + i, ACCELERATION + i] = _untold(o) ** 2
            x[FRICTION], P[FRICTION, FRICTION] = f, wide * wide
            for i in range(OPEN, n):
                x[i], P[i, i] = open_mean[i - OPEN], open_stddev[i - OPEN] ** 2
            _share_offsets(x, P, scratch, at, n, q)
    for j in range(levels * frictions):
        s.weight[j] /= total
    s.told[0], s.load[0] = 1.0, 0.0
    s.since[0], s.since[1] = 0.0, -1.0
    s.step[0] = s.oriented[0] = 0.0
    s.air[:, :] = 0.0
    s.start_rates2[0] = rate_stddev * rate_stddev
    s.nis[:] = np.nan
    s.innovation_before[:] = np.nan
    s.orientations[:, :] = np.nan
    combine(s, n)


@compiled
def _share_offsets(x, P, scratch, at, n, q):
    """Let the angles at a start be as uncertain as tilt and delay leave them."""
    E = scratch.E
    for place, width in ((at[TILT], 2), (at[DELAY], 1)):
        if place < 0:
            continue
        orientation_slopes(x, at, n, E)
        for i in range(3):
            for k in range(3):
                for j in range(place, place + width):
                    P[i, k] += E[i, j] * P[j, j] * E[k, j]
            for j in range(place, place + width):
                P[i, j] = -E[i, j] * P[j, j]
                P[j, i] = P[i, j]
        if place == at[DELAY]:
            for i in range(3):
                P[i, i] += P[RATE + i, RATE + i] * P[place, place]
    orientation_slopes(x, at, n, E)
    orientation_residual(x, at, q, E, scratch.residual)
    for i in range(3):
        x[i] += scratch.residual[i]


@compiled
def pass_time(s: StateRecord, dt: float) -> None:
    """Take note of a time that has been predicted [s]."""
    s.since[0] += dt
    s.step[0] += dt
    s.oriented[0] += dt
    s.jumped[0] += dt


@compiled
def expect(
    s: StateRecord, scratch: ScratchRecord, at: np.ndarray, q: np.ndarray, R: np.ndarray
) -> float:
    """
    Return the normalised innovation squared of an orientation; nothing is corrected.

    The innovation over the lower root of its covariance is left in the state.
    """
    s.nis[0] = _innovation(s.mean, s.covariance, s, scratch, at, q, R, s.innovation)
    return s.nis[0]


@compiled
def departs_further(s: StateRecord, scratch: ScratchRecord, R: np.ndarray) -> bool:
    """
    Keep how far off the orientation is that `expect` has looked at, with covariance R [rad^2].

    Returns whether it is further off than the one kept before, and the same way: one motion makes
    that of both, while outliers do not agree.
    """
    root, now = R.copy(), scratch.white
    lower_root(root, 3)
    over_root(root, 3, scratch.residual, now)
    grown = 0.0
    for i in range(3):
        grown += (now[i] - s.departed[i]) * s.departed[i]
        s.departed[i] = now[i]
    return grown >= 0.0


@compiled
def jump_to(
    s: StateRecord, scratch: ScratchRecord, o: SettingsRecord, at: np.ndarray, q: np.ndarray,
    R: np.ndarray, most: float,
) -> bool:  # fmt: skip
    """
    Let the motion have been on the top level since the last orientation, if that explains one.

    Wrenches in between have taken a lower level for granted, and closed the top one. What departs
    more often than the top level comes is no jump: something is stated wrongly.

    Parameters
    ----------
    s, scratch, o, at, q, R
        As for `start`; every component is widened, where it jumps.
    most : float
        Normalised innovation squared up to which the orientation is explained.

    """
    top, x, P = o.levels - 1, scratch.x[0], scratch.P[0]
    if o.up[top] == 0.0 or jumped_lately(s, o):
        return False
    copy(x, P, s.mean, s.covariance, s.width)
    drive(x, P, s.oriented[0], o.level[top], o.time[top], o.around_axes)
    if _innovation(x, P, s, scratch, at, q, R, scratch.white) > most:
        return False
    for j in range(s.components):
        if s.alive[j // o.levels] > 0.0:
            drive(s.x[j], s.P[j], s.oriented[0], o.level[top], o.time[top], o.around_axes)
    s.jumped[0] = 0.0
    return True


@compiled
def jumped_lately(s: StateRecord, o: SettingsRecord) -> bool:
    """Return whether the motion has jumped within the time in which the top level comes once."""
    often = o.up[o.levels - 1]
    return often > 0.0 and s.jumped[0] * often < 1.0


@compiled
def _innovation(x, P, s, scratch, at, q, R, white):
    """Fill in an orientation's innovation over the root of its covariance; return its square."""
    E, residual, root, w = scratch.E, scratch.residual, scratch.root, s.width
    orientation_slopes(x, at, w, E)
    orientation_residual(x, at, q, E, residual)
    for i in range(3):
        for k in range(w):
            t = 0.0
            for l in range(w):
                t += E[i, l] * P[l, k]
            scratch.gain[i, k] = t
        for k in range(i + 1):
            v = s.noise[0] * R[i, k]
            for l in range(w):
                v += scratch.gain[i, l] * E[k, l]
            root[i, k] = v
    lower_root(root, 3)
    return over_root(root, 3, residual, white)


@compiled
def orient(
    s: StateRecord, scratch: ScratchRecord, o: SettingsRecord, at: np.ndarray, n: int,
    learnt: np.ndarray, q: np.ndarray, R: np.ndarray,
) -> None:  # fmt: skip
    """Correct every component by an orientation q [rad] with covariance R [rad^2]."""
    levels, noise = o.levels, scratch.R
    s.oriented[0] = 0.0
    for i in range(3):
        for k in range(3):
            noise[i, k] = s.noise[0] * R[i, k]
    for j in range(s.components):
        scratch.log_likelihood[j] = 0.0
        if s.alive[j // levels] == 0.0:
            continue
        x = s.x[j]
        orientation_slopes(x, at, n, scratch.E)
        orientation_residual(x, at, q, scratch.E, scratch.residual)
        scratch.log_likelihood[j], _ = update(
            s.P[j], n, learnt, 0.0, scratch.residual, scratch.E, noise, 3,
            scratch.root, scratch.gain, scratch.white, scratch.step,
        )  # fmt: skip
        for i in range(n):
            x[i] += scratch.step[i]
        x[FRICTION] = max(x[FRICTION], 0.0)
    reweigh(s, scratch, o)


@compiled
def load_of(p: SceneScalars, u: np.ndarray) -> float:
    """Return how much the rim may carry: what a wrench and the weight can amount to there [N]."""
    force = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2])
    couple = sqrt(u[3] * u[3] + u[4] * u[4] + u[5] * u[5])
    return force + 2.0 * couple / p.d + p.m * _GRAVITY


@compiled
def weigh(
    s: StateRecord, scratch: ScratchRecord, o: SettingsRecord, p: SceneScalars, at: np.ndarray,
    n: int, learnt: np.ndarray, u: np.ndarray, noise: np.ndarray, bias_map: np.ndarray,
    contacts: int,
) -> None:  # fmt: skip
    """
    Take a wrench: correct every component by the equations of the contacts that carry.

    Parameters
    ----------
    s : record of STATE
        Changed; mean and covariance are filled in.
    scratch : record of SCRATCH
    o : record of SETTINGS
    p : SceneScalars
    at : ndarray, shape (6,)
    n : int
    learnt : ndarray, shape (n + 3,)
        See `update`.
    u : ndarray, shape (6,)
        On the peg about its mass centre, peg axes [N], [N m].
    noise, bias_map : ndarray, shape (6, 6)
        See `straighten`.
    contacts : int
        How many carry: 3, 2 for K and B in the hole, or 0 for a peg that hangs free; below zero:
        not told.

    """
    dt = s.step[0]
    s.step[0] = 0.0
    s.load[0] = load_of(p, u)
    s.nis[1] = np.nan
    prior = (o.reaction_prior * s.load[0]) ** 2
    if contacts == 2 and np.isinf(o.time[0]):
        # A motion that the wrench drives is that of three contacts.
        contacts = -1
    s.contacts[0] = contacts
    if contacts < 2 or s.since[0] < o.settling or _drifts(s, o):
        s.since[1], s.contacts[0] = -1.0, 0.0
        for j in range(s.components):
            for i in range(n, n + 3):
                s.x[j, i] = 0.0
            _forget(s.P[j], n, n, prior)
            if np.isinf(o.time[j % o.levels]):
                _forget(s.P[j], ACCELERATION, n, _untold(o) ** 2)
        combine(s, n)
        return
    begins = s.since[1] < 0.0
    s.since[1] = 0.0 if begins else s.since[1] + dt
    if begins:
        for i in range(3):
            s.friction_force2[i] = (s.mean[FRICTION] * s.load[0]) ** 2
    several = s.alive.sum() > 1.5
    _forget_reactions(s, scratch, o, at, n, prior, begins)
    nis = _correct_all(
        s, scratch, o, p, at, n, learnt, u, noise, bias_map, dt, o.passes if begins else 1, 1.0
    )  # fmt: skip
    misfit = nis > o.outlier * _EQUATIONS and not begins
    s.spiked[0] = s.spiked[0] + 1.0 if misfit else 0.0
    if s.spiked[0] == 1.0:
        for j in range(s.components):
            copy(s.x[j], s.P[j], scratch.x[j], scratch.P[j], n + 3)
        _correct_all(
            s, scratch, o, p, at, n, learnt, u, noise, bias_map, dt, 1, nis / _EQUATIONS
        )  # fmt: skip
    s.nis[1] = nis
    if several:
        friction_told(s, scratch, o, max(dt, LEAST_STEP))
    reweigh(s, scratch, o)
    if several:
        merge(s, o)
    combine(s, n)
    keep_friction_force(s, n)


@compiled
def copy(x: np.ndarray, P: np.ndarray, from_x: np.ndarray, from_P: np.ndarray, w: int) -> None:
    """Copy the first w values and their covariance."""
    for i in range(w):
        x[i] = from_x[i]
        for j in range(w):
            P[i, j] = from_P[i, j]


@compiled
def _forget_reactions(s, scratch, o, at, n, prior, begins):
    """Begin reactions anew, and keep every component as it is before the wrench."""
    levels = o.levels
    for j in range(s.components):
        if s.alive[j // levels] == 0.0:
            continue
        # The first wrench of a contact is straightened until it is its own.
        scratch.product[j] = 0.0
        if not begins and o.products > 0.0:
            product_covariance(s.P[j], n, at[FRICTION_K], scratch.product[j])
        _forget(s.P[j], n, n, prior)
        if s.contacts[0] == 2.0:
            _halve(s.x[j], s.P[j], n, prior)
        if np.isinf(o.time[j % levels]):
            _forget(s.P[j], ACCELERATION, n, o.level[j % levels] ** 2)
        copy(scratch.x[j], scratch.P[j], s.x[j], s.P[j], n + 3)


@compiled
def _halve(x, P, n, prior):
    """Let N_B1 and N_B2 be halves of one reaction."""
    x[n + 1] = x[n + 2] = 0.5 * (x[n + 1] + x[n + 2])
    for i in range(n + 1, n + 3):
        P[i, n + 1] = P[i, n + 2] = 0.25 * prior


@compiled
def _correct_all(
    s, scratch, o, p, at, n, learnt, u, noise, bias_map, dt, passes, wider,
):  # fmt: skip
    """Correct every component, with noise of a wider variance; return the mean of their NIS."""
    levels, nis, several = o.levels, 0.0, s.alive.sum() > 1.5
    for j in range(s.components):
        scratch.log_likelihood[j] = 0.0
        if s.alive[j // levels] == 0.0:
            continue
        value = _by_equations(
            s.x[j], s.P[j], scratch.product[j], s, scratch, o, p, at, n, learnt, u, noise,
            bias_map, dt, passes, wider, max(o.level[j % levels], o.level[o.levels // 2]),
        )  # fmt: skip
        nis += s.weight[j] * value
        scratch.log_likelihood[j] = scratch.evidence_of_wrench[0]
        if several:
            scratch.root[:, :] = scratch.known
            lower_root(scratch.root, 6)
            scratch.log_likelihood[j] += _log_volume(s, scratch, n)
            scratch.doubt[j] = _relative_doubt(scratch)
    return nis


@compiled
def _drifts(s, o):
    """Return whether the tilt's rate is known less than at a start: no slip has a direction."""
    return np.isfinite(o.time[0]) and s.covariance[RATE, RATE] > s.start_rates2[0]


@compiled
def _forget(P, first, n, prior):
    """Take three values from a place on as new, with a variance."""
    for i in range(first, first + 3):
        for j in range(n + 3):
            P[i, j] = 0.0
            P[j, i] = 0.0
        P[i, i] = prior


@compiled
def _by_equations(
    x, P, product, s, scratch, o, p, at, n, learnt, u, noise, bias_map, dt, passes, wider, level,
):  # fmt: skip
    """Correct one component; the equations are straightened again where the prior was far off."""
    w = n + 3
    late = max(o.direction_time / max(dt, LEAST_STEP), 1.0)
    before, P_before = scratch.before, scratch.P_before
    if passes > 1:
        copy(before, P_before, x, P, w)
    nis = 0.0
    for k in range(passes):
        if k > 0:
            for a in range(w):
                for b in range(w):
                    P[a, b] = P_before[a, b]
        if s.contacts[0] == 2.0:
            turned = straighten_two_points(
                p, x, P, n, at, u, noise, bias_map, s.load[0], o.direction_share, o.inertia,
                level, s.friction_force2, scratch,
            )  # fmt: skip
        else:
            turned = straighten(
                p, x, P, n, at, u, noise, bias_map, s.load[0], o.direction_share, o.inertia,
                s.friction_force2, scratch,
            )  # fmt: skip
        add_product(scratch.by_friction, product, scratch.unknown)
        # Friction is learnt no better than to what a slip elsewhere would make of it.
        least = (turned * max(x[FRICTION], p.f)) ** 2
        E, residual, R = scratch.E, scratch.residual, scratch.R
        for a in range(6):
            t = -residual[a]
            if k > 0:
                for b in range(w):
                    t -= E[a, b] * (before[b] - x[b])
            residual[a] = t
        scratch.known[:, :] = R
        for a in range(6):
            for b in range(6):
                R[a, b] = wider * R[a, b] + late * scratch.unknown[a, b]
        scratch.evidence_of_wrench[0], nis = update(
            P, w, learnt, least, residual, E, R, 6,
            scratch.root, scratch.gain, scratch.white, scratch.step,
        )  # fmt: skip
        for a in range(w):
            x[a] = (before[a] if passes > 1 else x[a]) + scratch.step[a]
        x[FRICTION] = max(x[FRICTION], 0.0)
    return nis


@compiled
def _log_volume(s, scratch, n):
    """
    Return the logarithm of the volume of wrenches, over their noise, that the reactions span.

    Reactions are new with every wrench, so that the evidence counts each time how much less of
    their wide prior a friction with more volume uses. Those of one motion are no such draws.
    """
    column, rows, total = scratch.step, scratch.columns, 0.0
    gram, many = scratch.columns[3:], 2 if s.contacts[0] == 2.0 else 3
    for k in range(many):
        for a in range(6):
            column[a] = scratch.E[a, n + k]
        over_root(scratch.root, 6, column, rows[k])
        for m in range(k + 1):
            gram[k, m] = 0.0
            for a in range(6):
                gram[k, m] += rows[m, a] * rows[k, a]
    lower_root(gram, many)
    for k in range(many):
        total += log(gram[k, k])
    return total


@compiled
def _relative_doubt(scratch):
    """Return how much friction of unknown direction weighs against the wrench's noise."""
    column, rows, white, total = scratch.step, scratch.columns, scratch.white, 0.0
    # The trace of inv(root) unknown inv(root'), by columns of both products.
    for k in range(6):
        over_root(scratch.root, 6, scratch.unknown[k], rows[k])
    for k in range(6):
        for a in range(6):
            column[a] = rows[a, k]
        over_root(scratch.root, 6, column, white)
        total += white[k]
    return total
