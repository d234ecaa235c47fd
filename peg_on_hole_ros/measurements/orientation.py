"""From a robot's joints to the peg's angles and place: rotations, their errors, the joints'."""

from collections.abc import Sequence
from math import cos, pi, sin, tan
from typing import NamedTuple, Protocol

import numpy as np

from peg_on_hole_ros.config.options import JointInput
from peg_on_hole_ros.measurements.measurement import (
    SMALLEST_SINE,
    NamedPositions,
    angle_covariance,
    angles_of,
    rotation_from_rpy,
)
from peg_on_hole_ros.records import AngleMeasurement, JointSample

# Of the rotation vector, each component [rad]: below what any robot resolves. Joints that turn
# the peg about fewer than three axes would leave a covariance that cannot be inverted.
ORIENTATION_FLOOR = 1e-6

# A joint this far beyond the limits of its description [rad] is another joint, or in degrees;
# drivers do report a hair beyond them.
LIMIT_MARGIN = 0.1


def angle_errors(q: Sequence[float] | np.ndarray) -> np.ndarray:
    """
    Return the matrix from a small rotation, as a vector in hole axes, to errors of the angles.

    Parameters
    ----------
    q : sequence of 3 float
        gamma, psi, phi [rad].

    Returns
    -------
    ndarray, shape (3, 3)
        Rows gamma, psi, phi. It is the inverse of [eps, z, zeta], the axes of the three angles.

    Notes
    -----
    With h the horizontal direction of psi: eps, z + h cot(gamma), -h / sin(gamma). Where the sine
    vanishes it is held at SMALLEST_SINE; psi + phi, the difference of two large rows, is kept by
    writing the cotangent as 1/sin(gamma) - tan(gamma/2).

    """
    gamma, psi = float(q[0]), float(q[1])
    s, c = sin(psi), cos(psi)
    over_sine, half = 1.0 / max(sin(gamma), SMALLEST_SINE), tan(gamma / 2)
    cotangent = over_sine - half
    return np.array(
        [
            [s, -c, 0.0],
            [c * cotangent, s * cotangent, 1.0],
            [-c * over_sine, -s * over_sine, 0.0],
        ]
    )


class TipPose(NamedTuple):
    """
    Where a robot's joints turn its tip.

    Attributes
    ----------
    rotation : ndarray, shape (3, 3)
        R_RT, axes of the tip frame in those of the robot's base.
    jacobian : ndarray, shape (3, n)
        Angular velocity of the tip, base axes, per unit rate of each joint that was asked for.
    position : ndarray, shape (3,), or None
        Of the tip frame's origin, base axes [m]; None: not known.
    velocities : ndarray, shape (3, n), or None
        Its velocity per unit rate of each joint.

    """

    rotation: np.ndarray
    jacobian: np.ndarray
    position: np.ndarray | None = None
    velocities: np.ndarray | None = None


class Kinematics(Protocol):
    """
    A robot's kinematics up to the frame that carries the peg.

    Attributes
    ----------
    lower, upper : sequence of n float
        Limits of the joints, infinite where there are none [rad].

    """

    lower: Sequence[float]
    upper: Sequence[float]

    def __call__(self, position: Sequence[float]) -> TipPose:
        """Return the pose at the positions of the joints, in their order in the options."""


class RobotJoints:
    """
    A robot's joints as orientation of the peg, in any order, among others.

    Calling it with a JointSample returns an AngleMeasurement, or a reason why there is none.
    The covariance is that of independent errors of position_stddev in every joint.

    Parameters
    ----------
    options : JointInput
    kinematics : Kinematics
        For options.names.

    """

    def __init__(self, options: JointInput, kinematics: Kinematics) -> None:
        self.stddev = options.position_stddev
        self._positions = NamedPositions(options.names)
        self._kinematics = kinematics
        self._lower = [low - LIMIT_MARGIN for low in kinematics.lower]
        self._upper = [high + LIMIT_MARGIN for high in kinematics.upper]
        self._R_HR = rotation_from_rpy(options.hole_rpy).T
        self._R_TP = rotation_from_rpy(options.peg_rpy)
        self._hole_variance = options.hole_xyz_stddev**2
        self._p_RH, self._p_TP = np.array(options.hole_xyz), np.array(options.peg_xyz)

    def __call__(self, sample: JointSample) -> AngleMeasurement | str:
        """
        Return the measurement, or the reason why there is none.

        Returns
        -------
        AngleMeasurement or str
            `missing_joint`, `not_finite`, `outside_joint_limits`, or `pointing_away`: the peg's
            lower end does not face the hole, as where peg_rpy or hole_rpy is wrong by half a
            turn.

        """
        position = self._positions(sample)
        if isinstance(position, str):
            return position
        for low, value, high in zip(self._lower, position, self._upper):
            if not low <= value <= high:
                return "outside_joint_limits"
        tip = self._kinematics(position)
        q = angles_of(self._R_HR @ tip.rotation @ self._R_TP)
        if not q[0] < pi / 2:
            return "pointing_away"
        from_joints = angle_errors(q) @ self._R_HR @ tip.jacobian
        covariance = from_joints @ from_joints.T
        covariance *= self.stddev**2
        covariance += angle_covariance(q[0], ORIENTATION_FLOOR)
        return AngleMeasurement(sample.t_ns, q, covariance, *self._place(tip))

    def _place(self, tip: TipPose):
        """Return where the peg's origin is in the hole frame and its covariance, or nothing."""
        if not self._hole_variance or tip.position is None:
            return ()
        lever = tip.rotation @ self._p_TP
        # The velocity of the peg's origin is that of the tip and w x lever.
        turned = np.cross(tip.jacobian, lever, axisa=0, axisc=0)
        from_joints = self.stddev * (self._R_HR @ (tip.velocities + turned))
        covariance = from_joints @ from_joints.T + self._hole_variance * np.eye(3)
        return self._R_HR @ (tip.position + lever - self._p_RH), covariance
