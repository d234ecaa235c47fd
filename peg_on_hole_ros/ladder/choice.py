"""The cheapest rung whose error keeps to a tolerance, decided now and then and held between."""

from math import fabs

import numpy as np

from peg_on_hole_ros.ladder.domain import LEAST_MARGIN, Numbers, in_domain, numbers
from peg_on_hole_ros.ladder.rungs import ALIGN_SLIP, MODES, RUNGS, answer
from peg_on_hole_ros.mechanics.kernel import accelerate, compiled, inlined

# Of the tolerance: what a rung may be predicted to err by, and what it may err by where nothing is
# known yet of how its error changes.
MOST, FIRST = 0.7, 0.3
# Samples to the next decision: at most, and where nothing is known of how an error changes.
LONGEST, FIRST_HOLD = 64, 4
# A rung cheaper than the one in use has to be good for so many samples.
WORTH = 10
# Share of the samples after which a steady change of the error would reach the tolerance.
GROWTH = 0.4
# Share of an earlier, faster change that is still reckoned with at the next decision.
FORGET = 0.8
# Relative change of the excess, of the rates or of the wrench after which no decision is kept.
MOVED = 0.25

# Places in a choice's memory; of each rung below the full ones the size of its error at the last
# decision (-1: not known), how fast it changes a sample, and the error in N_K, N_B1, N_B2.
_TOLERANCE, _RUNG, _HOLD, _SINCE, _DECISIONS, _CHANGES, _LARGEST = range(7)
_ERRORS, _CHANGE, _APART, _NUMBERS, _STATE, _WRENCH = 7, 11, 15, 27, 34, 40
_SIZE = 46


def new_choice(tolerance: float) -> np.ndarray:
    """Return the memory of a choice, for a tolerance on the reactions over the largest of them."""
    memory = np.zeros(_SIZE)
    memory[_TOLERANCE], memory[_RUNG] = tolerance, MODES
    memory[_ERRORS:_CHANGE] = -1.0
    return memory


@compiled
def choose(c, p, scales, x, u, work, y):
    """
    Return the rung to use for a sample; decide anew where the last decision may not keep.

    Parameters
    ----------
    c : ndarray
        From `new_choice`.
    p, scales, x, u, work
        As for `rungs.answer`.
    y : ndarray, shape (6,)
        Scratch.

    Returns
    -------
    int

    """
    c[_SINCE] += 1.0
    if c[_SINCE] < c[_HOLD] and not _moved(c, p, x, u):
        return int(c[_RUNG])
    return decide(c, p, scales, x, u, work, y)


@inlined
def _moved(c, p, x, u):
    s, w = _STATE, _WRENCH
    if fabs(x[0] - c[s]) > MOVED * (c[s] - p.gamma0):
        return True
    change = fabs(x[3] - c[s + 3]) + fabs(x[4] - c[s + 4]) + fabs(x[5] - c[s + 5])
    if change > MOVED * (fabs(c[s + 3]) + fabs(c[s + 4]) + fabs(c[s + 5])):
        return True
    change = fabs(u[0] - c[w]) + fabs(u[1] - c[w + 1]) + fabs(u[2] - c[w + 2])
    if change > MOVED * (fabs(c[w]) + fabs(c[w + 1]) + fabs(c[w + 2])):
        return True
    change = fabs(u[3] - c[w + 3]) + fabs(u[4] - c[w + 4]) + fabs(u[5] - c[w + 5])
    return change > MOVED * (fabs(c[w + 3]) + fabs(c[w + 4]) + fabs(c[w + 5]))


@compiled
def decide(c, p, scales, x, u, work, y):
    """
    Decide: compare every rung, from the cheapest, with the full equations at this state.

    An error is carried on by how fast it has changed since the last decision. A difference that
    goes through zero, as where an acceleration turns round, is thereby not taken for a small one.
    """
    for i in range(6):
        c[_STATE + i], c[_WRENCH + i] = x[i], u[i]
    since, before, rung = c[_SINCE], int(c[_RUNG]), MODES
    longest = min(2.0 * since + FIRST_HOLD, LONGEST)
    hold = longest if before == MODES else FIRST_HOLD
    c[_SINCE] = 0.0
    c[_DECISIONS] += 1.0
    margin = accelerate(p, scales, x, u, work, y)
    N_K, N_B1, N_B2 = y[3], y[4], y[5]
    largest = c[_LARGEST] = max(fabs(N_K), fabs(N_B1), fabs(N_B2))
    # Towards the singular set every error grows as one over the margin.
    loss = fabs(margin - c[_NUMBERS + 6])
    if loss * longest > since * (margin - LEAST_MARGIN) / 3.0:
        longest = max(since * (margin - LEAST_MARGIN) / (3.0 * loss), 1.0)
    n = numbers(p, x, y, margin)
    for i in range(7):
        c[_NUMBERS + i] = n[i]
    found = not min(N_K, N_B1, N_B2) >= 0.0
    for r in range(ALIGN_SLIP + 1):
        last, c[_ERRORS + r] = c[_ERRORS + r], -1.0
        if found or not in_domain(r, n):
            continue
        answer(r, p, scales, x, u, work, y)
        at = _APART + 3 * r
        error = change = 0.0
        for i, N in enumerate((N_K, N_B1, N_B2)):
            apart = (y[3 + i] - N) / largest
            error = max(error, fabs(apart))
            change = max(change, fabs(apart - c[at + i]))
            c[at + i] = apart
        c[_ERRORS + r] = error
        if last >= 0.0:
            # How fast it changes has a peak as well, which a decision may miss.
            change = c[_CHANGE + r] = max(change / since, FORGET * c[_CHANGE + r])
            keeps = GROWTH * (MOST * c[_TOLERANCE] - error) / (change + 1e-12)
        else:
            keeps = FIRST_HOLD if error < FIRST * c[_TOLERANCE] else 0.0
        keeps = min(keeps, longest)
        if keeps >= (WORTH if r < before and last >= 0.0 and longest > WORTH else 1.0):
            found, rung, hold = True, r, keeps
    if rung != before:
        c[_CHANGES] += 1.0
    c[_RUNG], c[_HOLD] = rung, hold
    return rung


@compiled
def answer_by_choice(c, p, scales, x, u, work, y):
    """Fill y as `rungs.answer` does, by the rung that is chosen; return that rung."""
    rung = choose(c, p, scales, x, u, work, y)
    good = answer(rung, p, scales, x, u, work, y)
    if rung != MODES and not (good and min(y[3], y[4], y[5]) >= 0.0):
        # A contact may be about to open.
        rung = decide(c, p, scales, x, u, work, y)
        answer(rung, p, scales, x, u, work, y)
    return rung


def explained(memory: np.ndarray) -> str:
    """Return the last decision as one line."""
    rung, tolerance = int(memory[_RUNG]), memory[_TOLERANCE]
    n = Numbers(*memory[_NUMBERS : _NUMBERS + 7].tolist())
    errors = memory[_ERRORS:_CHANGE]
    tried = ", ".join(
        f"{name} {errors[i]:.2%}" for i, name in enumerate(RUNGS[:rung]) if errors[i] >= 0
    )
    if rung == MODES:
        why = f"no cheaper one keeps to {tolerance:.2%}"
    else:
        why = f"error {errors[rung]:.2%} of {memory[_LARGEST]:.4g} N, {tolerance:.2%} allowed"
    return (
        f"{RUNGS[rung]}: {why}{'; ' if tried else ''}{tried}; inertia {n.inertia:.2g}, slip "
        f"{n.slip:.2g}, slide {n.slide:.2g}, excess {n.excess:.2g}, margin {n.margin:.2g}"
    )
