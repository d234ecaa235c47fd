"""Friction and clearance as far as they are known: values that stand for all, with weights."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.planning.fineness import PLANNED, Fineness
from peg_on_hole_ros.mechanics.scene import Scene

# Friction in standard deviations; what lies beyond counts as the outermost.
_OUTERMOST = 3.0
# Clearance: Gauss's three nodes.
_CLEARANCES = ((-np.sqrt(3.0), 1 / 6), (0.0, 2 / 3), (np.sqrt(3.0), 1 / 6))


class Spread(NamedTuple):
    """
    What friction and clearance may be.

    Attributes
    ----------
    scenes : tuple of Scene
        One for each clearance.
    weights : ndarray
        Of each clearance.
    frictions : ndarray
        Rising.
    steps : ndarray
        The same in standard deviations from what is stated.

    """

    scenes: tuple[Scene, ...]
    weights: np.ndarray
    frictions: np.ndarray
    steps: np.ndarray

    @property
    def middle(self) -> tuple[int, int]:
        """Where clearance and friction are as stated."""
        return len(self.scenes) // 2, len(self.frictions) // 2


def spread_of(scene: Scene, fineness: Fineness = PLANNED) -> Spread:
    """Return the values that stand for a scene's friction and clearance."""
    steps = np.zeros(1)
    if scene.friction_stddev:
        steps = np.linspace(-_OUTERMOST, _OUTERMOST, fineness.frictions)
    frictions = np.maximum(scene.friction + steps * scene.friction_stddev, 0.0)
    if not scene.clearance_stddev:
        return Spread((scene,), np.ones(1), frictions, steps)
    D, clearance = scene.hole_diameter, scene.hole_diameter - scene.peg_diameter
    scenes, weights = [], []
    for step, weight in _CLEARANCES:
        # A clearance of nothing has no gamma0.
        value = max(clearance + step * scene.clearance_stddev, 0.05 * clearance)
        scenes.append(replace(scene, peg_diameter=D - value))
        weights.append(weight)
    return Spread(tuple(scenes), np.array(weights), frictions, steps)


def probability_below(spread: Spread, margin: np.ndarray) -> np.ndarray:
    """
    Return the probability that a margin is below zero, which between frictions is a straight line.

    Parameters
    ----------
    spread : Spread
    margin : ndarray, shape (clearance, friction, ...)

    Returns
    -------
    ndarray, shape (...)

    """
    margin = np.asarray(margin)
    if len(spread.steps) == 1:
        return np.tensordot(spread.weights, (margin[:, 0] < 0).astype(float), 1)
    # Loaded where it is needed: a replay without an alarm starts a tenth of a second earlier.
    from scipy.special import ndtr

    z, share = spread.steps, 0.0
    for k in range(len(z) - 1):
        a, b = margin[:, k], margin[:, k + 1]
        # Where the line from a to b is zero; a jump to a wedge is one in the middle at worst.
        change = np.where(a == b, 1.0, a - b)
        crossing = ndtr(z[k] + (z[k + 1] - z[k]) * np.clip(a / change, 0, 1))
        low, high = ndtr(z[k]), ndtr(z[k + 1])
        part = np.where(
            (a < 0) & (b < 0),
            high - low,
            np.where(a < 0, crossing - low, np.where(b < 0, high - crossing, 0.0)),
        )
        share = share + part
    share = share + np.where(margin[:, 0] < 0, ndtr(z[0]), 0.0)
    share = share + np.where(margin[:, -1] < 0, ndtr(-z[-1]), 0.0)
    return np.tensordot(spread.weights, share, 1)


def quantile(spread: Spread, values: np.ndarray, share: float) -> np.ndarray:
    """
    Return the value that a share of friction and clearance stays under.

    Parameters
    ----------
    spread : Spread
    values : ndarray, shape (clearance, friction, ...)
    share : float

    Returns
    -------
    ndarray, shape (...)

    """
    from scipy.special import ndtr

    values = np.asarray(values, float)
    edges = np.concatenate([[-np.inf], (spread.steps[1:] + spread.steps[:-1]) / 2, [np.inf]])
    mass = spread.weights[:, None] * np.diff(ndtr(edges))
    flat = values.reshape(-1, *values.shape[2:])
    order = np.argsort(flat, axis=0)
    total = np.cumsum(mass.ravel()[order], axis=0)
    at = np.argmax(total >= share - 1e-12, axis=0)
    return np.take_along_axis(np.take_along_axis(flat, order, 0), at[None], 0)[0]
