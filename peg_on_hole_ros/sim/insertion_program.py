"""What the holder is told to do in the hole: angles, place and depth of the peg's lower end."""

from collections.abc import Sequence

import numpy as np

from peg_on_hole_ros.sim.command import evaluate, quintic
from peg_on_hole_ros.sim.dynamics import (
    angular_acceleration,
    angular_velocity,
    rotation,
)
from peg_on_hole_ros.sim.holder import mass_centre
from peg_on_hole_ros.sim.plan import Phase


def place_program(
    phases: Sequence[Phase], begin: np.ndarray, angles: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the commanded angles and place of phases in the hole, as knots and quintics.

    Parameters
    ----------
    phases : sequence of Phase
        All of kind `insert`.
    begin : ndarray, shape (3, 3)
        Place x, y and depth of the lower end's centre when they begin [m], with rates and
        accelerations.
    angles : ndarray, shape (n, 3, 6)
        Quintics of gamma, psi, phi in these phases.

    Returns
    -------
    knots : ndarray, shape (n + 1,)
        From the begin of the first [s].
    coefficients : ndarray, shape (n, 6, 6)

    """
    now, knots, pieces = begin.copy(), [0.0], []
    for phase, turning in zip(phases, angles, strict=True):
        end = np.zeros((3, 3))
        end[1, 2] = phase.depth_rate
        end[0, :2] = now[0, :2] if phase.place is None else phase.place
        mean = (now[1, 2] + end[1, 2]) / 2
        end[0, 2] = now[0, 2] + mean * phase.duration if phase.depth is None else phase.depth
        pieces.append(np.concatenate([turning, quintic(now, end, phase.duration)]))
        knots.append(knots[-1] + phase.duration)
        now = end
    return np.array(knots), np.array(pieces)


def end_motion(p: np.ndarray, x: np.ndarray) -> np.ndarray:
    """
    Return place x, y and depth of the lower end's centre, with rates and accelerations.

    Parameters
    ----------
    p : ndarray
        Scene.
    x : ndarray, shape (3, 6)
        Angles and offset from the touching pose with rates and accelerations.

    Returns
    -------
    ndarray, shape (3, 3)
        [m], [m/s], [m/s^2] as rows.

    """
    q, rates = x[0, :3].copy(), x[1, :3].copy()
    w, zeta = angular_velocity(q, rates), rotation(q)[:, 2]
    alpha = angular_acceleration(q, rates, x[2, :3].copy())
    lever = -p[2] * np.array(
        [zeta, np.cross(w, zeta), np.cross(alpha, zeta) + np.cross(w, np.cross(w, zeta))]
    )
    return (mass_centre(p, x) + lever) * [1.0, 1.0, -1.0]


def begin_of(knots: np.ndarray, coefficients: np.ndarray, p: np.ndarray, t: float) -> np.ndarray:
    """Return what `end_motion` does, of where a program of angles and offsets is at t [s]."""
    return end_motion(p, evaluate(knots, coefficients, t))
