"""
The estimator's steps as Python calls them, with an array of HELD of shape (1,).

A record takes numba some ten microseconds to read, an array of one a fifth of one. See `held` for
what each does.
"""

import numpy as np

from peg_on_hole_ros.estimator import held
from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.record_types import GatesRecord


@compiled
def start(memory: np.ndarray, gates: GatesRecord, q: np.ndarray, R: np.ndarray) -> None:
    """Start from an orientation q [rad] with the stated covariance R, at unknown rates."""
    held.start(memory[0], gates, q, R)


@compiled
def let_go(memory: np.ndarray) -> None:
    """Let go of the motion."""
    held.let_go(memory[0])


@compiled
def move_on(memory: np.ndarray, dt: float) -> None:
    """Predict by dt [s]."""
    held.move_on(memory[0], dt)


@compiled
def hold_against(
    memory: np.ndarray, gates: GatesRecord, q: np.ndarray, R: np.ndarray
) -> tuple[int, float]:
    """Hold the estimate against an orientation; return what has to become of it, and its NIS."""
    return held.hold_against(memory[0], gates, q, R)


@compiled
def orient(memory: np.ndarray, q: np.ndarray, R: np.ndarray) -> None:
    """Correct by an orientation that is used."""
    held.orient(memory[0], q, R)


@compiled
def weigh(memory: np.ndarray, u: np.ndarray, contacts: int) -> None:
    """Take a wrench on the peg."""
    held.weigh(memory[0], u, contacts)
