"""
The cheapest rung whose error keeps to a tolerance, decided now and then and held between.

`align` and `align_slip` cost no less than the six equations, which make no error: `auto` passes
them over (docs/ladder.md has the figures), they can be asked for.
"""

from math import fabs

import numpy as np

from peg_on_hole_ros.ladder.domain import LEAST_BALANCE, LEAST_MARGIN, Numbers, in_domain, numbers
from peg_on_hole_ros.ladder.rungs import (
    ALIGN_SLIP,
    DYNAMIC,
    MODES,
    QUASI_STATIC,
    RUNGS,
    answer,
)
from peg_on_hole_ros.mechanics.kernel import accelerate, compiled, inlined

# Of the tolerance: what a rung may be predicted to err by, and what it may err by where nothing is
# known yet of how its error changes.
MOST, FIRST = 0.85, 0.4
# Samples to the next decision: at most, and where nothing is known of how an error changes.
LONGEST, FIRST_HOLD = 64, 4
# A rung cheaper than the one in use has to be good for so many samples.
WORTH = 4
# Share of the samples after which a steady change of the error would reach the tolerance.
GROWTH = 0.5
# Share of an earlier, faster change that is still reckoned with at the next decision.
FORGET = 0.8
# The same as GROWTH for the way to a singular set.
SINGULAR = 0.3
# Relative change of the excess, of the rates or of the wrench after which no decision is kept.
MOVED = 0.25

# Places in a choice's memory; of each rung below the full ones the size of its error at the last
# decision (-1: not known), how fast it changes a sample, and the error in N_K, N_B1, N_B2.
_TOLERANCE, _ASKED, _TOP, _RUNG, _HOLD, _SINCE, _DECISIONS, _CHANGES, _LARGEST = range(9)
_ERRORS, _CHANGE, _APART, _NUMBERS, _STATE, _WRENCH = 9, 13, 17, 29, 37, 43
_SIZE = 49
_MARGIN = _NUMBERS + 6
AUTO = -1


def new_choice(tolerance: float, asked: int = AUTO, top: int = MODES) -> np.ndarray:
    """
    Return the memory of a choice.

    Parameters
    ----------
    tolerance : float
        Error allowed in a reaction, over the largest of the three.
    asked : int
        A rung to use whatever its error, which is then only told; AUTO chooses.
    top : int
        The full model: DYNAMIC, or MODES.

    """
    memory = np.zeros(_SIZE)
    memory[_TOLERANCE], memory[_ASKED], memory[_TOP] = tolerance, asked, top
    memory[_RUNG] = top if asked == AUTO else asked
    memory[_ERRORS:_CHANGE] = -1.0
    return memory


@inlined
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
    Decide: compare rungs, from the cheapest, with the full equations at this state.

    An error is carried on by how fast it has changed since the last decision. A difference that
    goes through zero, as where an acceleration turns round, is thereby not taken for a small one.
    """
    for i in range(6):
        c[_STATE + i], c[_WRENCH + i] = x[i], u[i]
    since, before, rung = c[_SINCE], int(c[_RUNG]), int(c[_TOP])
    longest = min(2.0 * since + FIRST_HOLD, LONGEST)
    hold = longest if before == rung else FIRST_HOLD
    c[_SINCE] = 0.0
    c[_DECISIONS] += 1.0
    margin = accelerate(p, scales, x, u, work, y)
    N_K, N_B1, N_B2 = y[3], y[4], y[5]
    largest = c[_LARGEST] = max(fabs(N_K), fabs(N_B1), fabs(N_B2))
    n = numbers(p, scales, x, y, margin)
    longest = _until_singular(longest, since, margin, c[_MARGIN], LEAST_MARGIN)
    longest = _until_singular(longest, since, n.balance, c[_MARGIN + 1], LEAST_BALANCE)
    for i in range(8):
        c[_NUMBERS + i] = n[i]
    asked = int(c[_ASKED])
    found = not min(N_K, N_B1, N_B2) >= 0.0
    for r in range((QUASI_STATIC if asked == AUTO else ALIGN_SLIP) + 1):
        last, c[_ERRORS + r] = c[_ERRORS + r], -1.0
        if asked != r and (found or asked != AUTO or not in_domain(r, n)):
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
        if last < 0.0:
            keeps = FIRST_HOLD if error < FIRST * c[_TOLERANCE] else 0.0
        elif since > 0.0:
            # How fast it changes has a peak as well, which a decision may miss.
            change = c[_CHANGE + r] = max(change / since, FORGET * c[_CHANGE + r])
            keeps = GROWTH * (MOST * c[_TOLERANCE] - error) / (change + 1e-12)
        else:
            # It was decided at this very sample, and then a contact pulled.
            keeps = 0.0
        keeps = min(keeps, longest)
        if keeps >= (WORTH if r < before and last >= 0.0 and longest > WORTH else 1.0):
            found, rung, hold = True, r, keeps
    if asked != AUTO:
        rung = asked
    if rung != before:
        c[_CHANGES] += 1.0
    c[_RUNG], c[_HOLD] = rung, hold
    return rung


@inlined
def _until_singular(longest, since, now, last, least):
    """Return how long a decision may keep where a margin goes: errors grow as one over it."""
    loss, left = fabs(now - last), SINGULAR * since * (now - least)
    return max(left / loss, 1.0) if loss * longest > left else longest


@compiled
def answer_by_choice(c, p, scales, x, u, work, y):
    """Fill y as `rungs.answer` does, by the rung that is chosen; return that rung."""
    rung = choose(c, p, scales, x, u, work, y)
    good = answer(rung, p, scales, x, u, work, y)
    if rung < DYNAMIC and not (good and min(y[3], y[4], y[5]) >= 0.0):
        # A contact may be about to open.
        rung = decide(c, p, scales, x, u, work, y)
        answer(rung, p, scales, x, u, work, y)
    return rung


def error_of(memory: np.ndarray) -> float:
    """Return the error of the rung in use at the last decision, over the largest reaction."""
    rung = int(memory[_RUNG])
    return memory.item(_ERRORS + rung) if rung <= ALIGN_SLIP else 0.0


def tally(memory: np.ndarray) -> tuple[int, int]:
    """Return how many decisions there were, and changes of the rung."""
    return int(memory[_DECISIONS]), int(memory[_CHANGES])


def size_of(memory: np.ndarray) -> float:
    """Return the largest reaction at the last decision [N]."""
    return memory.item(_LARGEST)


def explained(memory: np.ndarray) -> str:
    """Return the last decision as one line."""
    rung, tolerance = int(memory[_RUNG]), memory[_TOLERANCE]
    if not memory[_DECISIONS]:
        return f"{RUNGS[rung]}: nothing decided yet"
    n = Numbers(*memory[_NUMBERS : _NUMBERS + 8].tolist())
    errors = memory[_ERRORS:_CHANGE]
    tries = [*zip(RUNGS, errors)][:rung]
    lower = [f"{name} {error:.2%}" for name, error in tries if error >= 0]
    tried = f"; {', '.join(lower)}" if lower else ""
    if rung > ALIGN_SLIP:
        why = f"no cheaper one is sure to keep to {tolerance:.2%} of {memory[_LARGEST]:.4g} N"
    elif errors[rung] < 0:
        why = "error not known, since a reaction pulls"
    else:
        why = f"error {errors[rung]:.2%} of {memory[_LARGEST]:.4g} N, {tolerance:.2%} allowed"
    if memory[_ASKED] != AUTO:
        why = f"asked for; {why}"
    return (
        f"{RUNGS[rung]}: {why}{tried}; inertia {n.inertia:.2g}, slip "
        f"{n.slip:.2g}, slide {n.slide:.2g}, excess {n.excess:.2g}, margin {n.margin:.2g}"
    )
