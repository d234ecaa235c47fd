"""The noise of the wrench as it shows it itself, where it is more than is stated."""

from math import sqrt

import numpy as np

from peg_on_hole_ros.estimator.noise import grow, grow_to
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.record_types import SettingsRecord

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
# that was reached, and the last three values.
FORCE, TORQUE, SEEN, MOST_FORCE, MOST_TORQUE, WIDE_FORCE, WIDE_TORQUE, OFF_FORCE, OFF_TORQUE = (
    range(9)
)
VALUES = 9
WIDTH = VALUES + 18


@compiled
def forget_noise(memory: np.ndarray) -> None:
    """Take noise as stated, until it shows more; what was found most stays."""
    memory[VALUES:] = memory[SEEN] = 0.0
    memory[FORCE] = memory[TORQUE] = memory[WIDE_FORCE] = memory[WIDE_TORQUE] = 1.0


@compiled
def follow_wrench(
    memory: np.ndarray,
    values: np.ndarray | tuple[float, float, float],
    variance: np.ndarray,
    o: SettingsRecord,
) -> None:
    """
    Take a wrench with values that have not come before; the law is that of orientations.

    Parameters
    ----------
    memory : ndarray
        Of WIDTH places, see `forget_noise`; changed.
    values : ndarray or tuple
        Force and torque as received [N], [N m].
    variance : ndarray, shape (6,)
        As stated [N^2], [N^2 m^2].
    o : record of SETTINGS

    """
    m = memory
    for part in range(2):
        rough = 0.0
        for i in range(3 * part, 3 * part + 3):
            a, b, c = m[VALUES + i], m[VALUES + 6 + i], m[VALUES + 12 + i]
            third = values[i] - 3.0 * c + 3.0 * b - a
            rough += third * third / (3.0 * _THIRD * variance[i])
            m[VALUES + i], m[VALUES + 6 + i], m[VALUES + 12 + i] = b, c, values[i]
        if m[SEEN] >= 3.0:
            grow(m, FORCE + part, rough / m[FORCE + part], o)
            grow_to(2.0 * BEYOND, m, WIDE_FORCE + part, rough / m[WIDE_FORCE + part], o)
    m[SEEN] += 1.0
    if m[SEEN] < TOLD:
        return
    for part in range(2):
        if m[WIDE_FORCE + part] > BEYOND:
            m[OFF_FORCE + part] = 1.0
        if m[FORCE + part] < BROKEN * o.noise_most:
            m[MOST_FORCE + part] = max(m[MOST_FORCE + part], m[FORCE + part])


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
                f"from message to message: is it in {unit}? meanwhile no contact is told"
            )
        elif most > NOISY:
            times, stated = sqrt(most), sqrt(variance.item(3 * part))
            told.append(
                f"wrench.{name}_stddev: the noise of the {name} is {times:.1f} times the "
                f"stated one, {times * stated:.2g} {unit} for {stated:.2g} {unit}: used as "
                "found"
            )
    return told
