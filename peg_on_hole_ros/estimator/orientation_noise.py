"""The noise of orientations as they show it themselves, where it is more than is stated."""

from math import exp, log, pi

import numpy as np

from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.settings import Settings
from peg_on_hole_ros.estimator.state import State
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.linear_algebra import factor_cholesky, whiten
from peg_on_hole_ros.typed_record import Floats

# Variance of differences of white noise over its own: of the first difference (1 + 1), and of the
# third (1 + 9 + 9 + 1), of which a smooth motion leaves next to nothing.
FIRST_DIFFERENCE, THIRD_DIFFERENCE = 2.0, 20.0


@compiled
def track_orientation_noise(kalman: FilterRecord, q: Floats, R: Floats) -> None:
    """
    Track by how much the variance of orientations is more than stated.

    Two things have to show so. Innovations change from one to the next, whether the filter uses
    them or not: what pushes them one way is no noise. And orientations themselves are rough, by
    their third differences: a wrench that drives a smooth motion astray is no noise either.

    Parameters
    ----------
    kalman : FilterRecord
        With the innovation of the last orientation in its state.
    q : ndarray, shape (3,)
        The last orientation [rad].
    R : ndarray, shape (3, 3)
        Its covariance as stated [rad^2].

    """
    state, settings = kalman.state, kalman.settings
    most, change = settings.noise_most, 0.0
    for i in range(3):
        change += (state.innovation[i] - state.innovation_before[i]) ** 2
        state.innovation_before[i] = state.innovation[i]
    state.innovation_noise_ratio = track_noise_ratio(
        state.innovation_noise_ratio, change / (3.0 * FIRST_DIFFERENCE), most, settings
    )
    expected = 3.0 * THIRD_DIFFERENCE * state.roughness_noise_ratio
    seen = _roughness(state.orientations, q, R) / expected
    state.roughness_noise_ratio = track_noise_ratio(
        state.roughness_noise_ratio, seen, most, settings
    )
    state.noise_ratio = min(state.innovation_noise_ratio, state.roughness_noise_ratio)
    for i in range(3):
        state.orientations[0, i] = state.orientations[1, i]
        state.orientations[1, i] = state.orientations[2, i]
        state.orientations[2, i] = q[i]


@compiled
def forget_noise_ratio(state: State) -> None:
    """Assume the stated variance of orientations until they show more."""
    state.noise_ratio = 1.0
    state.innovation_noise_ratio = state.roughness_noise_ratio = 1.0


@compiled
def track_noise_ratio(ratio: float, seen: float, most: float, settings: Settings) -> float:
    """
    Return the ratio of a variance to the stated one after another sample.

    Parameters
    ----------
    ratio : float
        Before the sample.
    seen : float
        Square of the sample over what the ratio expects; NaN: none came before.
    most : float
        Bound of the ratio.
    settings : Settings

    """
    if not seen >= 0.0:
        return ratio
    surplus = min(seen, settings.outlier) - 1.0
    more = log(ratio) + surplus / settings.noise_count
    return exp(min(max(more, 0.0), log(most)))


@compiled
def _roughness(before: Floats, q: Floats, R: Floats) -> float:
    """Return the square of the third difference of orientations, over their covariance."""
    third, factor = np.empty(3), R.copy()
    for i in range(3):
        last = before[2, i] - q[i]
        middle = before[1, i] - before[2, i]
        first = before[0, i] - before[1, i]
        if i > 0:
            last -= 2.0 * pi * np.round(last / (2.0 * pi))
            middle -= 2.0 * pi * np.round(middle / (2.0 * pi))
            first -= 2.0 * pi * np.round(first / (2.0 * pi))
        third[i] = first - 2.0 * middle + last
    factor_cholesky(factor, 3)
    return whiten(factor, 3, third, third)
