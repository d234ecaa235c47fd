"""The same filter by filterpy on the numpy model: slow, readable, and what the kernel answers to."""

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from peg_on_hole_ros.mechanics.reference import six_equations
from peg_on_hole_ros.mechanics.scene import Scene

STATE, WRENCH, RATES = slice(0, 6), slice(6, 12), slice(3, 6)
_NEWTON_TOLERANCE = 1e-12
_COMPLEX_STEP = 1e-30


def solve_with_slopes(scene: Scene, x, u, slip_velocity_scale):
    """
    Return accelerations and reactions, and their derivatives by a complex step.

    Parameters
    ----------
    scene : Scene
    x, u : ndarray, shape (6,)
        State and wrench, peg axes.
    slip_velocity_scale : float
        [m/s].

    Returns
    -------
    y : ndarray, shape (6,)
    dy : ndarray, shape (6, 12)

    """

    def solve(xu):
        A, r = six_equations(scene, xu[:3], xu[3:6], xu[6:], slip_velocity_scale)
        return np.linalg.solve(A, r)

    xu = np.concatenate([x, u])
    dy = np.empty((6, 12))
    for i in range(12):
        moved = xu.astype(complex)
        moved[i] += 1j * _COMPLEX_STEP
        dy[:, i] = solve(moved).imag / _COMPLEX_STEP
    return solve(xu), dy


def implicit_euler(scene: Scene, x, u, h, slip_velocity_scale):
    """
    Return the state after one implicit Euler step, and its derivatives by state and wrench.

    The rates v at the end solve v = v0 + h a(q0 + h v, v, u), here by Newton's method on the
    numpy model, its step halved until the residual falls.

    Returns
    -------
    x1 : ndarray, shape (6,)
    F : ndarray, shape (6, 12)

    """
    v = x[RATES]

    def residual(v):
        state = np.concatenate([x[:3] + h * v, v])
        y, dy = solve_with_slopes(scene, state, u, slip_velocity_scale)
        return v - x[RATES] - h * y[:3], dy[:3]

    r, slopes = residual(v)
    for _ in range(50):
        matrix = np.eye(3) - h * (slopes[:, RATES] + h * slopes[:, :3])
        if np.linalg.norm(r) <= _NEWTON_TOLERANCE:
            break
        step = np.linalg.solve(matrix, -r)
        fraction = 1.0
        while True:
            trial, trial_slopes = residual(v + fraction * step)
            if np.linalg.norm(trial) < np.linalg.norm(r) or fraction < 1e-4:
                break
            fraction /= 2
        if fraction < 1e-4:
            break
        v, r, slopes = v + fraction * step, trial, trial_slopes
    by_rates = np.linalg.solve(
        matrix, np.hstack([h * slopes[:, :3], np.eye(3), h * slopes[:, WRENCH]])
    )
    by_angles = np.hstack([np.eye(3), np.zeros((3, 9))]) + h * by_rates
    return np.concatenate([x[:3] + h * v, v]), np.vstack([by_angles, by_rates])


class ReferenceFilter(ExtendedKalmanFilter):
    """
    The contact filter with the held wrench as six more states, which restart with each wrench.

    Parameters
    ----------
    scene : Scene
    slip_velocity_scale : float
        [m/s].
    rate_noise : float
        Random walk of each rate per root of a second [rad/s].
    wrench_noise : ndarray, shape (6, 6)

    """

    def __init__(self, scene, slip_velocity_scale, rate_noise, wrench_noise):
        super().__init__(dim_x=12, dim_z=3)
        self.scene = scene
        self.slip_velocity_scale = slip_velocity_scale
        self.rate_noise = rate_noise
        self.wrench_noise = wrench_noise

    def hold(self, u):
        """Hold a new wrench."""
        self.x[WRENCH] = u
        self.P[WRENCH, :] = self.P[:, WRENCH] = 0
        self.P[WRENCH, WRENCH] = self.wrench_noise

    def predict_contact(self, dt):
        """Predict over dt [s] by filterpy's own covariance equation."""
        x1, F = implicit_euler(
            self.scene, self.x[STATE], self.x[WRENCH], dt, self.slip_velocity_scale
        )
        self._motion = x1
        self.F = np.vstack([F, np.hstack([np.zeros((6, 6)), np.eye(6)])])
        # A random walk of the rates; the implicit step moves the angle with the rate at its end.
        carried = np.zeros((12, 3))
        carried[:3], carried[RATES] = dt * np.eye(3), np.eye(3)
        self.Q = self.rate_noise**2 * dt * carried @ carried.T
        self.predict()

    def predict_x(self, u=0):
        """Put the implicit step where filterpy puts F x."""
        self.x = np.concatenate([self._motion, self.x[WRENCH]])

    def correct(self, q, R):
        """Correct with an orientation q [rad] of covariance R by filterpy's update."""
        H = np.hstack([np.eye(3), np.zeros((3, 9))])
        self.update(q, lambda x: H, lambda x: H @ x, R=R)

    def reactions(self, acceleration_stddev):
        """Return normal reactions [N] and their covariance, weighed with the accelerations' prior."""
        y, dy = solve_with_slopes(
            self.scene, self.x[STATE], self.x[WRENCH], self.slip_velocity_scale
        )
        C = dy @ self.P @ dy.T
        gain = C[:, :3] @ np.linalg.inv(C[:3, :3] + acceleration_stddev**2 * np.eye(3))
        y = y - gain @ y[:3]
        C = C - gain @ C[:3, :]
        return y[3:], C[3:, 3:]
