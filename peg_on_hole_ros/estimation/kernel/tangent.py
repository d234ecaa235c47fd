"""Where a step has its tangent beside what is constant: at the mean of the rates of late."""

from peg_on_hole_ros.estimation.kernel.acceleration import SHORTEST_TIME
from peg_on_hole_ros.estimation.kernel.memory import MEAN_RATES, RATES, RATES_WEIGHT, X
from peg_on_hole_ros.estimation.steps.implicit_euler import fill_slopes, inverse_of
from peg_on_hole_ros.mechanics.kernel import accelerate_with_derivatives, compiled, inlined

# Rates are averaged over this time [s].
AVERAGED = 0.05
# From this share of it on, at the variance that they have by now, their mean is known. From less
# it is off one way for long, and so are tangents at it. Meanwhile a step's own tangent counts: a
# diameter that is far off leaves no step in the end, unless it is learnt at once.
KNOWN = 0.5
# Further from the mean than so many of their own standard deviations the rates have changed.
CHANGED = 3.0


@inlined
def follow_rates(m, dt):
    """
    Let the mean of the rates, each by its weight, follow a correction.

    Parameters
    ----------
    m : ndarray
        Memory, see `memory`.
    dt : float
        Time since the last correction [s].

    """
    dt = max(dt, SHORTEST_TIME)
    left = max(1.0 - dt / AVERAGED, 0.0)
    for i in range(3):
        weight = dt / m[RATES + 13 * i]
        m[RATES_WEIGHT + i] = left * m[RATES_WEIGHT + i] + weight
        share = weight / m[RATES_WEIGHT + i]
        m[MEAN_RATES + i] += share * (m[X + 3 + i] - m[MEAN_RATES + i])


@inlined
def mean_rates_known(m):
    """Return whether there is a mean of the rates, and they have not changed since."""
    for i in range(3):
        variance = m[RATES + 13 * i]
        if not m[RATES_WEIGHT + i] * variance > KNOWN * AVERAGED:
            return False
        off = m[X + 3 + i] - m[MEAN_RATES + i]
        if not off * off <= CHANGED * CHANGED * variance:
            return False
    return True


@compiled
def tangent_at(p, rates, scales, x1, u, h, dy, slopes, stage, work):
    """
    Fill the derivatives of an implicit Euler step as they are at other rates, the mean of late.

    The noise of a wrench drives the rates, and with them turns the slip and all that a clearance
    does to the motion. Weighed by a tangent at these rates, what the noise has done to the motion
    is multiplied by itself, and moves friction and clearance one way. The mean hardly has it.

    Parameters
    ----------
    p, scales, u, h, dy, stage, work
        As for `steps.implicit_euler`, which has found x1; dy and stage are scratch.
    rates : ndarray, shape (3,)
        At which they are taken [rad/s].
    x1 : ndarray, shape (6,)
        State at the end [rad], [rad/s]; its angles are used.
    slopes : ndarray, shape (>= 3, 14)
        Filled as by `steps.implicit_euler`.

    """
    at, y = stage[:6], stage[6:12]
    for i in range(3):
        at[i], at[3 + i] = x1[i], rates[i]
    accelerate_with_derivatives(p, scales, at, u, work, y, dy)
    row0, row1, row2 = inverse_of(h, dy)
    fill_slopes(h, dy, row0, row1, row2, slopes)
