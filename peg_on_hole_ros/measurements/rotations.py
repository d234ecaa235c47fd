"""Rotations from roll, pitch and yaw and back, axes into axes, and cross products as matrices."""

from collections.abc import Sequence
from itertools import permutations, product
from math import atan2, cos, hypot, sin

import numpy as np


def quarter_turns() -> list[np.ndarray]:
    """Return the 24 rotations that turn axes into axes, the identity first."""
    turns = []
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            turn = np.zeros((3, 3))
            turn[range(3), order] = signs
            if np.linalg.det(turn) > 0:
                turns.append(turn)
    return sorted(turns, key=lambda turn: -np.trace(turn))


def rotation_from_rpy(rpy: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return Rz(yaw) Ry(pitch) Rx(roll), shape (3, 3), from roll, pitch, yaw [rad]."""
    r, p, y = rpy
    cr, sr, cp, sp, cy, sy = cos(r), sin(r), cos(p), sin(p), cos(y), sin(y)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def skew(r: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the matrix of r x, shape (3, 3)."""
    return np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]], float)


def tilt_axes(tilt: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return R_SH, axes of a hole turned by a small (x, y) [rad] in its own axes at the start."""
    angle = float(np.hypot(*tilt))
    K = skew([*tilt, 0.0])
    return np.eye(3) + np.sinc(angle / np.pi) * K + 0.5 * np.sinc(angle / 2 / np.pi) ** 2 * K @ K


def rpy_of(R: np.ndarray) -> tuple[float, float, float]:
    """Return roll, pitch, yaw of a rotation [rad]."""
    level = hypot(R[0, 0], R[1, 0])
    if level < 1e-9:
        return atan2(-R[1, 2], R[1, 1]), atan2(-R[2, 0], level), 0.0
    return atan2(R[2, 1], R[2, 2]), atan2(-R[2, 0], level), atan2(R[1, 0], R[0, 0])
