"""Kalman's update of one component, by an orientation and by the six equations."""

from math import atan2, cos, log, pi, sin, sqrt

import numpy as np

from peg_on_hole_ros.estimator.state import DELAY, FRICTION, RATE, TILT
from peg_on_hole_ros.mechanics.kernel import compiled

_LEAST_PIVOT = 1e-300
# A variance that a subtraction leaves below this share of what it was is rounding.
_ROUNDING = 1e-15


@compiled
def lower_root(S: np.ndarray, k: int) -> None:
    """Turn a covariance (k, k), of which the lower half is read, into its lower root."""
    for a in range(k):
        least = max(_ROUNDING * S[a, a], _LEAST_PIVOT)
        for c in range(a + 1):
            t = S[a, c]
            for q in range(c):
                t -= S[a, q] * S[c, q]
            S[a, c] = sqrt(max(t, least)) if a == c else t / S[c, c]


@compiled
def over_root(root: np.ndarray, k: int, residual: np.ndarray, white: np.ndarray) -> float:
    """Fill in a residual (k,) over a lower root; return the square of its length."""
    square = 0.0
    for a in range(k):
        t = residual[a]
        for q in range(a):
            t -= root[a, q] * white[q]
        white[a] = t / root[a, a]
        square += white[a] * white[a]
    return square


@compiled
def update(
    P: np.ndarray, w: int, learnt: np.ndarray, least_friction: float, residual: np.ndarray,
    E: np.ndarray, R: np.ndarray, k: int, root: np.ndarray, gain: np.ndarray, white: np.ndarray,
    step: np.ndarray,
) -> tuple[float, float]:  # fmt: skip
    """
    Update a covariance by a residual r = E (truth - mean) + noise.

    Parameters
    ----------
    P : ndarray, shape (w, w)
        Changed.
    w : int
        How many values there are.
    learnt : ndarray, shape (w,)
        0 for a value that is considered: it widens all others, and is not corrected (Schmidt).
    least_friction : float
        Variance below which friction is learnt no better, by a part of its gain.
    residual : ndarray, shape (k,)
    E : ndarray, shape (k, w)
    R : ndarray, shape (k, k)
    k : int
        How many residuals there are, at most 6.
    root, gain, white : ndarray
        Filled: lower root of the innovation's covariance, P E' over it, and the residual over it.
    step : ndarray, shape (w,)
        Filled with what is to be added to the mean.

    Returns
    -------
    log_likelihood, nis : float

    """
    # Innermost loops go along rows, which compilers make vectors of.
    for a in range(k):
        row = gain[a]
        for i in range(w):
            row[i] = 0.0
        for j in range(w):
            slope = E[a, j]
            if slope != 0.0:
                for i in range(w):
                    row[i] += slope * P[j, i]
        for c in range(a + 1):
            t = R[a, c]
            for j in range(w):
                t += E[a, j] * gain[c, j]
            root[a, c] = t
    lower_root(root, k)
    nis, log_root = over_root(root, k, residual, white), 0.0
    for i in range(w):
        step[i] = 0.0
    for a in range(k):
        log_root += log(root[a, a])
        row, over = gain[a], 1.0 / root[a, a]
        for q in range(a):
            t, other = root[a, q], gain[q]
            for i in range(w):
                row[i] -= t * other[i]
        for i in range(w):
            row[i] *= over
            step[i] += row[i] * white[a]
    for i in range(w):
        step[i] *= learnt[i]
        line, least = P[i], _ROUNDING * P[i, i]
        for a in range(k):
            t, row = gain[a, i], gain[a]
            if learnt[i] > 0.0:
                for j in range(i + 1):
                    line[j] -= t * row[j]
            else:
                for j in range(i + 1):
                    line[j] -= learnt[j] * t * row[j]
        line[i] = max(line[i], least)
        for j in range(i):
            P[j, i] = line[j]
    if learnt[FRICTION] > 0.0:
        _keep_doubt(P, w, learnt, k, least_friction, gain, step)
    return -0.5 * nis - log_root, nis


@compiled
def _keep_doubt(P, w, learnt, k, least, gain, step):
    """Take back the part of friction's gain that has made it surer than is allowed."""
    told = 0.0
    for a in range(k):
        told += gain[a, FRICTION] * gain[a, FRICTION]
    after = P[FRICTION, FRICTION]
    if after >= least or told <= 0.0:
        return
    before, share = after + told, 0.0
    if before > least:
        share = 1.0 - sqrt(max(1.0 - (before - least) / told, 0.0))
    step[FRICTION] *= share
    P[FRICTION, FRICTION] = before - (2.0 * share - share * share) * told
    for i in range(w):
        # With what is learnt, the full gain of that makes it depend on friction no less.
        if learnt[i] == 0.0:
            for a in range(k):
                P[FRICTION, i] += (1.0 - share) * gain[a, FRICTION] * gain[a, i]
            P[i, FRICTION] = P[FRICTION, i]


@compiled
def orientation_slopes(x: np.ndarray, at: np.ndarray, w: int, E: np.ndarray) -> None:
    """
    Fill in how the residual of an orientation moves with the values.

    A hole that is tilted by (t_x, t_y) is measured as a peg that is turned by them; one that is
    stamped too late by a delay is where the peg was.
    """
    for i in range(3):
        for j in range(w):
            E[i, j] = 0.0
        E[i, i] = 1.0
    if at[TILT] >= 0:
        j = at[TILT]
        s, c = sin(x[1]), cos(x[1])
        over = 1.0 / max(sin(x[0]), 1e-6)
        E[0, j], E[0, j + 1] = s, -c
        E[2, j], E[2, j + 1] = -c * over, -s * over
        E[1, j], E[1, j + 1] = cos(x[0]) * c * over, cos(x[0]) * s * over
    if at[DELAY] >= 0:
        for i in range(3):
            E[i, at[DELAY]] = -x[RATE + i]


@compiled
def orientation_residual(
    x: np.ndarray, at: np.ndarray, q: np.ndarray, E: np.ndarray, residual: np.ndarray
) -> None:
    """Fill in an orientation less what is expected of it; psi and phi may be off by turns."""
    seen = (q[0], q[1], q[2])
    if at[TILT] >= 0:
        seen = _turned_back(seen, x[at[TILT]], x[at[TILT] + 1])
    for i in range(3):
        t = seen[i] - x[i]
        if at[DELAY] >= 0:
            t -= E[i, at[DELAY]] * x[at[DELAY]]
        if i > 0:
            t -= 2.0 * pi * np.round(t / (2.0 * pi))
        residual[i] = t


@compiled
def _turned_back(q, t_x, t_y):
    """Return gamma, psi, phi in the axes of a hole that is turned by (t_x, t_y, 0) [rad]."""
    s, c, sps, cps, sp, cp = sin(q[0]), cos(q[0]), sin(q[1]), cos(q[1]), sin(q[2]), cos(q[2])
    turn2 = t_x * t_x + t_y * t_y
    turn = sqrt(turn2)
    a = sin(turn) / turn if turn > 0.0 else 1.0
    b = 2.0 * (sin(0.5 * turn) / turn) ** 2 if turn > 0.0 else 0.5
    # The peg's axis in the hole's axes, then the hole's in the peg's.
    x, y, z = -cps * s, -sps * s, c
    axis_x = x - a * t_y * z - b * t_y * (t_y * x - t_x * y)
    axis_y = y + a * t_x * z + b * t_x * (t_y * x - t_x * y)
    axis_z = z + a * (t_y * x - t_x * y) - b * turn2 * z
    up_x = s * cp * (1.0 - b * turn2) + a * (
        t_y * (cps * c * cp - sps * sp) - t_x * (sps * c * cp + cps * sp)
    )
    up_y = -s * sp * (1.0 - b * turn2) - a * (
        t_y * (cps * c * sp + sps * cp) - t_x * (sps * c * sp - cps * cp)
    )
    return (
        atan2(sqrt(up_x * up_x + up_y * up_y), axis_z),
        atan2(-axis_y, -axis_x),
        atan2(-up_y, up_x),
    )
