"""Sigma points and particles at one wrench, against filterpy and against plain sampling."""

import numpy as np
import pytest
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter

import reference_equations as model
from compiled_beside import Compiled, cell_of, run, samples, with_scene
from peg_on_hole_ros.estimator.methods.registry import METHODS
from peg_on_hole_ros.estimator.state import FRICTION, OPEN_BEGIN
from peg_on_hole_ros.estimator.tuned import SLIP_FLOOR
from simulated import truth

# The first test of a process may have to compile the step.
pytestmark = pytest.mark.timeout(600)
WRENCHES = 60
SHARP = np.full(3, SLIP_FLOOR.least_scale_square**0.5)


class Beside(Compiled):
    """Keeps what the last wrench was weighed with."""

    def weigh(self, u, contacts=3):
        super().weigh(u, contacts)
        before, after = self.scratch, self.mixture
        w = self.cell.n + 3
        self.given = u, before.x[0, :w].copy(), before.P[0, :w, :w].copy()
        self.found = after.x[0].copy(), after.P[0].copy()


def weighed(method):
    recorded = truth("closing_with_slip")
    rows, noise = samples(recorded, count=WRENCHES)
    cell = cell_of(with_scene(recorded, friction_stddev=0.02), noise, **METHODS[method].settings)
    *_, last = run(Beside(cell, 1), rows)
    return cell, last


def balance(cell, x, u):
    """Return by how much the six equations do not hold, for friction along the slip."""
    return model._balance(cell, x, u, 0.0, SHARP)


def noise_at(cell, x, u):
    W = model.slopes(lambda u: balance(cell, x, u), u)
    return W @ cell.wrench_noise @ W.T


def test_sigma_points_are_filterpys():
    cell, last = weighed("unscented")
    (u, x, P), (x_after, P_after) = last.given, last.found
    points = MerweScaledSigmaPoints(len(x), 1.0, 2.0, 0.0)
    kalman = UnscentedKalmanFilter(len(x), 6, 0.0, lambda x: balance(cell, x, u), None, points)
    kalman.x, kalman.P = x.copy(), P.copy()
    kalman.sigmas_f = points.sigma_points(x, P)
    kalman.update(np.zeros(6), noise_at(cell, x, u))
    stddev = np.sqrt(np.diagonal(kalman.P))
    # In standard deviations; rounding leaves 1e-10.
    assert np.abs((x_after - kalman.x) / stddev).max() < 1e-8
    # filterpy takes from a variance of reactions what is 1e7 times what stays, by an inverse of
    # reactions and torques: that leaves 4e-5.
    apart = np.abs((P_after - kalman.P) / np.outer(stddev, stddev))
    assert apart[: cell.n, : cell.n].max() < 1e-8 and apart.max() < 1e-3
    # Tangents give something else.
    tangents = model.contact(cell, x, P, u, 0.0, np.zeros(3))[0]
    gain = P @ tangents.E.T @ np.linalg.inv(tangents.E @ P @ tangents.E.T + tangents.R)
    assert np.abs((x + gain @ tangents.residual - kalman.x) / stddev).max() > 1e-4


def test_particles_are_drawn_of_the_posterior():
    """Sampled plainly, with reactions in closed form, from what sigma points leave."""
    cell, last = weighed("particles_1000")
    (u, x, P), (x_after, _) = last.given, last.found
    n, prior = cell.n, P[cell.n, cell.n]
    assert n == OPEN_BEGIN
    random, count = np.random.default_rng(3), 3000
    middle, wide = x_after[:n], 2.0 * last.found[1][:n, :n]
    root = np.linalg.cholesky(wide)
    normal = random.standard_normal((count, n))
    points = middle + normal @ root.T
    points[:, FRICTION] = np.maximum(points[:, FRICTION], 0.0)
    information = np.linalg.inv(noise_at(cell, x_after, u))
    log, values = np.empty(count), np.empty((count, n + 3))
    before = np.linalg.cholesky(P[:n, :n])
    for k, point in enumerate(points):
        at = np.concatenate([point, x[n:]])
        off = balance(cell, at, u)
        G = np.column_stack([balance(cell, at + unit, u) - off for unit in np.eye(n + 3)[n:]])
        A = G.T @ information @ G + np.eye(3) / prior
        b = -G.T @ information @ off
        values[k] = np.concatenate([point, x[n:] + np.linalg.solve(A, b)])
        misfit = off @ information @ off - b @ np.linalg.solve(A, b)
        log[k] = -0.5 * (misfit + np.linalg.slogdet(A)[1])
        log[k] -= 0.5 * np.sum(np.linalg.solve(before, point - x[:n]) ** 2)
        log[k] += 0.5 * normal[k] @ normal[k]
    weight = np.exp(log - log.max())
    weight /= weight.sum()
    mean = weight @ values
    stddev = np.sqrt(weight @ (values - mean) ** 2)
    # Means of so many effective draws here and of a thousand there: five of their deviations.
    effective = 1.0 / np.sum(weight**2)
    assert effective > 100
    limit = 5.0 * np.sqrt(1.0 / effective + 1.0 / 300)
    # Reactions have a spread of their own beside that of the points.
    told = np.arange(n)
    assert np.all(np.abs(x_after - mean)[told] < limit * stddev[told])


def test_particles_are_the_same_in_every_run():
    one, other = (weighed("particles_100")[1].found for _ in range(2))
    for first, second in zip(one, other):
        np.testing.assert_array_equal(first, second)
