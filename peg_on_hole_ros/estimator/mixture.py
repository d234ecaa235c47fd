"""A mixture of friction hypotheses and of process-noise modes: IMM mixing, weights, their mean."""

from math import exp, log

from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.motion import move_on
from peg_on_hole_ros.estimator.settings import Settings
from peg_on_hole_ros.estimator.state import FRICTION, State
from peg_on_hole_ros.estimator.tuned import MIXTURE_WEIGHTS
from peg_on_hole_ros.mechanics.kernel import compiled


@compiled
def predict(kalman: FilterRecord, dt: float) -> None:
    """Mix the modes of each friction hypothesis, then predict every component by dt [s]."""
    state, settings = kalman.state, kalman.settings
    modes, hypotheses = settings.modes, state.hypotheses
    if modes > 1:
        several = state.gathered == 1 or state.alive.sum() > 1.5
        shut = settings.top_waits > 0.0 and several
        time = min(dt, MIXTURE_WEIGHTS.longest_mixing)
        for g in range(hypotheses):
            if state.alive[g] > 0.0:
                _mix(kalman, g * modes, shut, time)
    for j in range(hypotheses * modes):
        if state.alive[j // modes] > 0.0:
            move_on(kalman, j, dt)


@compiled
def _mix(kalman: FilterRecord, first: int, shut: bool, time: float) -> None:
    """Mix the modes of one friction hypothesis (interacting multiple model, IMM)."""
    state, scratch, settings = kalman.state, kalman.scratch, kalman.settings
    n = kalman.places.reactions
    modes, share, w = settings.modes, scratch.transition, n + 3
    top = modes - 1
    weight = 0.0
    for i in range(modes):
        weight += state.weight[first + i]
    # Friction walks in the top mode: below this weight no other mode inherits from it.
    unlikely = state.weight[first + top] < settings.least_inherited * weight
    for i in range(modes):
        stays = 1.0
        for j in range(modes):
            if i == j:
                continue
            change = (settings.mode_rate[j] if j > i else settings.mode_rate[1]) * time
            if (shut and j == top) or (unlikely and i == top):
                change = 0.0
            share[i, j] = change * state.weight[first + i]
            stays -= change
        share[i, i] = stays * state.weight[first + i]
    for j in range(modes):
        total = 0.0
        for i in range(modes):
            total += share[i, j]
        for i in range(modes):
            share[i, j] /= total
        scratch.log_likelihood[first + j] = total
        x, P = scratch.x[first + j], scratch.P[first + j]
        for a in range(w):
            t = 0.0
            for i in range(modes):
                t += share[i, j] * state.x[first + i, a]
            x[a] = t
        for a in range(n):
            row = P[a]
            for b in range(n):
                row[b] = 0.0
            for i in range(modes):
                part, y, before = share[i, j], state.x[first + i], state.P[first + i, a]
                off = y[a] - x[a]
                for b in range(n):
                    row[b] += part * (before[b] + off * (y[b] - x[b]))
    for j in range(first, first + modes):
        state.weight[j] = scratch.log_likelihood[j]
        for a in range(w):
            state.x[j, a] = scratch.x[j, a]
        for a in range(n):
            for b in range(n):
                state.P[j, a, b] = scratch.P[j, a, b]


@compiled
def reweigh(kalman: FilterRecord) -> None:
    """
    Weigh the components by how likely the last measurement was with each.

    Modes count in full. For friction hypotheses a measurement counts by its evidence share: where
    the direction of friction is unknown, noise is not white, and the same sample would count again
    and again. The hypothesis with the best known direction determines that share.

    Parameters
    ----------
    kalman : FilterRecord
        With log likelihoods in its scratch memory.

    """
    state, scratch, modes = kalman.state, kalman.scratch, kalman.settings.modes
    several = state.alive.sum() > 1.5
    best = -1e300
    for g in range(state.hypotheses):
        if state.alive[g] == 0.0:
            continue
        first, top, before = g * modes, -1e300, 0.0
        for j in range(first, first + modes):
            top = max(top, scratch.log_likelihood[j])
            before += state.weight[j]
        total = 0.0
        for j in range(first, first + modes):
            behind = scratch.log_likelihood[j] - top
            ratio = exp(max(behind, MIXTURE_WEIGHTS.least_log_ratio))
            state.weight[j] *= ratio / before
            total += state.weight[j]
        kept = 0.0
        for j in range(first, first + modes):
            state.weight[j] = max(state.weight[j] / total, MIXTURE_WEIGHTS.least_weight)
            kept += state.weight[j]
        for j in range(first, first + modes):
            state.weight[j] /= kept
        share = state.evidence_share if several else 1.0
        evidence = log(before) + share * (top + log(total))
        scratch.evidence[g] = evidence
        best = max(best, evidence)
    _weigh_hypotheses(kalman, best)


@compiled
def _weigh_hypotheses(kalman: FilterRecord, best: float) -> None:
    """Weigh the friction hypotheses by their evidence, of which the best is given."""
    state, scratch, modes = kalman.state, kalman.scratch, kalman.settings.modes
    total = 0.0
    for g in range(state.hypotheses):
        if state.alive[g] > 0.0:
            total += exp(scratch.evidence[g] - best)
    left = 0.0
    for g in range(state.hypotheses):
        if state.alive[g] == 0.0:
            continue
        weight = exp(scratch.evidence[g] - best) / total
        if weight < MIXTURE_WEIGHTS.least_weight:
            state.alive[g], weight = 0.0, 0.0
        left += weight
        for j in range(g * modes, g * modes + modes):
            state.weight[j] *= weight
    for j in range(state.hypotheses * modes):
        state.weight[j] /= left


@compiled
def fill_evidence_share(kalman: FilterRecord, dt: float) -> None:
    """Fill in which share of a wrench, dt [s] after the last, counts for friction hypotheses."""
    state, scratch, settings = kalman.state, kalman.scratch, kalman.settings
    modes, most, again = settings.modes, 0.0, settings.direction_evidence_time / dt
    for g in range(state.hypotheses):
        if state.alive[g] == 0.0:
            continue
        weight, noise_share = 0.0, 0.0
        for j in range(g * modes, g * modes + modes):
            weight += state.weight[j]
            noise_share += state.weight[j] * scratch.direction_noise_share[j]
        most = max(most, 1.0 / (1.0 + again * noise_share / weight))
    state.evidence_share = most


@compiled
def merge(state: State, settings: Settings) -> None:
    """
    Merge friction hypotheses where that loses little, to mean and covariance of both.

    The loss is Runnalls' bound (2007) on the Kullback-Leibler divergence, of what is known of
    friction: a light hypothesis merges with another from afar, and heavy ones once they meet.
    """
    modes = settings.modes
    while True:
        least, first, second = settings.joined, -1, -1
        for g in range(state.hypotheses):
            for h in range(g):
                if state.alive[g] > 0.0 and state.alive[h] > 0.0:
                    one, other = _friction_of(state, modes, g), _friction_of(state, modes, h)
                    loss = _merging_loss(one, other)
                    if loss < least:
                        least, first, second = loss, h, g
        if first < 0:
            return
        for l in range(modes):
            _merge_components(state, first * modes + l, second * modes + l)
        state.alive[second] = 0.0


@compiled
def _merging_loss(one: tuple[float, float, float], other: tuple[float, float, float]) -> float:
    """Return what is lost of two normal distributions that become one [nats]."""
    w, f, v = one
    w_o, f_o, v_o = other
    both = w + w_o
    apart = w * w_o * ((f - f_o) / both) ** 2
    return 0.5 * (both * log((w * v + w_o * v_o) / both + apart) - w * log(v) - w_o * log(v_o))


@compiled
def _merge_components(state: State, i: int, j: int) -> None:
    """Merge a component into another, by mean and covariance."""
    total = state.weight[i] + state.weight[j]
    share = state.weight[j] / total
    x, y, P, Q = state.x[i], state.x[j], state.P[i], state.P[j]
    for a in range(state.width):
        for b in range(state.width):
            apart = (x[a] - y[a]) * (x[b] - y[b])
            P[a, b] = (1.0 - share) * P[a, b] + share * (Q[a, b] + (1.0 - share) * apart)
    for a in range(state.width):
        x[a] += share * (y[a] - x[a])
    state.weight[i], state.weight[j] = total, 0.0


@compiled
def _friction_of(state: State, modes: int, g: int) -> tuple[float, float, float]:
    """Return weight, mean and variance of a friction hypothesis."""
    w, f, v = 0.0, 0.0, 0.0
    for j in range(g * modes, g * modes + modes):
        w += state.weight[j]
        f += state.weight[j] * state.x[j, FRICTION]
        v += state.weight[j] * state.P[j, FRICTION, FRICTION]
    return w, f / w, v / w


@compiled
def combine(state: State) -> None:
    """Fill in mean and covariance of the whole mixture."""
    w, mean, C = state.width, state.mixture_mean, state.mixture_covariance
    for a in range(w):
        mean[a] = 0.0
        for b in range(w):
            C[a, b] = 0.0
    for j in range(state.components):
        for a in range(w if state.weight[j] > 0.0 else 0):
            mean[a] += state.weight[j] * state.x[j, a]
    for j in range(state.components):
        weight, x = state.weight[j], state.x[j]
        for a in range(w if weight > 0.0 else 0):
            row, P, off = C[a], state.P[j, a], x[a] - mean[a]
            for b in range(w):
                row[b] += weight * (P[b] + off * (x[b] - mean[b]))


@compiled
def keep_friction_force(state: State) -> None:
    """Keep the mean square of friction at each contact, which the next wrench is weighed with."""
    n = state.width - 3
    f2 = state.mixture_mean[FRICTION] ** 2
    for i in range(3):
        N = state.mixture_mean[n + i]
        state.friction_force2[i] = f2 * (N * N + state.mixture_covariance[n + i, n + i])
