"""What the holder is told to do: angles and offset as quintics, smooth to the acceleration."""

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.mechanics.compiling import compiled


def quintic(start: ArrayLike, end: ArrayLike, duration: float) -> np.ndarray:
    """
    Return the coefficients of the quintic between two values, rates and accelerations.

    Parameters
    ----------
    start, end : array_like, shape (3, ...)
        Value, rate, acceleration.
    duration : float
        [s]

    Returns
    -------
    ndarray, shape (..., 6)
        Of 1, t, .. t^5.

    """
    start, end, T = np.asarray(start, float), np.asarray(end, float), float(duration)
    c0, c1, c2 = start[0], start[1], start[2] / 2
    position = end[0] - (c0 + T * (c1 + T * c2))
    rate = end[1] - (c1 + 2 * T * c2)
    acceleration = end[2] - 2 * c2
    c3 = (10 * position - 4 * T * rate + T**2 * acceleration / 2) / T**3
    c4 = (-15 * position + 7 * T * rate - T**2 * acceleration) / T**4
    c5 = (6 * position - 3 * T * rate + T**2 * acceleration / 2) / T**5
    return np.stack([c0, c1, c2, c3, c4, c5], axis=-1)


@compiled
def evaluate(knots: np.ndarray, coefficients: np.ndarray, t: float) -> np.ndarray:
    """
    Return value, rate and acceleration of every channel at a time.

    Channels: gamma, psi, phi [rad], offset along h, e, z from the touching pose [m].

    Parameters
    ----------
    knots : ndarray, shape (n + 1,)
        Where the pieces begin, and where the last ends [s]; beyond, the end pieces go on.
    coefficients : ndarray, shape (n, channels, 6)
    t : float
        [s]

    Returns
    -------
    ndarray, shape (3, channels)

    """
    k = min(max(np.searchsorted(knots, t, side="right") - 1, 0), coefficients.shape[0] - 1)
    x = t - knots[k]
    n = coefficients.shape[1]
    out = np.empty((3, n))
    for i in range(n):
        c = coefficients[k, i]
        out[0, i] = c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * (c[4] + x * c[5]))))
        out[1, i] = c[1] + x * (2 * c[2] + x * (3 * c[3] + x * (4 * c[4] + x * 5 * c[5])))
        out[2, i] = 2 * c[2] + x * (6 * c[3] + x * (12 * c[4] + x * 20 * c[5]))
    return out
