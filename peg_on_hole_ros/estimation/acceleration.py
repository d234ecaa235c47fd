"""How a held peg accelerates: as it did of late, within what is stated."""

from peg_on_hole_ros.estimation.memory import ACCELERATION, RATES_KNOWN, X
from peg_on_hole_ros.mechanics.kernel import compiled, inlined

# The rates' changes are averaged over this time [s].
FOLLOWED = 0.01
# An acceleration that lasts no longer than that is known to this share of itself.
CHANGED = 0.5
# Two orientations may have one stamp [s].
SHORTEST_TIME = 1e-4


@compiled
def follow_acceleration(m, dt):
    """
    Let the acceleration follow the rates after a correction.

    After the first one the rates are no longer unknown, which is no acceleration.

    Parameters
    ----------
    m : ndarray
        Memory, see `memory`.
    dt : float
        Time since the last correction [s].

    """
    dt = max(dt, SHORTEST_TIME)
    share = min(dt / FOLLOWED, 1.0) * m[RATES_KNOWN]
    m[RATES_KNOWN] = 1.0
    for i in range(3):
        now = (m[X + 3 + i] - m[ACCELERATION + 3 + i]) / dt
        m[ACCELERATION + i] += share * (now - m[ACCELERATION + i])
        m[ACCELERATION + 3 + i] = m[X + 3 + i]


@inlined
def bridged_density(m, i):
    """Return how a rate that is taken for constant wanders while it accelerates [rad^2/s^3]."""
    return FOLLOWED * m[ACCELERATION + i] * m[ACCELERATION + i]


@inlined
def acceleration_variance(m, i, stddev):
    """Return how far an angle's acceleration may be from the followed one, squared [rad^2/s^4]."""
    changed = CHANGED * m[ACCELERATION + i]
    return stddev * stddev + changed * changed
