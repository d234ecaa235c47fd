"""How a held peg moves on: its accelerations fade, and are driven to a level."""

from math import cos, exp, sin

import numpy as np

from peg_on_hole_ros.estimator.state import ACCELERATION, ANGLE, FRICTION, RATE
from peg_on_hole_ros.mechanics.kernel import compiled

_LEAST_SINE2 = 1e-8


@compiled
def move_on(
    x: np.ndarray, P: np.ndarray, n: int, dt: float, level: float, time: float, around_axes: float,
    walk: np.ndarray,
) -> None:  # fmt: skip
    """
    Predict one component over a time.

    Parameters
    ----------
    x : ndarray, shape (n + 3,)
        Changed.
    P : ndarray, shape (n + 3, n + 3)
        Changed; the rows of the reactions stay.
    n : int
        How many values are carried on.
    dt : float
        [s].
    level, time, around_axes : float
        See `Settings`.
    walk : ndarray, shape (n,)
        Variance that each value gains in a second, beside that of the motion.

    """
    k = exp(-dt / time)
    half = 0.5 * dt
    for i in range(3):
        x[i] += dt * (x[RATE + i] + half * x[ACCELERATION + i])
        x[RATE + i] += dt * x[ACCELERATION + i]
        x[ACCELERATION + i] *= k
    for i in range(3):
        for j in range(n):
            P[i, j] += dt * (P[RATE + i, j] + half * P[ACCELERATION + i, j])
            P[RATE + i, j] += dt * P[ACCELERATION + i, j]
            P[ACCELERATION + i, j] *= k
    for j in range(n):
        for i in range(3):
            P[j, i] += dt * (P[j, RATE + i] + half * P[j, ACCELERATION + i])
            P[j, RATE + i] += dt * P[j, ACCELERATION + i]
            P[j, ACCELERATION + i] *= k
    drive(x, P, dt, level, time, around_axes)
    for j in range(FRICTION, n):
        P[j, j] += walk[j] * dt


@compiled
def drive(
    x: np.ndarray, P: np.ndarray, dt: float, level: float, time: float, around_axes: float
) -> None:
    """Add what a level's white noise, in each angle and about any axis, makes of the motion."""
    s, c = sin(x[ANGLE]), cos(x[ANGLE])
    density = 2.0 / time * level * level
    turning = around_axes * around_axes * density / max(s * s, _LEAST_SINE2)
    d2, d3 = dt * dt / 2.0, dt * dt * dt / 3.0
    d4, d5, d6 = dt**4 / 8.0, dt**5 / 20.0, dt**3 / 6.0
    for i in range(3):
        for j in range(3):
            q = density if i == j else 0.0
            if i > 0 and j > 0:
                q += turning if i == j else -c * turning
            if q == 0.0:
                continue
            P[ACCELERATION + i, ACCELERATION + j] += q * dt
            P[RATE + i, ACCELERATION + j] += q * d2
            P[ACCELERATION + i, RATE + j] += q * d2
            P[RATE + i, RATE + j] += q * d3
            P[i, RATE + j] += q * d4
            P[RATE + i, j] += q * d4
            P[i, ACCELERATION + j] += q * d6
            P[ACCELERATION + i, j] += q * d6
            P[i, j] += q * d5
