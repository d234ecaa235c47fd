"""The noise of orientations as they show it themselves, where it is more than is stated."""

from math import exp, log, pi

import numpy as np

from peg_on_hole_ros.estimator.update import lower_root, over_root
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.record_types import SettingsRecord, StateRecord

# What white noise makes of a change between two innovations, squared, and of a third difference.
_CHANGE, _THIRD = 6.0, 60.0


@compiled
def follow_noise(s: StateRecord, o: SettingsRecord, q: np.ndarray, R: np.ndarray) -> None:
    """
    Follow by how much the variance of orientations is more than stated.

    Two things have to say so. Innovations change from one to the next, whether the filter believes
    them or not: what pushes them one way is no noise. And orientations themselves are rough, by
    their third differences: a wrench that drives a smooth motion astray is no noise either.

    Parameters
    ----------
    s : record of STATE
        With the innovation of the last orientation.
    o : record of SETTINGS
    q : ndarray, shape (3,)
        The last orientation [rad].
    R : ndarray, shape (3, 3)
        Its covariance as stated [rad^2].

    """
    change = 0.0
    for i in range(3):
        change += (s.innovation[i] - s.innovation_before[i]) ** 2
        s.innovation_before[i] = s.innovation[i]
    grow(s.noise, 1, change / _CHANGE, o)
    grow(s.noise, 2, _roughness(s.orientations, q, R) / (_THIRD * s.noise[2]), o)
    s.noise[0] = min(s.noise[1], s.noise[2])
    for i in range(3):
        s.orientations[0, i], s.orientations[1, i] = s.orientations[1, i], s.orientations[2, i]
        s.orientations[2, i] = q[i]


@compiled
def grow(noise: np.ndarray, i: int, seen: float, o: SettingsRecord) -> None:
    """Follow one variance by what was seen over what was expected; NaN: none came before."""
    grow_to(o.noise_most, noise, i, seen, o)


@compiled
def grow_to(most: float, noise: np.ndarray, i: int, seen: float, o: SettingsRecord) -> None:
    """Follow one variance as `grow`, up to so many times the stated one."""
    if not seen >= 0.0:
        return
    surplus = min(seen, o.outlier) - 1.0
    more = log(noise[i]) + surplus / o.noise_count
    noise[i] = exp(min(max(more, 0.0), log(most)))


@compiled
def _roughness(before, q, R):
    """Return the square of the third difference of orientations, over their covariance."""
    third, root = np.empty(3), R.copy()
    for i in range(3):
        last = before[2, i] - q[i]
        middle = before[1, i] - before[2, i]
        first = before[0, i] - before[1, i]
        if i > 0:
            last -= 2.0 * pi * np.round(last / (2.0 * pi))
            middle -= 2.0 * pi * np.round(middle / (2.0 * pi))
            first -= 2.0 * pi * np.round(first / (2.0 * pi))
        third[i] = first - 2.0 * middle + last
    lower_root(root, 3)
    return over_root(root, 3, third, third)
