"""One prediction as a function, with its derivatives: what the slower filters are made of."""

from math import asin, sqrt

import numpy as np

from peg_on_hole_ros.estimation.kernel.memory import part
from peg_on_hole_ros.estimation.kernel.parameters import (
    LEAST_CLEARANCE,
    LEAST_FRICTION,
    MOST_FRICTION,
)
from peg_on_hole_ros.estimation.kernel.tangent import tangent_at
from peg_on_hole_ros.estimation.steps.choice import SECOND_ORDER, take_step
from peg_on_hole_ros.estimation.steps.implicit_euler import CONVERGED
from peg_on_hole_ros.estimation.steps.second_order import SHARE
from peg_on_hole_ros.mechanics.kernel import WIDTH, SceneScalars, workspace

# State (6), wrench (6), friction, peg diameter.
RATES, FRICTION, DIAMETER = slice(3, 6), 12, 13


def _gamma0(hole, peg):
    return 2.0 * asin(sqrt((hole - peg) / (2.0 * hole)))


def joint_mean(kalman) -> np.ndarray:
    """Return state, held wrench, friction and peg diameter of a filter, shape (14,)."""
    return np.concatenate([kalman.x, kalman.u, [kalman.friction[0], kalman.peg_diameter[0]]])


def joint_estimate(kalman) -> tuple[np.ndarray, np.ndarray]:
    """Return `joint_mean` and its covariance, shape (14, 14)."""
    return joint_mean(kalman), kalman.joint_covariance()


def set_joint(kalman, mean, P) -> None:
    """Give a filter a joint mean, shape (14,), and covariance, shape (14, 14)."""
    kalman.x[:], kalman.u[:] = mean[:6], mean[6:12]
    scene = kalman.scene_values
    if mean[FRICTION] != scene[7]:
        scene[7] = min(max(mean[FRICTION], LEAST_FRICTION), MOST_FRICTION)
    if mean[DIAMETER] != scene[0]:
        scene[0] = min(mean[DIAMETER], scene[1] - LEAST_CLEARANCE)
        scene[3] = _gamma0(scene[1], scene[0])
    P = (P + P.T) / 2
    kalman.Z[:], kalman.spread[:] = P[:12, :12], P[12:, 12:]
    part(kalman._memory, "CROSS", (2, 12))[:] = P[12:, :12]


class Flow:
    """
    The motion over the last contact prediction of a filter, from any joint state.

    Velocity scales of friction, number of steps, added noise, and rates at which its tangents are
    taken if they are its mean rates, are those of that prediction.

    Parameters
    ----------
    kalman : ContactFilter
        Right after a prediction whose outcome was CONTACT.
    dt : float
        [s].

    """

    def __init__(self, kalman, dt: float):
        memory, self.process = kalman._memory, kalman.process
        self._integrator = int(part(memory, "METHOD_USED").item())
        self.second_order = self._integrator == SECOND_ORDER
        self._ramp = part(memory, "RAMP").copy()
        self._scalars = SceneScalars(*kalman.scene_values.tolist())
        self.pieces, self.h = kalman.pieces, dt / kalman.pieces
        self._scales = part(memory, "SCALES").copy()
        at_mean = part(memory, "AT_MEAN").item()
        self._mean_rates = part(memory, "MEAN_RATES").copy() if at_mean else None
        self.jumped = np.zeros(WIDTH)
        self.jumped[:6] = part(memory, "JUMPED")
        self.wander = self.process.friction_density * dt if kalman.spread[0, 0] > 0 else 0.0
        self._buffers = np.zeros((6, WIDTH)), np.zeros((6, WIDTH)), np.zeros(96), workspace()

    def _scene(self, full):
        s = self._scalars
        if full[FRICTION] == s.f and full[DIAMETER] == s.d:
            return s
        diameter = min(full[DIAMETER], s.D - LEAST_CLEARANCE)
        friction = max(full[FRICTION], LEAST_FRICTION)
        return s._replace(f=friction, d=diameter, gamma0=_gamma0(s.D, diameter))

    def step(self, full, piece=0):
        """
        Return the joint state after one of the steps, and its derivatives.

        Parameters
        ----------
        full : ndarray, shape (14,)
            State, wrench, friction, peg diameter.
        piece : int
            Which of the steps.

        Returns
        -------
        end : ndarray, shape (14,), or None where there is no step
        F : ndarray, shape (14, 14)

        """
        dy, slopes, stage, work = self._buffers
        x1, y = np.zeros(6), np.zeros(6)
        status, _ = take_step(
            self._integrator, self._scene(full), self._scales, full[:6].copy(),
            self._wrench(full, piece + SHARE), self._wrench(full, piece + 1),
            self.h, x1, y, dy, slopes, stage, work,
        )  # fmt: skip
        if status != CONVERGED:
            return None, None
        if self._mean_rates is not None:
            tangent_at(
                self._scene(full), self._mean_rates, self._scales, x1,
                self._wrench(full, piece + 1), self.h, dy, slopes, stage, work,
            )  # fmt: skip
        F = np.eye(WIDTH)
        F[:3] = slopes[3:] if self.second_order else F[:3] + self.h * slopes[:3]
        F[RATES] = slopes[:3]
        return np.concatenate([x1, full[6:]]), F

    def _wrench(self, full, step):
        begin, end = self._ramp[6:]
        left = 1.0 - begin - (end - begin) * step / self.pieces
        return full[6:12] - left * self._ramp[:6]

    def walk(self):
        """Return a factor of what the rates' random walk adds in one step, shape (14, 6)."""
        noise = np.full(3, np.sqrt(self.process.rate_density))
        if self.second_order:
            return walk_factor(noise, self.h)
        factor = np.zeros((WIDTH, 6))
        # The implicit step moves the angle with the rate at its end.
        factor[:3, :3] = np.sqrt(self.h) * self.h * np.diag(noise)
        factor[RATES, :3] = np.sqrt(self.h) * np.diag(noise)
        return factor

    def added(self):
        """Return the variances that are added at the end of the prediction, shape (14,)."""
        variance = np.zeros(WIDTH)
        variance[FRICTION] = self.wander
        return variance

    def __call__(self, full):
        """
        Return the end of the whole prediction and its derivatives as `step`, and the noise.

        Returns
        -------
        end : ndarray, shape (14,), or None
        F : ndarray, shape (14, 14)
        noise : ndarray, shape (14, 14)
            Covariance that the prediction adds.

        """
        total, noise = np.eye(WIDTH), np.zeros((WIDTH, WIDTH))
        walk = self.walk() @ self.walk().T
        for piece in range(self.pieces):
            full, F = self.step(full, piece)
            if full is None:
                return None, None, None
            total = F @ total
            noise = F @ noise @ F.T + walk
        noise += np.diag(self.added()) + np.outer(self.jumped, self.jumped)
        return full, total, noise


def walk_factor(noise, h):
    """
    Return a factor of the covariance that a random walk of the rates adds over a time.

    Parameters
    ----------
    noise : ndarray, shape (3,)
        Of each rate [rad/s^1.5].
    h : float
        [s].

    Returns
    -------
    ndarray, shape (14, 6)

    """
    factor, root = np.zeros((WIDTH, 6)), np.sqrt(h) * np.diag(noise)
    factor[RATES, :3], factor[:3, :3] = root, root * h / 2
    factor[:3, 3:] = root * h / np.sqrt(12.0)
    return factor


def scaled_gain(C, P):
    """
    Return C inv(P), with P (n, n) brought to unit diagonal first: its units differ widely.

    What has no variance is known, and tells nothing.
    """
    scale = np.sqrt(np.diagonal(P))
    known = scale == 0
    scale = np.where(known, 1.0, scale)
    scaled = P / np.outer(scale, scale) + np.diag(known.astype(float))
    return np.linalg.solve(scaled, (C / scale).T).T / scale
