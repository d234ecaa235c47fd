"""Rotations as roll, pitch and yaw, and those that turn axes into axes."""

from itertools import permutations, product
from math import atan2, hypot

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


def rpy_of(R: np.ndarray) -> tuple[float, float, float]:
    """Return roll, pitch, yaw of a rotation [rad]."""
    level = hypot(R[0, 0], R[1, 0])
    if level < 1e-9:
        return atan2(-R[1, 2], R[1, 1]), atan2(-R[2, 0], level), 0.0
    return atan2(R[2, 1], R[2, 2]), atan2(-R[2, 0], level), atan2(R[1, 0], R[0, 0])
