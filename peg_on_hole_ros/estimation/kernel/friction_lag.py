"""Friction that is learnt too slowly: it is known no better than how far it lags says."""

from peg_on_hole_ros.estimation.kernel.memory import FRICTION_LAG, SCENE, SPREAD, STATED
from peg_on_hole_ros.estimation.kernel.parameters import learns_geometry_or_bias
from peg_on_hole_ros.mechanics.kernel import compiled

# Friction is known no better than to this share of its lag, squared. What is learnt as it should
# be lags by a standard deviation at first, by 0.7 of one where it has long been followed, and so
# past the 1.4 from which this counts in one of six cases at most.
LAGS = 0.5
# Beside a clearance, a bias or a tilt that is learnt its lag is not followed: there it wanders by
# so many times as much. Without, the clearance of a peg that only closes is stated too surely.
WANDERS_BESIDE = 4.0


def friction_density(options, alone: bool) -> float:
    """Return the density of friction's random walk, learnt alone or beside something [1/s]."""
    if options.friction != "estimated":
        # What is only considered is as it is stated, and stays so.
        return 0.0
    return (options.friction_noise * (1.0 if alone else WANDERS_BESIDE)) ** 2


@compiled
def follow_friction(m):
    """
    Follow how far friction lags behind what corrections tell, and leave it known no better.

    Each correction moves it and tells a share of what was not known of it. The sum of all
    movements, each forgotten by the shares that were told since, is how far a friction is behind
    that moves steadily; where all is as it is stated it goes to and fro.

    Parameters
    ----------
    m : ndarray
        Memory, after a correction. Beside a clearance, a bias or a tilt that is learnt nothing is
        done: along their ridge friction moves as they do.

    """
    variance, before = m[SPREAD], m[FRICTION_LAG + 1]
    if learns_geometry_or_bias(m):
        m[FRICTION_LAG + 2] = 0.0
    else:
        left = min(variance / before, 1.0) if before > 0.0 else 1.0
        lag = left * (m[FRICTION_LAG + 2] + m[SCENE + 7] - m[FRICTION_LAG])
        m[FRICTION_LAG + 2] = lag
        m[SPREAD] = max(variance, min(LAGS * lag * lag, m[STATED + 1]))
    m[FRICTION_LAG], m[FRICTION_LAG + 1] = m[SCENE + 7], m[SPREAD]
