"""A friction coefficient that does not fit: taken as stated again, or sought below."""

from math import sqrt

from peg_on_hole_ros.estimation.kernel.memory import (
    CROSS,
    FRICTION_LAG,
    LEARNT,
    OFFSET_SPREAD,
    OFFSETS,
    SCENE,
    SLIDING,
    SPREAD,
    STATED,
    WITHOUT_STEP,
)
from peg_on_hole_ros.estimation.kernel.parameters import LEAST_FRICTION

# Without a step for longer than this [s] a friction coefficient is not what it was learnt to be.
# For less it is noise in the wrench: where a peg nearly wedges, it leaves no step now and then.
LEARNT_WRONG = 0.02
# In this time after that [s] all that was learnt of it is forgotten.
FORGET_FRICTION = 0.02
# In the same time, a coefficient that leaves no step is sought by this many of its standard
# deviations below the stated one; so is, at once, one with which a contact would pull.
SEEK_FRICTION = 2.0
# Without a step for longer than this [s] it was not there, and is sought farther below, as fast;
# down to none, and again from the stated one.
SEEK_FARTHER = 0.06
# Share of its stated variance that friction gets back with each surprise.
SURPRISED = 0.5
# Friction that is known to no less than this share of its stated variance has not been learnt,
NOT_LEARNT = 0.9
# and to no less than this share it is not yet known on which side of the stated one it lies.
HARDLY_LEARNT = 0.5


def take_friction(m, value: float, variance: float):
    """Take friction for a value that has nothing to do with what else is in the memory m."""
    m[SCENE + 7] = m[FRICTION_LAG] = value
    m[FRICTION_LAG + 1], m[FRICTION_LAG + 2] = variance, 0.0
    m[CROSS : CROSS + 12] = 0.0
    m[SPREAD], m[SPREAD + 1], m[SPREAD + 2] = variance, 0.0, 0.0
    for k in range(int(m[OFFSETS]), int(m[OFFSETS + 1])):
        m[OFFSET_SPREAD + 10 * k] = 0.0


def doubt_without_step(m, dt: float, patient: bool):
    """
    Give friction its spread back: no step at its value, and a wrong one leaves none either.

    A peg that surely slides where its friction would wedge it has less of it: as long as friction
    is not known, it is then sought below. From there it is learnt; from above, where the
    equations have no solution, it never would be.

    Parameters
    ----------
    m : ndarray
        Memory, after a prediction that found no step.
    dt : float
        Time of that prediction [s].
    patient : bool
        Whether noise in the wrench is to blame at first; what is not learnt is sought at once.

    """
    # One that is only considered is what it is stated to be, whatever happens.
    if m.item(LEARNT) == 0.0:
        return
    stated, variance = m.item(STATED), m.item(STATED + 1)
    if not patient or m.item(WITHOUT_STEP) + dt > LEARNT_WRONG:
        m[SPREAD] = min(m.item(SPREAD) + variance * dt / FORGET_FRICTION, variance)
    if m.item(SLIDING) > 0.0 and m.item(SPREAD) > NOT_LEARNT * variance > 0.0:
        farther = m.item(WITHOUT_STEP) + dt > SEEK_FARTHER
        lowest = LEAST_FRICTION if farther else low_friction(m)
        now = m.item(SCENE + 7)
        if now > lowest:
            lower = now - sqrt(variance) * SEEK_FRICTION * dt / FORGET_FRICTION
            take_friction(m, max(lower, lowest), m.item(SPREAD))
        elif farther:
            take_friction(m, stated, m.item(SPREAD))


def low_friction(m) -> float:
    """Return the coefficient from which one that is sought below the stated one is learnt."""
    return max(m.item(STATED) - SEEK_FRICTION * sqrt(m.item(STATED + 1)), LEAST_FRICTION)


def regained_by_surprise(m) -> float:
    """Return how much variance a surprise gives back to friction, of that which was stated."""
    variance = m.item(STATED + 1)
    return max(min(SURPRISED * variance, variance - m.item(SPREAD)), 0.0)
