"""The estimator's run over a recording, compiled: what each measurement's likelihood was."""

from math import exp, log
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimator import step
from peg_on_hole_ros.estimator.contact import straighten
from peg_on_hole_ros.estimator.mixture import predict
from peg_on_hole_ros.estimator.state import OPEN
from peg_on_hole_ros.estimator.update import lower_root
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled
from peg_on_hole_ros.record_types import ScratchRecord, SettingsRecord, StateRecord

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


@compiled
def accumulate(
    s: StateRecord, scratch: ScratchRecord, o: SettingsRecord, p: SceneScalars, at: np.ndarray,
    learnt: np.ndarray, walk: np.ndarray, rate_stddev: float, noise: np.ndarray, events: Events,
    found: np.ndarray, nis: np.ndarray, chosen: np.ndarray, residual: np.ndarray,
    covariance: np.ndarray,
) -> None:  # fmt: skip
    """
    Run the estimator over all events, with everything known that is not its state.

    Parameters
    ----------
    s : record of STATE
        Filled; of one friction, with nothing else open.
    scratch : record of SCRATCH
    o : record of SETTINGS
    p : SceneScalars
    at, learnt, walk : ndarray
        See `weigh` and `move_on`.
    rate_stddev : float
        At the begin of a part [rad/s].
    noise : ndarray, shape (6, 6)
        Of a wrench on the peg.
    events : Events
    found : ndarray, shape (n,)
        Filled with log likelihoods: over the mixture, the logarithm of the mean of its
        components' likelihoods by their weights.
    nis : ndarray, shape (n,)
        Filled where an event counts.
    chosen : ndarray of int, shape (n,)
        Component whose innovation is given; below zero: the heaviest, which is filled in.
    residual, covariance : ndarray, shape (n, 6) and (n, 6, 6)
        Filled with innovations; without rows: not.

    """
    n, levels = OPEN, o.levels
    none, no_map = np.zeros(0), np.zeros((6, 6))
    weight = np.zeros(levels)
    now = events.t[0]
    detailed = len(residual) > 0
    for k in range(len(events.t)):
        kind, R, q = events.kind[k], events.covariance[k], events.value[k, :3]
        volume = events.volume[k]
        if kind == BEGIN:
            step.start(s, scratch, o, at, n, q, R, rate_stddev, p.f, 0.0, none, none)
            now = events.t[k]
            continue
        dt = events.t[k] - now
        if dt > 0.0:
            now = events.t[k]
            predict(s, scratch, o, walk, n, dt)
            step.pass_time(s, dt)
        for j in range(levels):
            weight[j] = s.weight[j]
        if chosen[k] < 0:
            chosen[k] = np.argmax(weight)
        x, P = s.x[chosen[k]], s.P[chosen[k]]
        if kind != WRENCH:
            if detailed:
                for i in range(3):
                    residual[k, i] = q[i] - x[i]
                    for j in range(3):
                        covariance[k, i, j] = P[i, j] + R[i, j]
            if kind == ORIENTATION:
                step.combine(s, n)
                nis[k] = step.expect(s, scratch, at, q, R)
            step.orient(s, scratch, o, at, n, learnt, q, R)
        else:
            u = events.value[k]
            begins = s.since[1] < 0.0
            if begins:
                step.weigh(s, scratch, o, p, at, n, learnt, u, noise, no_map, 3)
                continue
            prior = o.reaction_prior * s.load[0]
            _straighten(s, scratch, o, p, at, x, P, u, noise, no_map, prior)
            if detailed:
                _innovation(s, scratch, o, P, residual[k], covariance[k])
            volume = _volume(scratch, n)
            step.weigh(s, scratch, o, p, at, n, learnt, u, noise, no_map, 3)
            volume -= 3.0 * log(o.reaction_prior * s.load[0])
            nis[k] = s.nis[1]
        if kind == UNCOUNTED:
            continue
        top = -1e300
        for j in range(levels):
            top = max(top, scratch.log_likelihood[j])
        total = 0.0
        for j in range(levels):
            total += weight[j] * exp(scratch.log_likelihood[j] - top)
        found[k] = top + log(total) - volume


@compiled
def _straighten(s, scratch, o, p, at, x, P, u, noise, no_map, prior):
    """Fill in the six equations at one component, whose reactions are forgotten."""
    n = OPEN
    for i in range(n, n + 3):
        for j in range(n + 3):
            P[i, j] = P[j, i] = 0.0
        P[i, i] = prior * prior
    straighten(
        p, x, P, n, at, u, noise, no_map, s.load[0], o.direction_share, o.inertia,
        s.friction_force2, scratch,
    )  # fmt: skip


@compiled
def _innovation(s, scratch, o, P, residual, covariance):
    """Fill in residual and covariance of the six equations."""
    w = OPEN + 3
    late = max(o.direction_time / max(s.step[0], 1e-4), 1.0)
    for i in range(6):
        residual[i] = -scratch.residual[i]
        for j in range(6):
            t = scratch.R[i, j] + late * scratch.unknown[i, j]
            for a in range(w):
                for b in range(w):
                    t += scratch.E[i, a] * P[a, b] * scratch.E[j, b]
            covariance[i, j] = t


@compiled
def _volume(scratch, n):
    """
    Return what the density of six equations is of that of a wrench free of its reactions.

    Reactions are unknowns of each wrench. With the volume that they fill in it, the likelihood
    would favour what makes them uncertain: a friction or a bias that is wrong by far. What is left
    is the density of the three combinations of the wrench, in units of its noise, that no
    reaction changes (restricted likelihood; Patterson and Thompson, Biometrika 58, 1971).
    """
    root, E, G = scratch.root, scratch.E, scratch.gain
    size = 0.0
    root[:, :] = scratch.R
    lower_root(root, 6)
    for i in range(6):
        size += log(root[i, i])
        for k in range(3):
            t = E[i, n + k]
            for q in range(i):
                t -= root[i, q] * G[k, q]
            G[k, i] = t / root[i, i]
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
