"""The noise of the wrench as it shows it itself, where it is more than is stated."""

from math import sqrt

import numpy as np

from peg_on_hole_ros.estimator.noise import track_noise_ratio
from peg_on_hole_ros.estimator.settings import Settings
from peg_on_hole_ros.mechanics.kernel import compiled

# What white noise makes of a third difference, squared; a motion leaves next to nothing.
_THIRD = 20.0
# It is told after so many wrenches, once a unit had its time to be told, and up to such a share of
# the most that is followed.
TOLD, BROKEN = 145.0, 0.75
# Variances so many times the stated ones are of another unit, and are followed to twice that: a
# contact that chatters has some hundred times. Nothing is made of such a wrench.
BEYOND = 5e3
# Variances so many times the stated ones are told, and are used.
NOISY = 2.25
# In the memory: by how much the variance of force and of torque is more than stated, how many
# values have come, the most that was found of both, the first two with a higher bound, whether
# that was reached, the first two of the present stay in the air, how many values that had, and how
# many in a row that were too rough, whether a stay was calm, and the last three values.
FORCE, TORQUE, SEEN, MOST_FORCE, MOST_TORQUE = range(5)
WIDE_FORCE, WIDE_TORQUE, OFF_FORCE, OFF_TORQUE = range(5, 9)
AIR_FORCE, AIR_TORQUE, AIR_SEEN, AIR_ROUGH, CALM, VALUES = range(9, 15)
WIDTH = VALUES + 18


@compiled
def forget_noise(memory: np.ndarray) -> None:
    """Take noise as stated, until it shows more; what was found most stays."""
    memory[VALUES:] = memory[SEEN] = memory[AIR_SEEN] = memory[AIR_ROUGH] = 0.0
    for first in (FORCE, WIDE_FORCE, AIR_FORCE):
        memory[first] = memory[first + 1] = 1.0


def begin(memory: np.ndarray) -> None:
    """Forget all that was found, as where other noise is stated."""
    memory[:] = 0.0
    for first in (FORCE, WIDE_FORCE, AIR_FORCE):
        memory[first : first + 2] = 1.0


@compiled
def follow_wrench(
    memory: np.ndarray,
    values: np.ndarray | tuple[float, float, float],
    variance: np.ndarray,
    in_air: bool,
    settings: Settings,
) -> None:
    """
    Take a wrench with values that have not come before; the law is that of orientations.

    What is rough in contact alone chatters: it is used as noise, and is no setting's.

    Parameters
    ----------
    memory : ndarray
        Of WIDTH places, see `forget_noise`; changed.
    values : ndarray or tuple
        Force and torque as received [N], [N m].
    variance : ndarray, shape (6,)
        As stated [N^2], [N^2 m^2].
    in_air : bool
        Whether the peg is told to touch nothing.
    settings : Settings

    """
    m = memory
    if not in_air:
        m[AIR_SEEN], m[AIR_FORCE], m[AIR_TORQUE] = 0.0, 1.0, 1.0
    for part in range(2):
        square = 0.0
        for i in range(3 * part, 3 * part + 3):
            a, b, c = m[VALUES + i], m[VALUES + 6 + i], m[VALUES + 12 + i]
            third = values[i] - 3.0 * c + 3.0 * b - a
            square += third * third / (3.0 * _THIRD * variance[i])
            m[VALUES + i], m[VALUES + 6 + i], m[VALUES + 12 + i] = b, c, values[i]
        if m[SEEN] >= 3.0:
            _track(m, FORCE + part, square, settings.noise_most, settings)
            _track(m, WIDE_FORCE + part, square, 2.0 * BEYOND, settings)
            if in_air and m[AIR_SEEN] >= 3.0:
                _track(m, AIR_FORCE + part, square, settings.noise_most, settings)
    m[SEEN] += 1.0
    m[AIR_SEEN] += 1.0
    # Contacts chatter before they are told.
    rough = in_air and max(m[AIR_FORCE], m[AIR_TORQUE]) > NOISY
    m[AIR_ROUGH] = m[AIR_ROUGH] + 1.0 if rough else 0.0
    if in_air and not rough and m[AIR_SEEN] >= TOLD:
        m[CALM] = 1.0
    if m[SEEN] < TOLD:
        return
    for part in range(2):
        if m[WIDE_FORCE + part] > BEYOND:
            m[OFF_FORCE + part] = 1.0
        found = m[FORCE + part]
        if m[CALM] > 0.0:
            found = m[AIR_FORCE + part] if m[AIR_ROUGH] >= TOLD else 1.0
        if found < BROKEN * settings.noise_most:
            m[MOST_FORCE + part] = max(m[MOST_FORCE + part], found)


@compiled
def _track(memory, place, square, most, settings):
    """Track one ratio of variances, up to a bound, by a square over the stated variance."""
    ratio = memory[place]
    memory[place] = track_noise_ratio(ratio, square / ratio, most, settings)


@compiled
def factor(memory: np.ndarray) -> float:
    """Return by how much the variance is more than stated; 1 where it may be as stated."""
    most = max(memory[FORCE], memory[TORQUE])
    return most if most > NOISY else 1.0


@compiled
def is_off(memory: np.ndarray) -> bool:
    """Return whether the wrench is too rough for any noise."""
    return max(memory[WIDE_FORCE], memory[WIDE_TORQUE]) > BEYOND


def causes(memory: np.ndarray, variance: np.ndarray) -> list[str]:
    """Return what there is to say, a line for force and torque, by their stated variances."""
    told = []
    for part, (name, unit) in enumerate((("force", "N"), ("torque", "N m"))):
        most = memory.item(MOST_FORCE + part)
        if memory.item(OFF_FORCE + part):
            told.append(
                f"wrench: the {name} jumps by {sqrt(BEYOND):.0f} times and more its stated noise "
                f"from message to message: is it in {unit}, of one sensor? no contact is told"
            )
        elif most > NOISY:
            times, stated = sqrt(most), sqrt(variance.item(3 * part))
            told.append(
                f"wrench.{name}_stddev: the noise of the {name} is {times:.1f} times the "
                f"stated one, {times * stated:.2g} {unit} for {stated:.2g} {unit}: used as "
                "found"
            )
    return told
