"""The extended Kalman filter on a square root of its covariance."""

import numpy as np

from peg_on_hole_ros.estimation.filters.contact import ContactFilter, Prediction
from peg_on_hole_ros.estimation.filters.flow import (
    DIAMETER,
    FRICTION,
    RATES,
    Flow,
    joint_mean,
    set_joint,
    walk_factor,
)
from peg_on_hole_ros.estimation.filters.outcomes import NO_STEP
from peg_on_hole_ros.estimation.kernel.memory import part
from peg_on_hole_ros.estimation.kernel.parameters import learning_shares, learnt_variance
from peg_on_hole_ros.mechanics.kernel import WIDTH

WRENCH = slice(6, 12)


def _root_of(covariance):
    """Return a root of a covariance, of which some rows may be zero; a lower one if it has one."""
    known = np.diagonal(covariance) == 0.0
    scale = np.sqrt(np.diagonal(covariance)) + known
    correlation = covariance / np.outer(scale, scale) + np.diag(known.astype(float))
    try:
        root = scale[:, None] * np.linalg.cholesky(correlation)
    except np.linalg.LinAlgError:
        # To rounding it is singular.
        variance, axes = np.linalg.eigh(correlation)
        root = scale[:, None] * axes * np.sqrt(np.maximum(variance, 0.0))
    root[known] = 0.0
    return root


class SquareRootFilter(ContactFilter):
    """
    Extended Kalman filter on a square root S of the joint covariance, P = S S.T, by QR.

    Predictions and corrections act on S alone, so P cannot lose its sign to rounding, and keeps
    twice the digits. A correction is Joseph's form on S, which holds for any gain: that of
    friction and peg diameter is zero where they are only considered.
    """

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self._root = _root_of(self.joint_covariance())
        # Joint mean and root before a prediction.
        self._before = None

    def _set(self, mean, factor):
        # The triangle of a QR decomposition, (14, n) to (14, 14).
        self._root = np.linalg.qr(factor.T, mode="r").T
        set_joint(self, mean, self._root @ self._root.T)

    def start(self, q, R):
        """Start from an orientation."""
        super().start(q, R)
        factor = np.zeros((WIDTH, WIDTH))
        factor[:12, :12] = _root_of(self.Z)
        # Friction and peg diameter may be known.
        variance, axes = np.linalg.eigh(self.spread)
        factor[12:, 12:] = axes * np.sqrt(np.maximum(variance, 0.0))
        self._set(joint_mean(self), factor)

    def hold(self, u):
        """Hold a new wrench."""
        super().hold(u)
        factor = np.hstack([self._root, np.zeros((WIDTH, 6))])
        factor[WRENCH, :WIDTH] = 0.0
        factor[WRENCH, WIDTH:] = _root_of(self.wrench_noise)
        self._set(joint_mean(self), factor)

    def predict(self, dt, in_contact):
        """Predict; the mean is the extended filter's."""
        result = super().predict(dt, in_contact)
        full, root = self._before
        if result is Prediction.CONTACT:
            flow = Flow(self, dt)
            for piece in range(flow.pieces):
                full, F = flow.step(full, piece)
                root = np.linalg.qr(np.hstack([F @ root, flow.walk()]).T, mode="r").T
            added, jumped = flow.added(), flow.jumped
        else:
            noise = self._walk_at_constant_rates(result)
            F, added, jumped = np.eye(WIDTH), np.zeros(WIDTH), np.zeros(WIDTH)
            F[range(3), range(3, 6)] = dt
            root = np.hstack([F @ root, walk_factor(noise, dt)])
            shared = part(self._memory, "CROSS")[:12].any() or self.spread[0, 1]
            if result in NO_STEP and not shared:
                # It may be sought anew, apart from all else.
                root[FRICTION] = 0.0
            # It walks, or was given back of its spread.
            added[FRICTION] = max(self.spread[0, 0] - np.sum(root[FRICTION] ** 2), 0.0)
        self._set(joint_mean(self), np.hstack([root, np.diag(np.sqrt(added)), jumped[:, None]]))
        return result

    def _begin(self, changed):
        if changed:
            # With a gain of its own.
            self._set_anew()
        self._before = joint_mean(self), self._root

    def take_friction(self, value, variance):
        """Take friction for a value of its own."""
        super().take_friction(value, variance)
        self._set_anew()

    def _set_anew(self):
        self._set(joint_mean(self), _root_of(self.joint_covariance()))

    def _widen_rates(self, factor):
        carried = np.zeros((WIDTH, WIDTH))
        carried[RATES] = self._root[RATES]
        carried[:3] = self._since_correction.item() * self._root[RATES]
        self._set(joint_mean(self), np.hstack([self._root, np.sqrt(factor) * carried]))

    def _widen_parameters(self, friction, diameter):
        added = np.zeros((WIDTH, 2))
        added[FRICTION, 0], added[DIAMETER, 1] = np.sqrt(np.maximum([friction, diameter], 0.0))
        if added.any():
            self._set(joint_mean(self), np.hstack([self._root, added]))

    def _update(self):
        noise, angles = _root_of(self._R), self._root[:3]
        arrays = np.vstack([np.hstack([noise, angles]), np.zeros((WIDTH, 3 + WIDTH))])
        arrays[3:, 3:] = self._root
        lower = np.linalg.qr(arrays.T, mode="r").T
        gain = np.linalg.solve(lower[:3, :3].T, lower[3:, :3].T).T
        gain[FRICTION : DIAMETER + 1] *= np.array(learning_shares(self._memory))[:, None]
        before, moves = self.spread.item(0), gain @ self._residual
        root = np.hstack([self._root - gain @ angles, gain @ noise])
        told = np.sum(root[FRICTION] ** 2)
        added = np.zeros((WIDTH, 1))
        added[FRICTION] = np.sqrt(learnt_variance(told, before, moves[FRICTION]) - told)
        self._set(joint_mean(self) + moves, np.hstack([root, added]))

    def _take(self):
        super()._take()
        # What is on its way has been widened in the memory.
        added = self.spread.item(0) - np.sum(self._root[FRICTION] ** 2)
        self._widen_parameters(added, 0.0)

    def snapshot(self):
        """Return what `restore` takes back."""
        return super().snapshot(), self._root.copy()

    def restore(self, snapshot):
        """Go back to a snapshot."""
        kalman, self._root = snapshot
        super().restore(kalman)
