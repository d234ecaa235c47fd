"""Which parameters a motion tells of, by the filter's own derivatives along it."""

from math import inf
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimation.filters.contact import ContactFilter, Correction, Prediction
from peg_on_hole_ros.estimation.filters.flow import Flow, joint_mean
from peg_on_hole_ros.estimation.identification.likelihood import (
    QUANTITIES,
    TYPICAL_DIAMETER,
    TYPICAL_FORCE,
    measures,
)
from peg_on_hole_ros.estimation.kernel.bias_in_air import LONGEST, READINGS, squared_acceleration
from peg_on_hole_ros.estimation.kernel.offsets import BIAS, COUNT, TILT
from peg_on_hole_ros.estimation.measurement import skew
from peg_on_hole_ros.estimation.orientation import angle_errors
from peg_on_hole_ros.mechanics.reference import peg_axes

# Of a parameter vector: friction, clearance, bias (6) and tilt (2).
NAMES = (
    "friction", "clearance",
    "bias_force_x", "bias_force_y", "bias_force_z",
    "bias_torque_x", "bias_torque_y", "bias_torque_z",
    "tilt_x", "tilt_y",
)  # fmt: skip
OFFSETS, BIASES = slice(2, 2 + COUNT), slice(2, 8)
JOINT = slice(0, 12)
# Correlated by more than this, two parameters look nearly the same.
ALIKE = 0.7
# What the rim carries is not known from less sliding than this [s]: at a touch-down it is nothing.
BRIEF = 0.1


class Observability(NamedTuple):
    """
    What a motion tells of each of NAMES.

    Standard deviations are those of the best estimate that a tangent allows, over the whole
    motion: [-], [m], [N], [N m], [rad].

    Attributes
    ----------
    alone : ndarray, shape (10,)
        Where all others are known; infinite: it moves nothing that is measured.
    together : ndarray, shape (10,)
        Where none is known beyond `range`.
    useful, range : ndarray, shape (10,)
        A standard deviation above this tells a cell nothing; what is known without any motion.
    partner : tuple of str
        Of one that is seen alone and not together, what it looks like; empty: nothing alone.
    rank : int
        How many independent combinations are told better than `useful`.
    condition : float
        Of the best told combination over the worst, in units of `useful`.
    seconds : float
        How long all contacts surely slid [s]; nothing is learnt elsewhere, but a bias in the air.
    free : float
        How long the peg hung free [s].
    turn : float
        How far the peg turned about its own axis meanwhile [rad].
    swing : float
        How far the direction in which it leans turned meanwhile [rad].

    """

    alone: np.ndarray
    together: np.ndarray
    useful: np.ndarray
    range: np.ndarray
    partner: tuple[str, ...]
    rank: int
    condition: float
    seconds: float
    free: float
    turn: float
    swing: float

    @property
    def seen(self) -> np.ndarray:
        """Whether each is told well enough to be of use, shape (10,)."""
        return self.together <= self.useful


class ObservingFilter(ContactFilter):
    """
    The extended Kalman filter, gathering what its corrections tell of all parameters.

    Beside the estimate runs the covariance of a filter that knows every parameter, and how its
    error would follow from one that is off (Friedland, IEEE Trans. Automatic Control 14, 1969):
    with V the derivative of that error, a correction with innovation covariance S tells
    (V_q + T).T inv(S) (V_q + T). The estimate itself is that of `ContactFilter`, bit for bit.
    """

    def __init__(self, scene, options, wrench_noise, offsets):
        super().__init__(scene, options, wrench_noise)
        self._offsets, self._gravity = offsets, np.array(scene.gravity)
        self._V, self._K = np.zeros((12, len(NAMES))), np.zeros((12, 12))
        self.information = np.zeros((len(NAMES), len(NAMES)))
        self.seconds = self._pressed = self.free = 0.0
        # Of the present time in the air: readings, time [s], turning [rad^2/s].
        self._air = np.zeros(3)
        self._least, self._most = np.full(2, inf), np.full(2, -inf)

    def _turn(self):
        return angle_errors(self.x[:3])[:, :2]

    def start(self, q, R):
        """Start; what was gathered stays."""
        super().start(q, R)
        self._K[:] = self.Z
        self._V[:] = 0.0
        # The estimate begins where the tilt puts it.
        self._V[:3, OFFSETS][:, TILT] = -self._turn()

    def hold(self, u):
        """Hold a new wrench, which is off by bias and by the tilt of gravity."""
        super().hold(u)
        self._K[6:] = self._K[:, 6:] = 0.0
        self._K[6:, 6:] = self.wrench_noise
        self._V[6:] = 0.0
        self._V[6:, OFFSETS][:, BIAS] = self._offsets.load
        gravity_P = peg_axes(self.x[:3]).T @ skew(self._gravity)[:, :2]
        self._V[6:, OFFSETS][:, TILT] = self._offsets.weight @ gravity_P

    def predict(self, dt, in_contact):
        """Predict, and carry what wrong parameters make of the error."""
        before = joint_mean(self)
        result = super().predict(dt, in_contact)
        F, noise = np.eye(14), np.zeros((14, 14))
        if result is Prediction.CONTACT:
            _, F, noise = Flow(self, dt)(before)
        else:
            density = self._walk_at_constant_rates(result) ** 2
            F[range(3), range(3, 6)] = dt
            noise[range(3), range(3)] = density * dt**3 / 3
            noise[range(3), range(3, 6)] = noise[range(3, 6), range(3)] = density * dt**2 / 2
            noise[range(3, 6), range(3, 6)] = density * dt
        A = F[JOINT, JOINT]
        self._V = A @ self._V
        if result is Prediction.CONTACT:
            # A greater clearance is a smaller peg.
            self._V[:, :2] += F[JOINT, 12:] * [1.0, -1.0]
        self._K = A @ self._K @ A.T + noise[JOINT, JOINT]
        if self._sliding[0]:
            self.seconds += dt
            self._pressed += dt * self.rim_load()[0]
        return result

    def in_the_air(self, hangs):
        """Take note of a reading of a peg that hangs free, or add what such a time has told."""
        if not hangs:
            self.information[BIASES, BIASES] += np.diag(self._told_by_air())
            self._air[:] = 0.0
            return
        self.free += self._held
        turning = np.linalg.solve(angle_errors(self.x[:3]), self.x[3:])
        self._air += 1.0, self._held, self._held * turning @ turning

    def _told_by_air(self):
        number, time, turned = self._air.tolist()
        if not time > 0.0:
            return np.zeros(6)
        share = min(1.0, LONGEST / time)
        moved = squared_acceleration(share * time, share * turned)
        offsets = self._offsets
        variance = offsets.noise / number + offsets.moved * moved
        return 1 / np.maximum(variance, offsets.noise / READINGS)

    def correct(self, q, R):
        """Correct, and add what the orientation tells."""
        result, nis = super().correct(q, R)
        if result is Correction.GATED or result is Correction.RESET:
            return result, nis
        seen = self._V[:3].copy()
        seen[:, OFFSETS][:, TILT] += self._turn()
        weight = np.linalg.inv(self._K[:3, :3] + R)
        if self._sliding[0]:
            self.information += seen.T @ weight @ seen
            self._least = np.minimum(self._least, self.x[1:3])
            self._most = np.maximum(self._most, self.x[1:3])
        gain = self._K[:, :3] @ weight
        self._V -= gain @ seen
        self._K -= gain @ self._K[:3]
        self._K = (self._K + self._K.T) / 2
        return result, nis

    def observability(self) -> Observability:
        """Return what was gathered so far."""
        clearance = self.scene_values[1] - self.scene_values[0]
        travel = np.maximum(self._most - self._least, 0.0)
        force = self._pressed / self.seconds if self.seconds > BRIEF else TYPICAL_FORCE
        diameter = self.scene_values.item(1)
        information = self.information.copy()
        information[BIASES, BIASES] += np.diag(self._told_by_air())
        return observability(
            information, clearance, self.seconds, *travel[::-1], diameter, force, self.free
        )


def observability(
    information,
    clearance,
    seconds=0.0,
    turn=0.0,
    swing=0.0,
    diameter=TYPICAL_DIAMETER,
    force=TYPICAL_FORCE,
    free=0.0,
) -> Observability:
    """
    Return what an information matrix says of each of NAMES.

    Parameters
    ----------
    information : ndarray, shape (10, 10)
        Inverse of the covariance that a best estimate would have, in the units of NAMES.
    clearance : float
        D - d; its useful share is that of the calibration [m].
    seconds, turn, swing, free : float
        See `Observability`.
    diameter, force : float
        Of the hole [m], and that the rim carries [N]: what biases are of use beside.

    """
    scale = measures(diameter, force)
    names = [one.name for one in QUANTITIES]
    rows = [names.index(name) for name in NAMES]
    unit = np.array([clearance if QUANTITIES[row].log else 1.0 for row in rows])
    useful, known = unit * scale.useful[rows], unit * scale.range[rows]
    scaled = information * np.outer(useful, useful)
    diagonal = np.diagonal(scaled)
    alone = np.where(diagonal > 0, useful / np.sqrt(np.where(diagonal > 0, diagonal, 1.0)), inf)
    covariance = np.linalg.inv(scaled + np.diag((useful / known) ** 2))
    stddev = np.sqrt(np.diagonal(covariance))
    correlation = np.abs(covariance / np.outer(stddev, stddev)) - np.eye(len(NAMES))
    together = useful * stddev
    partner = []
    for i in range(len(NAMES)):
        nearest = int(np.argmax(correlation[i]))
        hidden = alone[i] <= useful[i] < together[i] and correlation[i, nearest] > ALIKE
        partner.append(NAMES[nearest] if hidden else "")
    told = np.linalg.eigvalsh(scaled)
    condition = float(np.sqrt(told[-1] / told[0])) if told[0] > 1e-14 * told[-1] > 0 else inf
    rank = int((told > 1.0).sum())
    return Observability(
        alone, together, useful, known, tuple(partner), rank, condition, seconds, free, turn, swing
    )
