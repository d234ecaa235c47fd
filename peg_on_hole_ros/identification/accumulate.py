"""The estimator's run over a recording, compiled: what each measurement's likelihood was."""

from math import exp, log
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.contact_sets import three_on_rim
from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.mixture import combine, predict
from peg_on_hole_ros.estimator.orientation_update import (
    orientation_nis,
    pass_time,
    update_from_orientation,
)
from peg_on_hole_ros.estimator.scratch import Scratch
from peg_on_hole_ros.estimator.start import start_mixture
from peg_on_hole_ros.estimator.state import OPEN_BEGIN
from peg_on_hole_ros.estimator.tuned import WRENCH_STEP
from peg_on_hole_ros.estimator.update import reset_three
from peg_on_hole_ros.estimator.wrench_update import update_from_wrench
from peg_on_hole_ros.mechanics.kernel import compiled, scene_of
from peg_on_hole_ros.mechanics.linear_algebra import factor_cholesky, whiten

# What an event is. Orientations that do not count are used nevertheless.
BEGIN, UNCOUNTED, ORIENTATION, WRENCH = range(4)


class Events(NamedTuple):
    """
    What the sensors say, in the order of the stamps, of parts that each begin with an orientation.

    Attributes
    ----------
    t : ndarray, shape (n,)
        [s].
    kind : ndarray of int, shape (n,)
        BEGIN, ORIENTATION or WRENCH; UNCOUNTED orientations are used, and do not count.
    value : ndarray, shape (n, 6)
        gamma, psi, phi [rad]; or force and couple about the mass centre, peg axes [N], [N m].
    covariance : ndarray, shape (n, 3, 3)
        Of an orientation [rad^2].
    volume : ndarray, shape (n,)
        Logarithm of the volume of (gamma, psi, phi) in rotations: densities of angles that a tilt
        turns are not to be compared.

    """

    t: np.ndarray
    kind: np.ndarray
    value: np.ndarray
    covariance: np.ndarray
    volume: np.ndarray


class Found(NamedTuple):
    """
    What `accumulate` fills in, of each of n events.

    Attributes
    ----------
    log_likelihood : ndarray, shape (n,)
        Over the mixture, the logarithm of the mean of its components' likelihoods by their
        weights.
    nis : ndarray, shape (n,)
        Where an event counts.
    chosen : ndarray of int, shape (n,)
        Component whose innovation is given; below zero: the heaviest, which is filled in.
    residual, covariance : ndarray, shape (n, 6) and (n, 6, 6)
        Innovations; without rows: they are not filled in.

    """

    log_likelihood: np.ndarray
    nis: np.ndarray
    chosen: np.ndarray
    residual: np.ndarray
    covariance: np.ndarray


@compiled
def accumulate(kalman: FilterRecord, rate_stddev: float, events: Events, into: Found) -> None:
    """
    Run the estimator over all events, with everything known that is not its state.

    Parameters
    ----------
    kalman : FilterRecord
        Of one friction hypothesis, with nothing else open; with the noise of a wrench.
    rate_stddev : float
        At the begin of a part [rad/s].
    events : Events
    into : Found
        Filled.

    """
    state, scratch, modes = kalman.state, kalman.scratch, kalman.settings.modes
    weight, now = np.zeros(modes), events.t[0]
    for k in range(len(events.t)):
        kind, R, q = events.kind[k], events.covariance[k], events.value[k, :3]
        volume = events.volume[k]
        if kind == BEGIN:
            start_mixture(kalman, q, R, rate_stddev)
            now = events.t[k]
            continue
        dt = events.t[k] - now
        if dt > 0.0:
            now = events.t[k]
            predict(kalman, dt)
            pass_time(state, dt)
        for j in range(modes):
            weight[j] = state.weight[j]
        if into.chosen[k] < 0:
            into.chosen[k] = np.argmax(weight)
        if kind != WRENCH:
            _take_orientation(kalman, events, k, into)
        else:
            kalman.wrench[:] = events.value[k]
            if state.time_in_contact < 0.0:
                update_from_wrench(kalman, ContactSet.THREE.value)
                continue
            volume = _linearised_volume(kalman, k, into)
            update_from_wrench(kalman, ContactSet.THREE.value)
            volume -= 3.0 * log(kalman.settings.reaction_prior * state.load)
            into.nis[k] = state.nis_wrench
        if kind == UNCOUNTED:
            continue
        top = -1e300
        for j in range(modes):
            top = max(top, scratch.log_likelihood[j])
        total = 0.0
        for j in range(modes):
            total += weight[j] * exp(scratch.log_likelihood[j] - top)
        into.log_likelihood[k] = top + log(total) - volume


@compiled
def _take_orientation(kalman, events, k, into):
    """Correct by the orientation of an event, and fill in its innovation and its NIS."""
    q, R = events.value[k, :3], events.covariance[k]
    x, P = kalman.state.x[into.chosen[k]], kalman.state.P[into.chosen[k]]
    if len(into.residual) > 0:
        for i in range(3):
            into.residual[k, i] = q[i] - x[i]
            for j in range(3):
                into.covariance[k, i, j] = P[i, j] + R[i, j]
    if events.kind[k] == ORIENTATION:
        combine(kalman.state)
        into.nis[k] = orientation_nis(kalman, q, R)
    update_from_orientation(kalman, q, R)


@compiled
def _linearised_volume(kalman, k, into):
    """
    Linearise the six equations at a component, whose reactions are forgotten; return `_volume`.

    The innovation of the event is filled in.
    """
    x, P = kalman.state.x[into.chosen[k]], kalman.state.P[into.chosen[k]]
    prior = kalman.settings.reaction_prior * kalman.state.load
    reset_three(P, OPEN_BEGIN, OPEN_BEGIN + 3, prior * prior)
    three_on_rim.linearise(kalman, scene_of(kalman.scene), x, P, 0.0)
    if len(into.residual) > 0:
        _innovation(kalman, P, into.residual[k], into.covariance[k])
    return _volume(kalman.scratch, OPEN_BEGIN)


@compiled
def _innovation(kalman, P, residual, covariance):
    """Fill in residual and covariance of the six equations."""
    w, scratch = OPEN_BEGIN + 3, kalman.scratch
    direction_time = kalman.settings.direction_time
    since = max(kalman.state.time_since_wrench, WRENCH_STEP.least_time)
    late = max(direction_time / since, 1.0)
    for i in range(6):
        residual[i] = -scratch.residual[i]
        for j in range(6):
            t = scratch.noise[i, j] + late * scratch.direction_noise[i, j]
            for a in range(w):
                for b in range(w):
                    t += scratch.jacobian[i, a] * P[a, b] * scratch.jacobian[j, b]
            covariance[i, j] = t


@compiled
def _volume(scratch: Scratch, n: int) -> float:
    """
    Return what the density of six equations is of that of a wrench free of its reactions.

    Reactions are unknowns of each wrench. With the volume that they fill in it, the likelihood
    would favour what makes them uncertain: a friction or a bias that is wrong by far. What is left
    is the density of the three combinations of the wrench, in units of its noise, that no
    reaction changes (restricted likelihood; Patterson and Thompson, Biometrika 58, 1971).
    """
    factor, column, G = scratch.cholesky, scratch.step, scratch.whitened
    size = 0.0
    factor[:, :] = scratch.noise
    factor_cholesky(factor, 6)
    for i in range(6):
        size += log(factor[i, i])
    for k in range(3):
        for i in range(6):
            column[i] = scratch.jacobian[i, n + k]
        whiten(factor, 6, column, G[k])
    a, b, c, d, e, f = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(6):
        a += G[0, i] * G[0, i]
        b += G[1, i] * G[0, i]
        c += G[2, i] * G[0, i]
        d += G[1, i] * G[1, i]
        e += G[2, i] * G[1, i]
        f += G[2, i] * G[2, i]
    determinant = a * (d * f - e * e) - b * (b * f - c * e) + c * (b * e - c * d)
    return -size - 0.5 * log(determinant)
