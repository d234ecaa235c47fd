"""Innovations that lean one way, and steps that are doubted for it."""

from math import exp, isfinite, sqrt

from peg_on_hole_ros.estimation.kernel.correction import white_innovation
from peg_on_hole_ros.estimation.kernel.memory import (
    DOUBT,
    SLIDING,
    SPEEDS,
    STATED,
    STEPS_LEAN,
    process_of,
)
from peg_on_hole_ros.estimation.kernel.parameters import (
    friction_known_to,
    learns_geometry_or_bias,
)
from peg_on_hole_ros.mechanics.kernel import compiled, inlined, scene_of

# A mean is over so many innovations.
LEANT_OVER = 10.0
# One innovation squared counts as this much at most, over its expectation.
MOST_SURPRISE = 5.0
# Steps whose innovations lean by so much more than white ones do are doubted, and white ones come
# to that once in a thousand means; until no more is left of it than white ones have.
DOUBTED_ABOVE, TRUSTED_BELOW = 5.5, 1.0
# While no step is believed it is forgotten over this time [s]: then steps are tried again.
FORGOTTEN_OVER = 0.2
# A doubt is about slips so many times as far from none as those that are not told.
FARTHER = 3.0
# Friction makes them lean as well, until it is known to this share of it, and where it has turned
# out to be so many stated deviations from what was stated: it may be farther yet.
FRICTION_KNOWN, AS_STATED = 0.03, 2.0


@inlined
def follow_lean(m, at, white):
    """Let the mean at a place of the memory follow a white innovation."""
    w0, w1, w2 = white
    nis = w0 * w0 + w1 * w1 + w2 * w2
    if isfinite(nis):
        # One far off counts as one that surprises most.
        limit = sqrt(min(1.0, 3.0 * MOST_SURPRISE / max(nis, 1e-300)))
        m[at] += (limit * w0 - m[at]) / LEANT_OVER
        m[at + 1] += (limit * w1 - m[at + 1]) / LEANT_OVER
        m[at + 2] += (limit * w2 - m[at + 2]) / LEANT_OVER


@inlined
def lean(m, at):
    """Return how far the mean at a place leans, squared, over what white innovations have."""
    square = m[at] * m[at] + m[at + 1] * m[at + 1] + m[at + 2] * m[at + 2]
    return square * (2.0 * LEANT_OVER - 1.0) / 3.0


@compiled
def follow_steps(m, dt):
    """
    Follow how the innovations of steps lean, and fill in whether steps are doubted for it.

    White innovations lean nowhere. Those of steps do where the six equations are not those of the
    scene: contacts that give, a friction of their own, a lever arm that is off. The filter takes
    what is wrong of the accelerations for noise of the wrench and adds it up in the rates; where
    a contact slips slowly, that is another direction of friction.

    Parameters
    ----------
    m : ndarray
        Memory, with the innovation and its root at RESIDUAL and S.
    dt : float
        Since the last orientation that was taken [s].

    """
    if m[SLIDING] > 0.0:
        follow_lean(m, STEPS_LEAN, white_innovation(m))
    else:
        left = exp(-dt / FORGOTTEN_OVER)
        for i in range(3):
            m[STEPS_LEAN + i] *= left
    size = lean(m, STEPS_LEAN)
    if size > DOUBTED_ABOVE:
        m[DOUBT] = 1.0
    elif size < TRUSTED_BELOW:
        m[DOUBT] = 0.0


@inlined
def doubted(m):
    """Return whether a step is doubted: its kind leans, and some contact slips slowly."""
    if m[DOUBT] == 0.0 or learns_geometry_or_bias(m):
        return False
    off = scene_of(m).f - m[STATED]
    as_stated = off * off <= AS_STATED * AS_STATED * m[STATED + 1]
    if not as_stated or not friction_known_to(m, FRICTION_KNOWN):
        return False
    within = FARTHER * process_of(m).slow_slip
    for i in range(3):
        speed, variance = m[SPEEDS + 2 * i], m[SPEEDS + 2 * i + 1]
        if speed * speed < within * within * variance:
            return True
    return False
