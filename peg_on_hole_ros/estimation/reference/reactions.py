"""Reactions of the reference filter, as `reactions` and `slow_friction` have them."""

from math import erf

import numpy as np

from peg_on_hole_ros.estimation.kernel.acceleration import LEAST
from peg_on_hole_ros.estimation.kernel.reactions import SURPRISE_LIMIT
from peg_on_hole_ros.estimation.kernel.slow_friction import UNSURE
from peg_on_hole_ros.estimation.reference.steps import (
    DIAMETER,
    FRICTION,
    RATES,
    SIZE,
    WRENCH,
    solve,
    solve_with_slopes,
    with_parameters,
)
from peg_on_hole_ros.mechanics.geometry import contact_geometry, normals, velocity_jacobians
from peg_on_hole_ros.mechanics.reference import six_equations


def unknown_friction(kalman, normal):
    """
    Return what friction of unknown direction makes of the answers, shape (6, 12).

    Parameters
    ----------
    kalman : ReferenceFilter
    normal : ndarray, shape (3,)
        Normal reactions at the estimate [N].

    """
    here = with_parameters(kalman.scene, kalman.x[FRICTION], kalman.x[DIAMETER])
    g = contact_geometry(here, kalman.x[0])
    J = velocity_jacobians(g, here.peg_diameter, here.hole_diameter)
    A, _ = six_equations(here, kalman.x[:3], kalman.x[RATES], kalman.x[WRENCH], kalman.scales)
    speed, variance = kalman.slip()
    columns = []
    turned = np.minimum(UNSURE * kalman.across / (speed**2 + 1e-300), 1)
    for J_i, n, N, v, s2, t in zip(J, normals(g), normal, speed, variance, turned):
        mean = erf(v / np.sqrt(2 * s2 + 1e-300))
        friction = np.hypot(kalman.x[FRICTION], np.sqrt(kalman.P[FRICTION, FRICTION]))
        force = friction * max(N, 0.0)
        free = force * np.sqrt(1 - mean**2) * (np.eye(3) - np.outer(n, n))
        T = np.column_stack([free, force * mean * t * J_i @ kalman.x[RATES] / (v + 1e-300)])
        columns.append(np.linalg.solve(A, np.vstack([J_i.T @ T, T])))
    return np.hstack(columns)


def reactions(kalman, acceleration_stddev):
    """
    Return normal reactions [N], weighed with the accelerations' prior, and covariance.

    Parameters
    ----------
    kalman : ReferenceFilter
    acceleration_stddev : float
        How a held peg may accelerate [rad/s^2].

    """
    y, dy = solve_with_slopes(kalman.scene, kalman.x[:SIZE], kalman.scales)
    C = dy @ kalman.P[:SIZE, :SIZE] @ dy.T
    held = kalman.acceleration.covariance(acceleration_stddev, LEAST, kalman.since_correction)
    inverse = np.linalg.inv(C[:3, :3] + held)
    gain = C[:, :3] @ inverse
    C = C - gain @ C[:3, :]
    answers = [y]
    for column in np.linalg.cholesky(kalman.P[RATES, RATES]).T:
        for sign in (1, -1):
            moved = kalman.x[:SIZE].copy()
            moved[RATES] += sign * column
            answers.append(solve(kalman.scene, moved, kalman.scales))
    answers = np.array(answers)
    off = answers[:, :3] - kalman.acceleration.mean
    surprise = np.einsum("ni,ij,nj->n", off, inverse, off)
    points = answers - off @ gain.T
    mean, least, spread = points[0], surprise[0], np.zeros((6, 6))
    if least > SURPRISE_LIMIT:
        least = surprise.min()
        weights = np.exp((least - surprise) / 2)
        weights /= weights.sum()
        mean = weights @ points
        spread = (points - mean).T @ np.diag(weights) @ (points - mean)
    C = (C + spread) * max(1.0, least / SURPRISE_LIMIT)
    for n in (1, 3, 5):
        bend = points[n : n + 2].mean(axis=0) - points[0]
        C = C + np.outer(bend, bend)
    if kalman.slow:
        columns = unknown_friction(kalman, y[3:])
        columns = columns - gain @ columns[:3]
        C = C + columns @ columns.T
    return mean[3:], C[3:, 3:]
