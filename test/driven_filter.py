"""The design card's filter: the peg's differential equations driven by the measured wrench."""

import numpy as np
from filterpy.kalman import KalmanFilter

from peg_on_hole_ros.mechanics.geometry import contact_geometry, velocity_jacobians
from peg_on_hole_ros.mechanics.reference import six_equations
from reference_equations import slopes

# Coulomb's law: a speed at which no peg slides [m/s].
SCALE = 1e-8


class DrivenFilter(KalmanFilter):
    """
    Angles and rates; a wrench is held until the next, its noise is the process noise.

    Parameters
    ----------
    cell : Cell
        Its scene, friction known, and the noise of the wrench.

    """

    def __init__(self, cell):
        super().__init__(dim_x=6, dim_z=3)
        self.cell, self.H, self.held = cell, np.eye(3, 6), np.zeros(6)

    def start(self, q, R, rate_stddev, *_):
        self.x = np.array([*q, 0.0, 0.0, 0.0])
        self.P = np.zeros((6, 6))
        self.P[:3, :3], self.P[3:, 3:] = R, rate_stddev**2 * np.eye(3)

    def answer(self, x, u):
        """Return accelerations [rad/s^2] and reactions [N] at a state with a wrench."""
        A, r = six_equations(self.cell.scene, x[:3], x[3:], u, SCALE)
        return np.linalg.solve(A, r)

    def predict(self, dt):
        def moved(xu):
            x, a = xu[:6], self.answer(xu[:6], xu[6:])[:3]
            rates = x[3:] + dt * a
            return np.concatenate([x[:3] + dt * x[3:] + dt**2 / 2 * a, rates])

        at = np.concatenate([self.x, self.held])
        by = slopes(moved, at)
        self.F, G = by[:, :6], by[:, 6:]
        self.Q = G @ self.cell.wrench_noise @ G.T
        P = self.P
        self.x = moved(at)
        self.P = self.F @ P @ self.F.T + self.Q

    def correct(self, q, R):
        z = np.array(q)
        z[1:] -= 2 * np.pi * np.round((z[1:] - self.x[1:3]) / (2 * np.pi))
        self.update(z, R)

    def weigh(self, u, contacts=3):
        self.held = u

    @property
    def growth(self):
        """By how much the last step let an error of the rates grow: above 1 it is unstable."""
        return np.abs(np.linalg.eigvals(self.F[3:, 3:])).max()

    def slips(self):
        """Return speed and its standard deviation at K, B1, B2 [m/s]."""
        scene = self.cell.scene
        g = contact_geometry(scene, self.x[0])
        J = velocity_jacobians(g, scene.peg_diameter, scene.hole_diameter)
        v = J @ self.x[3:]
        speed = np.linalg.norm(v, axis=1)
        along = np.einsum("ic,icj->ij", v / speed[:, None], J)
        return speed, np.sqrt(np.einsum("ij,jk,ik->i", along, self.P[3:, 3:], along))
