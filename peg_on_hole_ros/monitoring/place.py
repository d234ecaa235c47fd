"""Whether a peg is where contacts would have it: its measured place against the hole."""

from math import asin, cos, log, sin, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.geometry import closed_forms
from peg_on_hole_ros.monitoring.contacts import MOST

# A peg that does not rest on three contacts is anywhere about there [m]: lifted, or laid down.
ELSEWHERE = 5e-3
# Above gamma0 by this share: the closed forms end at gamma0.
_EDGE = 1e-4
_STEP = 1e-6


class Misfit(NamedTuple):
    """
    How far a peg is from where it would touch: on three points, or below gamma0 in the hole.

    Attributes
    ----------
    offset : float
        Distance from where contacts would have it [m].
    deviations : float
        The same in standard deviations, all three coordinates together.
    evidence : float
        Log ratio, p(place | elsewhere) over p(place | contacts), in 0 to MOST: a place that
        fits is no evidence, for a peg in the air a micrometre above the rim is there too.

    """

    offset: float
    deviations: float
    evidence: float


def touching_place(d: float, D: float, gamma: float, psi: float) -> np.ndarray:
    """
    Return the peg frame's origin in three-point contact, hole axes, shape (3,) [m].

    Source: docs/notation.md, G1 to G3: O is a1 above the rim, and a2 up the peg's axis.
    """
    gamma0 = 2.0 * asin(sqrt((D - d) / (2.0 * D)))
    gamma = max(gamma, gamma0 * (1.0 + _EDGE))
    s, c, a1, a2 = closed_forms(d, D, 0.0, gamma0, gamma)[:4]
    return np.array([a2 * s * cos(psi), a2 * s * sin(psi), a1 - a2 * c])


def place_inside(d: float, D: float, gamma: float, place) -> np.ndarray:
    """
    Return the place in the hole that is nearest to a peg frame's origin, shape (3,) [m].

    Below gamma0 a peg touches the hole only from within: its lower end is no deeper than two
    points let it, l sin(gamma) = D - d cos(gamma), and no farther aside than it has room.
    """
    aside = float(np.hypot(place[0], place[1]))
    room = min(1.0, (D - d) / max(aside, 1e-12))
    deepest = (D - d * cos(gamma)) / max(sin(gamma), 1e-9)
    return np.array([room * place[0], room * place[1], min(max(place[2], -deepest), 0.0)])


def misfit(measurement, scene_values, diameter_variance: float) -> Misfit:
    """
    Hold a measured place against that of contacts at the measured angles.

    Above gamma0 that is the place of three contacts, below it anywhere in the hole.

    Parameters
    ----------
    measurement : AngleMeasurement
        With a position.
    scene_values : ndarray
        Begins with d, D [m].
    diameter_variance : float
        Of d [m^2].

    Notes
    -----
    The hole's own place is one draw for a whole run, and not one a sample: what speaks against
    three contacts has to outweigh all that this leaves open, else nothing is said.

    """
    d, D = float(scene_values[0]), float(scene_values[1])
    gamma, psi = float(measurement.q[0]), float(measurement.q[1])
    if cos(gamma) > d / D:
        place = place_inside(d, D, gamma, measurement.position)
        return _misfit(measurement.position - place, measurement.position_covariance)
    place = touching_place(d, D, gamma, psi)
    residual = measurement.position - place
    slopes = np.column_stack(
        [
            (touching_place(d, D, gamma + _STEP, psi) - place) / _STEP,
            [-place[1], place[0], 0.0],
        ]
    )
    S = measurement.position_covariance + slopes @ measurement.covariance[:2, :2] @ slopes.T
    if diameter_variance > 0.0:
        spread = sqrt(diameter_variance)
        by_clearance = touching_place(d - spread, D, gamma, psi) - place
        S = S + np.outer(by_clearance, by_clearance)
    return _misfit(residual, S)


def _misfit(residual, S):
    """Return the misfit of a residual with a covariance."""
    wide = S + ELSEWHERE**2 * np.eye(3)
    squared = float(residual @ np.linalg.solve(S, residual))
    ratio = squared - float(residual @ np.linalg.solve(wide, residual))
    ratio -= log(np.linalg.det(wide) / np.linalg.det(S))
    distance = sqrt(float(residual @ residual))
    return Misfit(distance, sqrt(squared), min(max(0.5 * ratio, 0.0), MOST))
