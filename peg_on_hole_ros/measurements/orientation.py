"""From joint states to the peg's angles and place, for one and for thousands alike."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from enum import IntEnum
from math import isfinite, pi
from typing import NamedTuple, Protocol

import numpy as np

from peg_on_hole_ros.config.options import JointInput
from peg_on_hole_ros.measurements.angles import (
    angles_of_rows,
    fill_angle_errors,
    fill_covariance,
)
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy
from peg_on_hole_ros.measurements.screws import TipPoses
from peg_on_hole_ros.measurements.tuned import PLAUSIBLE_JOINTS
from peg_on_hole_ros.measurements.wrench_reduction import turned_to_peg
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.records import AngleMeasurement, JointSample

# Numbers of `AngleMeasurement.row`.
ROW = 24


class Outcome(IntEnum):
    """What comes of a joint state: an orientation, or by its name the reason why there is none."""

    orientation = 0
    missing_joint = 1
    not_finite = 2
    out_of_range = 3
    outside_joint_limits = 4
    pointing_away = 5
    without_description = 6


class Orientations(NamedTuple):
    """
    What comes of joint states.

    Attributes
    ----------
    outcome : ndarray of int, shape (n,)
        See `Outcome`.
    rows : ndarray, shape (n, ROW)
        See `AngleMeasurement.row`; NaN where there is no orientation.

    """

    outcome: np.ndarray
    rows: np.ndarray


class Kinematics(Protocol):
    """A robot's kinematics up to the frame that carries the peg."""

    @property
    def lower(self) -> Sequence[float]:
        """Lower limits of the n joints, -inf where there are none [rad]."""

    @property
    def upper(self) -> Sequence[float]:
        """Upper limits of the n joints, inf where there are none [rad]."""

    def poses(self, positions: np.ndarray) -> TipPoses:
        """Return the poses at positions of the joints, in their order in the options, (s, n)."""


class JointOrientation(ABC):
    """
    Joint states as orientation of the peg; names in any order, among others.

    Parameters
    ----------
    names : tuple of str
        Of the joints that are read.

    """

    def __init__(self, names: tuple[str, ...]) -> None:
        self.names = names
        self._order: tuple[str, ...] | None = None
        self._index: list[int] | None = None

    def __call__(self, sample: JointSample) -> AngleMeasurement | str:
        """Return the measurement of one joint state, or the reason why there is none."""
        outcome, rows = self.rows(sample.names, np.array([sample.position], float))
        if outcome[0] != Outcome.orientation:
            return Outcome(outcome[0]).name
        return AngleMeasurement.of_row(sample.t_ns, rows[0])

    def rows(self, names: tuple[str, ...], positions: np.ndarray) -> Orientations:
        """
        Return what comes of joint states of one order.

        Parameters
        ----------
        names : tuple of str
            Of all joints in them.
        positions : ndarray, shape (n, len(names))
            [rad or m].

        """
        rows = np.full((len(positions), ROW), np.nan)
        if names != self._order:
            self._order, self._index = names, places_of(self.names, names)
        if self._index is None:
            return Orientations(np.full(len(positions), Outcome.missing_joint), rows)
        read = positions[:, self._index]
        outcome = np.zeros(len(positions), np.int64)
        finite = np.isfinite(read)
        if not finite.all():
            outcome[~finite.all(axis=1)] = Outcome.not_finite
        self._fill(read, outcome, rows)
        return Orientations(outcome, rows)

    @abstractmethod
    def _fill(self, positions: np.ndarray, outcome: np.ndarray, rows: np.ndarray) -> None:
        """Fill in the outcome and the rows of those that are finite."""


def places_of(wanted: tuple[str, ...], names: tuple[str, ...]) -> list[int] | None:
    """Return where each wanted name stands among others, its first place; None: one is missing."""
    first = {name: i for i, name in reversed(list(enumerate(names)))}
    return [first[name] for name in wanted] if all(name in first for name in wanted) else None


def positions_of(
    wanted: tuple[str, ...], names: tuple[str, ...], positions: np.ndarray
) -> np.ndarray:
    """Return what wanted joints read, shape (n, wanted); NaN where one of them is missing."""
    places = places_of(wanted, names)
    if places is None:
        return np.full((len(positions), len(wanted)), np.nan)
    return positions[:, places]


class PegJoints(JointOrientation):
    """
    The peg's own joints as orientation: gamma, psi, phi by name.

    `out_of_range` is one that is tilted by a quarter turn or more, or turned by more than
    `PLAUSIBLE_JOINTS.most_turned`. A tilt below zero is one to the other side.
    """

    def __init__(self, options: JointInput) -> None:
        super().__init__(options.names)
        self.stddev = float(options.position_stddev)
        self._leans = any(options.hole_rpy)
        self._R_HM = rotation_from_rpy(options.hole_rpy).T.copy()

    def _fill(self, positions: np.ndarray, outcome: np.ndarray, rows: np.ndarray) -> None:
        _fill_peg(positions, self._R_HM, self._leans, self.stddev, outcome, rows)


@compiled
def _fill_peg(angles, R_HM, leans, stddev, outcome, rows):
    for i in range(len(angles)):
        if outcome[i]:
            continue
        outcome[i] = Outcome.out_of_range
        gamma, psi, phi = angles[i, 0], angles[i, 1], angles[i, 2]
        most = PLAUSIBLE_JOINTS.most_turned
        if not (abs(gamma) < pi and abs(psi) <= most and abs(phi) <= most):
            continue
        if leans:
            q = angles[i]
            gamma, psi, phi = angles_of_rows(
                turned_to_peg(q, (R_HM[0, 0], R_HM[0, 1], R_HM[0, 2])),
                turned_to_peg(q, (R_HM[1, 0], R_HM[1, 1], R_HM[1, 2])),
                turned_to_peg(q, (R_HM[2, 0], R_HM[2, 1], R_HM[2, 2])),
            )
        if gamma < 0.0:
            # The same orientation, leaning to the other side.
            gamma, psi, phi = -gamma, psi + pi, phi - pi
        if not gamma < 0.5 * pi:
            continue
        outcome[i] = Outcome.orientation
        rows[i, 0], rows[i, 1], rows[i, 2] = gamma, psi, phi
        fill_covariance(gamma, stddev, rows[i, 3:12])


class UndescribedRobot(JointOrientation):
    """Joint states of a robot whose description has not come: `without_description`."""

    def _fill(self, positions: np.ndarray, outcome: np.ndarray, rows: np.ndarray) -> None:
        outcome[:] = Outcome.without_description


class _Mounting(NamedTuple):
    """Where hole and peg are: R_HR, R_TP, p_RH, p_TP, base (R), tip (T), hole (H), peg (P)."""

    hole_turn: np.ndarray
    peg_turn: np.ndarray
    hole: np.ndarray
    peg: np.ndarray


class RobotJoints(JointOrientation):
    """
    A robot's joints as orientation and, where hole_xyz is stated, place of the peg.

    The covariance is that of independent errors of position_stddev in every joint.
    `outside_joint_limits` is one beyond its limits; `pointing_away`: the peg's lower end does not
    face the hole, as where peg_rpy or hole_rpy is wrong by half a turn.

    Parameters
    ----------
    options : JointInput
    kinematics : Kinematics
        For options.names.

    """

    def __init__(self, options: JointInput, kinematics: Kinematics) -> None:
        super().__init__(options.names)
        self.stddev = float(options.position_stddev)
        self._kinematics = kinematics
        self._lower = np.array(kinematics.lower, float) - PLAUSIBLE_JOINTS.limit_margin
        self._upper = np.array(kinematics.upper, float) + PLAUSIBLE_JOINTS.limit_margin
        self._mounting = _Mounting(
            rotation_from_rpy(options.hole_rpy).T.copy(),
            rotation_from_rpy(options.peg_rpy),
            np.array(options.hole_xyz, float),
            np.array(options.peg_xyz, float),
        )
        self._hole_variance = float((options.place_stddev or 0.0) ** 2)

    def _fill(self, positions: np.ndarray, outcome: np.ndarray, rows: np.ndarray) -> None:
        within = ((positions >= self._lower) & (positions <= self._upper)).all(axis=1)
        outcome[~within & (outcome == Outcome.orientation)] = Outcome.outside_joint_limits
        usable = np.flatnonzero(outcome == Outcome.orientation)
        if len(usable):
            poses = self._kinematics.poses(positions[usable])
            _fill_robot(
                poses, self._mounting, self.stddev, self._hole_variance, usable, outcome, rows
            )


@compiled
def _fill_robot(poses, mounting, stddev, hole_variance, usable, outcome, rows):
    R, turned = np.empty((3, 3)), np.empty((3, 3))
    errors, of_joints, lever = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    joints = poses.jacobian.shape[2]
    moved, block, column = np.empty((3, joints)), np.empty(9), np.empty(3)
    for k in range(len(usable)):
        i = usable[k]
        _product(mounting.hole_turn, poses.rotation[k], turned)
        _product(turned, mounting.peg_turn, R)
        gamma, psi, phi = angles_of_rows(
            (R[0, 0], R[0, 1], R[0, 2]), (R[1, 0], R[1, 1], R[1, 2]), (R[2, 0], R[2, 1], R[2, 2])
        )
        if not gamma < 0.5 * pi:
            outcome[i] = Outcome.pointing_away
            continue
        rows[i, 0], rows[i, 1], rows[i, 2] = gamma, psi, phi
        fill_angle_errors(gamma, psi, errors)
        _product(errors, mounting.hole_turn, of_joints)
        _times_columns(of_joints, poses.jacobian[k], moved)
        fill_covariance(gamma, PLAUSIBLE_JOINTS.orientation_stddev, rows[i, 3:12])
        _add_square(moved, stddev, block, rows[i, 3:12])
        if hole_variance == 0.0 or not isfinite(poses.position[k, 0]):
            continue
        for a in range(3):
            lever[a] = 0.0
            for b in range(3):
                lever[a] += poses.rotation[k, a, b] * mounting.peg[b]
        # The velocity of the peg's origin is that of the tip and w x lever.
        for j in range(joints):
            w = poses.jacobian[k, :, j]
            column[0] = poses.velocities[k, 0, j] + w[1] * lever[2] - w[2] * lever[1]
            column[1] = poses.velocities[k, 1, j] + w[2] * lever[0] - w[0] * lever[2]
            column[2] = poses.velocities[k, 2, j] + w[0] * lever[1] - w[1] * lever[0]
            for a in range(3):
                moved[a, j] = 0.0
                for b in range(3):
                    moved[a, j] += mounting.hole_turn[a, b] * column[b]
        for a in range(3):
            rows[i, 12 + a] = 0.0
            for b in range(3):
                away = poses.position[k, b] + lever[b] - mounting.hole[b]
                rows[i, 12 + a] += mounting.hole_turn[a, b] * away
                rows[i, 15 + 3 * a + b] = hole_variance if a == b else 0.0
        _add_square(moved, stddev, block, rows[i, 15:24])


@compiled
def _product(A, B, out):
    for a in range(3):
        for b in range(3):
            out[a, b] = A[a, 0] * B[0, b] + A[a, 1] * B[1, b] + A[a, 2] * B[2, b]


@compiled
def _times_columns(A, columns, out):
    for j in range(columns.shape[1]):
        for a in range(3):
            out[a, j] = A[a, 0] * columns[0, j] + A[a, 1] * columns[1, j] + A[a, 2] * columns[2, j]


@compiled
def _add_square(moved, stddev, block, covariance):
    """Add the covariance that independent errors of the joints make, by rows, shape (9,)."""
    for a in range(3):
        for b in range(3):
            block[3 * a + b] = 0.0
            for j in range(moved.shape[1]):
                block[3 * a + b] += moved[a, j] * moved[b, j]
            covariance[3 * a + b] += stddev * stddev * block[3 * a + b]
