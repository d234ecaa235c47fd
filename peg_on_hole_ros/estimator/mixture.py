"""A mixture of frictions and of levels of acceleration: mixing, weights, and their mean."""

from math import exp, log

import numpy as np

from peg_on_hole_ros.estimator.motion import move_on
from peg_on_hole_ros.estimator.state import FRICTION
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.record_types import ScratchRecord, SettingsRecord, StateRecord

# A level never goes below this weight among those of its friction; a friction that does is none.
_LEAST = 1e-9
# Changes of level are taken in slices no longer than this [s]: beyond, more than all would change.
_SLICE = 0.002
_MOST_RATIO = -50.0


@compiled
def predict(
    s: StateRecord, scratch: ScratchRecord, o: SettingsRecord, walk: np.ndarray, n: int, dt: float
) -> None:
    """
    Mix the levels of each friction, then move every component on.

    Parameters
    ----------
    s : record of STATE
        Changed.
    scratch : record of SCRATCH
    o : record of SETTINGS
    walk : ndarray, shape (n,)
        See `move_on`.
    n : int
    dt : float
        [s].

    """
    levels, frictions = o.levels, s.frictions
    if levels > 1:
        shut = o.top_waits > 0.0 and s.alive.sum() > 1.5
        time = min(dt, _SLICE)
        for g in range(frictions):
            if s.alive[g] > 0.0:
                _mix(s, scratch, o, n, g * levels, shut, time)
    for j in range(frictions * levels):
        if s.alive[j // levels] > 0.0:
            l = j % levels
            move_on(s.x[j], s.P[j], n, dt, o.level[l], o.time[l], o.around_axes, walk)


@compiled
def _mix(s, scratch, o, n, first, shut, time):
    """Let the levels of one friction change into one another (interacting multiple models)."""
    levels, share, w = o.levels, scratch.share, n + 3
    top = levels - 1
    for i in range(levels):
        stays = 1.0
        for j in range(levels):
            if i == j:
                continue
            change = (o.up[j] if j > i else o.up[1]) * time
            if shut and j == top:
                change = 0.0
            share[i, j] = change * s.weight[first + i]
            stays -= change
        share[i, i] = stays * s.weight[first + i]
    for j in range(levels):
        total = 0.0
        for i in range(levels):
            total += share[i, j]
        for i in range(levels):
            share[i, j] /= total
        scratch.log_likelihood[first + j] = total
        x, P = scratch.x[first + j], scratch.P[first + j]
        for a in range(w):
            t = 0.0
            for i in range(levels):
                t += share[i, j] * s.x[first + i, a]
            x[a] = t
        for a in range(n):
            row = P[a]
            for b in range(n):
                row[b] = 0.0
            for i in range(levels):
                part, y, before = share[i, j], s.x[first + i], s.P[first + i, a]
                off = y[a] - x[a]
                for b in range(n):
                    row[b] += part * (before[b] + off * (y[b] - x[b]))
    for j in range(first, first + levels):
        s.weight[j] = scratch.log_likelihood[j]
        for a in range(w):
            s.x[j, a] = scratch.x[j, a]
        for a in range(n):
            for b in range(n):
                s.P[j, a, b] = scratch.P[j, a, b]


@compiled
def reweigh(s: StateRecord, scratch: ScratchRecord, o: SettingsRecord) -> None:
    """
    Weigh the components by how likely the last measurement was with each.

    Levels count in full. For frictions a measurement counts by the share that is told: where the
    direction of friction is unknown, noise is not white, and the same sample would count again
    and again. The friction that knows the direction best says which share that is.

    Parameters
    ----------
    s : record of STATE
        Changed.
    scratch : record of SCRATCH
        With log likelihoods, and doubts of the last wrench.
    o : record of SETTINGS

    """
    levels, frictions = o.levels, s.frictions
    several = s.alive.sum() > 1.5
    best = -1e300
    for g in range(frictions):
        if s.alive[g] == 0.0:
            continue
        first, top, held = g * levels, -1e300, 0.0
        for j in range(first, first + levels):
            top = max(top, scratch.log_likelihood[j])
            held += s.weight[j]
        total = 0.0
        for j in range(first, first + levels):
            s.weight[j] *= exp(max(scratch.log_likelihood[j] - top, _MOST_RATIO)) / held
            total += s.weight[j]
        kept = 0.0
        for j in range(first, first + levels):
            s.weight[j] = max(s.weight[j] / total, _LEAST)
            kept += s.weight[j]
        for j in range(first, first + levels):
            s.weight[j] /= kept
        evidence = log(held) + (s.told[0] if several else 1.0) * (top + log(total))
        scratch.evidence[g] = evidence
        best = max(best, evidence)
    total = 0.0
    for g in range(frictions):
        if s.alive[g] > 0.0:
            total += exp(scratch.evidence[g] - best)
    left = 0.0
    for g in range(frictions):
        if s.alive[g] == 0.0:
            continue
        weight = exp(scratch.evidence[g] - best) / total
        if weight < _LEAST:
            s.alive[g], weight = 0.0, 0.0
        left += weight
        for j in range(g * levels, g * levels + levels):
            s.weight[j] *= weight
    for j in range(frictions * levels):
        s.weight[j] /= left


@compiled
def friction_told(s: StateRecord, scratch: ScratchRecord, o: SettingsRecord, dt: float) -> None:
    """Fill in which share of a wrench, dt [s] after the last, counts for choosing a friction."""
    levels, told, again = o.levels, 0.0, o.doubt / dt
    for g in range(s.frictions):
        if s.alive[g] == 0.0:
            continue
        held, doubt = 0.0, 0.0
        for j in range(g * levels, g * levels + levels):
            held += s.weight[j]
            doubt += s.weight[j] * scratch.doubt[j]
        told = max(told, 1.0 / (1.0 + again * doubt / held))
    s.told[0] = told


@compiled
def merge(s: StateRecord, o: SettingsRecord) -> None:
    """
    Let frictions join where that loses little, with mean and covariance of both.

    The loss is Runnalls' bound (2007) on the Kullback-Leibler divergence, of what is known of
    friction: a light friction joins another from afar, and heavy ones join once they meet.
    """
    levels, frictions = o.levels, s.frictions
    while True:
        least, first, second = o.joined, -1, -1
        for g in range(frictions):
            for h in range(g):
                if s.alive[g] > 0.0 and s.alive[h] > 0.0:
                    loss = _lost(_friction_of(s, levels, g), _friction_of(s, levels, h))
                    if loss < least:
                        least, first, second = loss, h, g
        if first < 0:
            return
        for l in range(levels):
            _join(s, first * levels + l, second * levels + l)
        s.alive[second] = 0.0


@compiled
def _lost(one, other):
    """Return what is lost of two normal distributions that become one [nats]."""
    w, f, v = one
    w_o, f_o, v_o = other
    both = w + w_o
    apart = w * w_o * ((f - f_o) / both) ** 2
    return 0.5 * (both * log((w * v + w_o * v_o) / both + apart) - w * log(v) - w_o * log(v_o))


@compiled
def _join(s, i, j):
    """Let one component be two, by mean and covariance; the other is none."""
    total = s.weight[i] + s.weight[j]
    share = s.weight[j] / total
    x, y, P, Q = s.x[i], s.x[j], s.P[i], s.P[j]
    for a in range(s.width):
        for b in range(s.width):
            apart = (x[a] - y[a]) * (x[b] - y[b])
            P[a, b] = (1.0 - share) * P[a, b] + share * (Q[a, b] + (1.0 - share) * apart)
    for a in range(s.width):
        x[a] += share * (y[a] - x[a])
    s.weight[i], s.weight[j] = total, 0.0


@compiled
def _friction_of(s, levels, g):
    """Return weight, mean and variance of a friction."""
    w, f, v = 0.0, 0.0, 0.0
    for j in range(g * levels, g * levels + levels):
        w += s.weight[j]
        f += s.weight[j] * s.x[j, FRICTION]
        v += s.weight[j] * s.P[j, FRICTION, FRICTION]
    return w, f / w, v / w


@compiled
def combine(s: StateRecord, n: int) -> None:
    """Fill in mean and covariance of the whole mixture."""
    w, mean, C = n + 3, s.mean, s.covariance
    for a in range(w):
        mean[a] = 0.0
        for b in range(w):
            C[a, b] = 0.0
    for j in range(s.components):
        for a in range(w if s.weight[j] > 0.0 else 0):
            mean[a] += s.weight[j] * s.x[j, a]
    for j in range(s.components):
        weight, x = s.weight[j], s.x[j]
        for a in range(w if weight > 0.0 else 0):
            row, P, off = C[a], s.P[j, a], x[a] - mean[a]
            for b in range(w):
                row[b] += weight * (P[b] + off * (x[b] - mean[b]))


@compiled
def keep_friction_force(s: StateRecord, n: int) -> None:
    """Keep the mean square of friction at each contact, which the next wrench is weighed with."""
    f2 = s.mean[FRICTION] ** 2
    for i in range(3):
        N = s.mean[n + i]
        s.friction_force2[i] = f2 * (N * N + s.covariance[n + i, n + i])
