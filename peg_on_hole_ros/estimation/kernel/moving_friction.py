"""Friction that is still on its way: it is not known as well as the tangents along it say."""

from math import sqrt

from peg_on_hole_ros.estimation.kernel.memory import FRICTION_OF_LATE, SCENE, SPREAD, STATED
from peg_on_hole_ros.estimation.kernel.parameters import learns_geometry_or_bias
from peg_on_hole_ros.mechanics.kernel import compiled, inlined

# What friction was of late, and how well it was known, are means over this time [s].
OF_LATE = 0.05
# It may be off by this share of how far it has moved beyond what was learnt of it meanwhile.
# Chosen on pure align that is told half of f 0.5: with 0.4 it stays too sure, with 0.7 what is
# told a quarter of it off is learnt more slowly.
ON_ITS_WAY = 0.5
# What is learnt moves it by so many times as much as its standard deviation falls at most. With 1
# reactions at 1 rad/s are up to 1.7 times as far off, for frictions that were on their way anyway.
SURELY = 2.0


@compiled
def widen_moving_friction(m):
    """
    Leave friction known no better than it can be for how it moved of late.

    Learnt as it should be, friction moves by about as much as its standard deviation falls. One
    that is dragged along by tangents which turn moves on, a little with each correction and all
    one way, and is stated ever better.

    Parameters
    ----------
    m : ndarray
        Memory, after a correction. Beside a clearance, a bias or a tilt that is learnt nothing is
        done: along their ridge friction moves as they do.

    """
    if learns_geometry_or_bias(m):
        return
    stddev = _stddev(m)
    fell = SURELY * max(m[FRICTION_OF_LATE + 1] - stddev, 0.0)
    moved = m[SCENE + 7] - m[FRICTION_OF_LATE]
    beyond = ON_ITS_WAY * (max(moved, -moved) - fell)
    if beyond > stddev:
        m[SPREAD] = max(min(beyond * beyond, m[STATED + 1]), m[SPREAD])


@compiled
def follow_friction(m, dt):
    """Widen friction by how it moved of late, and let that follow a correction; dt [s]."""
    widen_moving_friction(m)
    share = min(dt / OF_LATE, 1.0)
    m[FRICTION_OF_LATE] += share * (m[SCENE + 7] - m[FRICTION_OF_LATE])
    m[FRICTION_OF_LATE + 1] += share * (_stddev(m) - m[FRICTION_OF_LATE + 1])


@inlined
def _stddev(m):
    return sqrt(m[SPREAD]) if m[SPREAD] > 0.0 else 0.0
