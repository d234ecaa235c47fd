"""Reactions of the reference filter, as `reactions` and `slow_reactions` have them."""

from math import erf

import numpy as np

from peg_on_hole_ros.estimation.kernel.acceleration import LEAST
from peg_on_hole_ros.estimation.kernel.parameters import LEAST_FRICTION
from peg_on_hole_ros.estimation.kernel.slow_friction import TURNING, UNSURE
from peg_on_hole_ros.estimation.kernel.slow_reactions import (
    CARRIED,
    HARDLY_KNOWN,
    LEAST_LOAD,
    LOWER,
    PASSES,
    UPPER,
    WEIGHED,
)
from peg_on_hole_ros.estimation.kernel.weighing import SURPRISE_LIMIT
from peg_on_hole_ros.estimation.reference.slip import bridged_scales, slip
from peg_on_hole_ros.estimation.reference.steps import (
    DIAMETER,
    FRICTION,
    RATES,
    SIZE,
    WRENCH,
    slopes_of_answer,
    solve,
    solve_with_slopes,
    with_parameters,
)
from peg_on_hole_ros.mechanics.geometry import contact_geometry, normals, velocity_jacobians
from peg_on_hole_ros.mechanics.reference import peg_axes, six_equations


def unknown_friction(kalman, normal, friction):
    """
    Return what friction of unknown direction makes of the answers, shape (6, 12).

    Parameters
    ----------
    kalman : ReferenceFilter
    normal : ndarray, shape (3,)
        Normal reactions at which friction is taken [N].
    friction : float
        Coefficient at which it is taken.

    """
    here = with_parameters(kalman.scene, friction, kalman.x[DIAMETER])
    g = contact_geometry(here, kalman.x[0])
    J = velocity_jacobians(g, here.peg_diameter, here.hole_diameter)
    A, _ = six_equations(here, kalman.x[:3], kalman.x[RATES], kalman.x[WRENCH], kalman.scales)
    speed, variance = slip(kalman)
    columns = []
    turned = np.minimum(UNSURE * kalman.across / (speed**2 + 1e-300), 1)
    for J_i, n, N, v, s2, t in zip(J, normals(g), normal, speed, variance, turned):
        mean = erf(v / np.sqrt(2 * s2 + 1e-300))
        force = np.hypot(friction, np.sqrt(kalman.P[FRICTION, FRICTION])) * max(N, 0.0)
        free = force * np.sqrt(TURNING * (1 - mean**2)) * (np.eye(3) - np.outer(n, n))
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
    if kalman.on_contacts and not kalman.slow:
        y, dy = solve_with_slopes(kalman.scene, kalman.x[:SIZE], kalman.scales)
        C = dy @ kalman.P[:SIZE, :SIZE] @ dy.T
        held = kalman.acceleration.covariance(acceleration_stddev, LEAST, kalman.since_correction)
        S = C[:3, :3] + held
        off = y[:3] - kalman.acceleration.mean
        if off @ np.linalg.solve(S, off) <= SURPRISE_LIMIT:
            gain = C[:, :3] @ np.linalg.inv(S)
            mean, C = y - gain @ off, C - gain @ C[:3, :]
            return mean[3:], C[3:, 3:]
    if not kalman.slow:
        kalman.scales = bridged_scales(kalman)
    return balanced_reactions(kalman, acceleration_stddev)


def balanced_reactions(kalman, acceleration_stddev):
    """
    Return reactions and covariance where no slip has a direction: a balance of forces with noise.

    The unknowns y of A y = r are weighed by least squares: against how a held peg accelerates, and
    against what state, wrench and friction leave unknown of A y - r where the last pass has y.
    What a friction that is hardly known makes of them is taken over two standard deviations.
    """
    friction, stddev = kalman.x[FRICTION], np.sqrt(kalman.P[FRICTION, FRICTION])
    mean, C, by_friction, surprise = _balanced(kalman, friction, acceleration_stddev)
    if stddev > HARDLY_KNOWN * friction:
        lower = max(friction - LOWER * stddev, LEAST_FRICTION)
        secant = (_balanced(kalman, lower, acceleration_stddev)[0] - mean) / LOWER
        if np.sum(secant[3:] ** 2) > np.sum(by_friction[3:] ** 2):
            C = C + np.outer(secant, secant) - np.outer(by_friction, by_friction)
    return mean[3:], C[3:, 3:] * max(1.0, surprise / SURPRISE_LIMIT)


def _balanced(kalman, friction, acceleration_stddev):
    """Return y, its covariance, what one deviation of friction makes of it, and the surprise."""
    full, P = kalman.x[:SIZE].copy(), kalman.P[:SIZE, :SIZE]
    full[FRICTION] = friction
    scene = kalman.scene
    answer, expected = solve(scene, full, kalman.scales), kalman.acceleration.mean
    held = kalman.acceleration.covariance(acceleration_stddev, LEAST, kalman.since_correction)
    force = full[WRENCH][:3] + peg_axes(full[:3]).T @ (scene.peg_mass * np.array(scene.gravity))
    load = np.linalg.norm(force) + 2 * np.linalg.norm(full[WRENCH][3:]) / full[DIAMETER]
    y = np.concatenate([expected, np.full(3, load)])
    holding = load * (1 + 1 / max(friction, LEAST_FRICTION))
    for _ in range(PASSES):
        dy = slopes_of_answer(scene, full, kalman.scales, y)
        columns = unknown_friction(kalman, y[3:], friction)
        by_slope, by_direction = dy @ P @ dy.T, columns @ columns.T
        weighed, noise = by_slope + WEIGHED * by_direction, by_slope + by_direction
        S = weighed[:3, :3] + held
        gain = weighed[:, :3] @ np.linalg.inv(S)
        off = answer[:3] - expected
        mean, left = answer - gain @ off, np.eye(6) - gain @ np.eye(3, 6)
        C = left @ noise @ left.T + gain @ held @ gain.T
        by_load = C[:, 3:] @ np.linalg.inv(C[3:, 3:] + holding**2 * np.eye(3))
        mean = mean + by_load @ (CARRIED * holding - mean[3:])
        kept = np.eye(6) - by_load @ np.eye(6)[3:]
        C, left = kept @ C, kept @ left
        upper = np.abs(mean[3:]) + UPPER * np.sqrt(np.diag(C)[3:])
        y = np.concatenate([mean[:3], np.maximum(upper, LEAST_LOAD * load)])
    by_friction = left @ dy @ P[:, FRICTION] / np.sqrt(P[FRICTION, FRICTION] + 1e-300)
    return mean, C, by_friction, off @ np.linalg.solve(S, off)
