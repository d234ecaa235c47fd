"""Kalman's update of one component by a linearised measurement."""

from math import log, sqrt

from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.state import FRICTION
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.linear_algebra import ROUNDING, factor_cholesky, whiten
from peg_on_hole_ros.typed_record import Floats


@compiled
def update(
    kalman: FilterRecord, estimated: Floats, P: Floats, w: int, k: int, least_friction: float
) -> tuple[float, float]:
    """
    Update a covariance by a residual r = E (truth - mean) + noise.

    Parameters
    ----------
    kalman : FilterRecord
        `scratch` has r in `residual` (k,), E in `jacobian` (k, w) and the covariance of the noise
        in `noise` (k, k); `cholesky`, `gain`, `white` and `step`, what is to be added to the mean,
        are filled.
    estimated : ndarray, shape (w,)
        1 for a value that is corrected; 0 for one that is only considered: it widens all others
        (Schmidt).
    P : ndarray, shape (w, w)
        Changed.
    w : int
        How many values there are.
    k : int
        How many residuals there are, at most 6.
    least_friction : float
        Floor of the variance of friction: below it, a part of the gain is taken back.

    Returns
    -------
    log_likelihood, nis : float

    """
    scratch = kalman.scratch
    E, R, gain, factor = scratch.jacobian, scratch.noise, scratch.gain, scratch.cholesky
    # Innermost loops go along rows, which compilers make vectors of.
    for a in range(k):
        row = gain[a]
        for i in range(w):
            row[i] = 0.0
        for j in range(w):
            slope = E[a, j]
            if slope != 0.0:
                for i in range(w):
                    row[i] += slope * P[j, i]
        for c in range(a + 1):
            t = R[a, c]
            for j in range(w):
                t += E[a, j] * gain[c, j]
            factor[a, c] = t
    return apply_gain(kalman, estimated, P, w, k, least_friction)


@compiled
def apply_gain(
    kalman: FilterRecord, estimated: Floats, P: Floats, w: int, k: int, least_friction: float
) -> tuple[float, float]:
    """
    Update a covariance by what it has in common with an innovation.

    Parameters
    ----------
    kalman : FilterRecord
        `scratch` has the innovation in `residual` (k,), its covariance in `cholesky` (k, k), of
        which the lower half is read, and its covariance with the values in `gain` (k, w); these
        and `white` and `step` are filled as by `update`.
    estimated, P, w, k, least_friction
        As for `update`.

    Returns
    -------
    log_likelihood, nis : float

    """
    scratch = kalman.scratch
    step, gain, factor, white = scratch.step, scratch.gain, scratch.cholesky, scratch.white
    factor_cholesky(factor, k)
    nis, log_root = whiten(factor, k, scratch.residual, white), 0.0
    for i in range(w):
        step[i] = 0.0
    for a in range(k):
        log_root += log(factor[a, a])
        row, over = gain[a], 1.0 / factor[a, a]
        for q in range(a):
            t, other = factor[a, q], gain[q]
            for i in range(w):
                row[i] -= t * other[i]
        for i in range(w):
            row[i] *= over
            step[i] += row[i] * white[a]
    for i in range(w):
        step[i] *= estimated[i]
        line, least = P[i], ROUNDING * P[i, i]
        for a in range(k):
            t, row = gain[a, i], gain[a]
            if estimated[i] > 0.0:
                for j in range(i + 1):
                    line[j] -= t * row[j]
            else:
                for j in range(i + 1):
                    line[j] -= estimated[j] * t * row[j]
        line[i] = max(line[i], least)
        for j in range(i):
            P[j, i] = line[j]
    if estimated[FRICTION] > 0.0:
        _keep_friction_floor(kalman, estimated, P, w, k, least_friction)
    return -0.5 * nis - log_root, nis


@compiled
def _keep_friction_floor(
    kalman: FilterRecord, estimated: Floats, P: Floats, w: int, k: int, least: float
) -> None:
    """Undo the part of friction's gain that has brought its variance below the floor."""
    gain = kalman.scratch.gain
    gained = 0.0
    for a in range(k):
        gained += gain[a, FRICTION] * gain[a, FRICTION]
    after = P[FRICTION, FRICTION]
    if after >= least or gained <= 0.0:
        return
    before, share = after + gained, 0.0
    if before > least:
        share = 1.0 - sqrt(max(1.0 - (before - least) / gained, 0.0))
    kalman.scratch.step[FRICTION] *= share
    P[FRICTION, FRICTION] = before - (2.0 * share - share * share) * gained
    for i in range(w):
        # With what is estimated, the full gain of that makes it depend on friction no less.
        if estimated[i] == 0.0:
            for a in range(k):
                P[FRICTION, i] += (1.0 - share) * gain[a, FRICTION] * gain[a, i]
            P[i, FRICTION] = P[FRICTION, i]


@compiled
def reset_three(P: Floats, first: int, w: int, variance: float) -> None:
    """Make three values from a place on independent of all w, each with a variance."""
    for i in range(first, first + 3):
        for j in range(w):
            P[i, j] = 0.0
            P[j, i] = 0.0
        P[i, i] = variance


@compiled
def copy_component(x: Floats, P: Floats, from_x: Floats, from_P: Floats, w: int) -> None:
    """Copy the first w values and their covariance."""
    for i in range(w):
        x[i] = from_x[i]
        for j in range(w):
            P[i, j] = from_P[i, j]
