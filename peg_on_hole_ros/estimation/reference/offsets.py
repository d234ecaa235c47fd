"""The reference filter with bias and hole tilt as further states of filterpy's."""

from dataclasses import replace

import numpy as np
from scipy.linalg import expm

from peg_on_hole_ros.estimation.kernel.bias_in_air import BLOCK, LONGEST, READINGS, SPEED
from peg_on_hole_ros.estimation.kernel.offsets import CAREFUL, SMALL, SPREADS, Offsets
from peg_on_hole_ros.estimation.measurement import angles_of, skew
from peg_on_hole_ros.estimation.reference.kalman import ReferenceFilter
from peg_on_hole_ros.estimation.reference.steps import (
    BIAS,
    FRICTION,
    RATES,
    SIZE,
    TILT,
    WRENCH,
    with_parameters,
)
from peg_on_hole_ros.mechanics.reference import peg_axes

ALL = TILT.stop


def turning_axes(q):
    """Return the axes about which gamma, psi and phi turn, as columns, hole axes, shape (3, 3)."""
    R_HP = peg_axes(q)
    return np.column_stack([[np.sin(q[1]), -np.cos(q[1]), 0.0], [0.0, 0.0, 1.0], R_HP[:, 2]])


class OffsetReference(ReferenceFilter):
    """
    The contact filter as one of 22 states: bias (6) and tilt (2) are the last.

    Parameters
    ----------
    scene, process, wrench_noise
        As for `ReferenceFilter`.
    offsets : Offsets

    """

    def __init__(self, scene, process, wrench_noise, offsets: Offsets):
        super().__init__(scene, process, wrench_noise, ALL)
        self.offsets, self._gravity = offsets, np.array(scene.gravity)
        self._given = np.zeros(6)
        self.touched()

    keeps_sliding = carries_offsets = True

    @property
    def learns_geometry_or_bias(self):
        """Whether clearance, bias or tilt is learnt."""
        tilt = self.offsets.tilt_learnt and self.offsets.variance[6:].any()
        return super().learns_geometry_or_bias or self.learns_bias or tilt

    @property
    def learns_bias(self):
        """Whether a bias is learnt."""
        return self.offsets.bias_learnt and self.offsets.variance[:6].any()

    @property
    def offsets_are_small(self):
        """Whether what they make of the held wrench is small beside its noise."""
        over = np.linalg.solve(self.wrench_noise, self.P[WRENCH, WRENCH])
        return np.trace(over) < 6 * (1 + SMALL)

    @property
    def R_SH(self):
        """Axes of the hole as it is now taken to lie, in the configured ones."""
        return expm(skew([*self.x[TILT], 0.0]))

    def hold(self, u):
        """Hold a new wrench: less the bias, and in error by the tilt of gravity."""
        gravity_H = self.R_SH.T @ self._gravity
        self.scene = replace(self.scene, gravity=tuple(gravity_H))
        by_offsets = np.zeros((6, ALL))
        by_offsets[:, BIAS] = self.offsets.load
        # A vector that stands still turns by minus the tilt in the hole's axes.
        turned = -np.cross(np.eye(3)[:2], gravity_H).T
        by_offsets[:, TILT] = self.offsets.weight @ peg_axes(self.x[:3]).T @ turned
        T = np.eye(ALL)
        T[WRENCH] = by_offsets
        bias = self.offsets.load @ self.x[BIAS]
        self.x[WRENCH] = self._given + bias if self._given.any() else 0.0
        self._given = u
        super().hold(u + bias)
        self.P = T @ self.P @ T.T
        self.P[WRENCH, WRENCH] += self.wrench_noise

    def in_hole_axes(self, q, R):
        """Return an orientation and its covariance in the axes of the hole as it now lies."""
        turned = angles_of(self.R_SH.T @ peg_axes(q))
        by_angle = np.linalg.solve(turning_axes(turned), self.R_SH.T @ turning_axes(q))
        return turned, by_angle @ R @ by_angle.T

    def measured(self):
        """Return the derivatives of the measured angles: a tilt turns them from the left."""
        H = super().measured()
        H[:, TILT] = np.linalg.inv(turning_axes(self.x[:3]))[:, :2]
        return H

    def correct(self, q, R):
        """Correct with an orientation in the axes of the hole as it is now taken to lie."""
        H = self.measured()
        share = np.ones(ALL)
        share[FRICTION:] = CAREFUL
        share[BIAS] *= self.offsets.bias_learnt
        share[TILT] *= self.offsets.tilt_learnt
        gamma0 = with_parameters(self.scene, *self.x[FRICTION:SIZE]).gamma0
        if not (self.sliding and self.x[0] - gamma0 > SPREADS * np.sqrt(self.P[0, 0])):
            share[FRICTION:] = 0.0
        self.adapt(q - self.x[:3], H @ self.P @ H.T + R)
        self.correct_beside(q, R)
        self.update_in_part(q - self.x[:3], H, R, share)
        self.follow_motion()
        self.slid = False

    def touched(self):
        """Forget the time in the air so far."""
        # Blocks of (bias that is read, time, turning), one row a reading; and what they have told.
        self._air = [[]]
        self._told, self._told_mean = np.zeros(6), np.zeros(6)

    def hang(self, dt):
        """Learn from the wrench that is held over dt [s], of a peg that hangs free."""
        hanging = np.concatenate(
            [-self.scene.peg_mass * peg_axes(self.x[:3]).T @ self.scene.gravity, np.zeros(3)]
        )
        bias = np.linalg.solve(self.offsets.load, hanging - self._given)
        turning = turning_axes(self.x[:3]) @ self.x[RATES]
        self._air[-1].append([*bias, dt, dt * turning @ turning])
        if sum(row[6] for row in self._air[-1]) < BLOCK:
            return
        self._air.append([])
        taken = np.array([row for block in self._air[:-2] for row in block])
        if not len(taken) or not taken[:, 6].sum() < LONGEST:
            return
        mean, time, turned = taken[:, :6].mean(axis=0), taken[:, 6].sum(), taken[:, 7].sum()
        tilt = self.offsets.variance[6:].max() * self._gravity @ self._gravity
        moved = SPEED**2 * (2 / time**2 + turned / time) + tilt
        variance = self.offsets.noise / len(taken) + self.offsets.moved * moved
        # Readings that go one way for longer than speeds explain are pressed on.
        since = np.cumsum(taken[:, 6]) - taken[:, 6] / 2
        slope = 12 / time**2 * (since @ taken[:, :6] / len(taken) - time / 2 * mean)
        allowed = SPEED**2 * (36 / time**2 + 3 * turned / time) * self.offsets.moved
        if ((slope * time / 2) ** 2 > 3 * self.offsets.noise / len(taken) + allowed).any():
            return
        # What a mean over all of the time tells beyond the mean over less of it.
        news = 1 / variance - self._told
        open_yet = np.diagonal(self.P)[BIAS] > self.offsets.noise / READINGS
        for k in np.flatnonzero((news > 0) & open_yet):
            value = (mean[k] / variance[k] - self._told_mean[k]) / news[k]
            H, share = np.zeros((1, ALL)), np.zeros(ALL)
            H[0, BIAS.start + k] = share[BIAS] = 1.0
            off = np.array([value - self.x[BIAS.start + k]])
            self.update_in_part(off, H, np.array([[1 / news[k]]]), share)
            self._told[k], self._told_mean[k] = 1 / variance[k], mean[k] / variance[k]
