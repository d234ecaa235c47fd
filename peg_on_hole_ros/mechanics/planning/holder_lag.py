"""
Loads along a motion with ramps, where the holder's spring takes up a turn before the peg follows.

Near gamma0 slip and slide are one turn: the peg's turn is the commanded one less what winds the
holder up, and how far it is wound up follows from the turn. Both are found step by step in a table
of steady states.
"""

import numpy as np

from peg_on_hole_ros.mechanics.planning.cell import Cell
from peg_on_hole_ros.mechanics.planning.motion import Path
from peg_on_hole_ros.mechanics.planning.steady import Steady, steady_loads
from peg_on_hole_ros.mechanics.scene import Scene

# Turns of the peg that are looked at, over the fastest commanded.
_TURNS = np.array([0.0, 0.01, 0.03, 0.1, 0.2, 0.4, 0.7, 1.0, 1.4])


def followed(
    scene: Scene, cell: Cell, path: Path, gamma: np.ndarray, frictions: np.ndarray
) -> tuple[Steady, np.ndarray]:
    """
    Return the loads along a path.

    Parameters
    ----------
    scene : Scene
    cell : Cell
    path : Path
        As commanded.
    gamma : ndarray, shape (n,)
        The path's tilts, none at gamma0 or below [rad].
    frictions : ndarray, shape (f,)

    Returns
    -------
    loads : Steady
    rates : ndarray, shape (3, f, n)
        Of the peg [rad/s].

    """
    turn = path.rates[1] + path.rates[2]
    fastest = int(np.argmax(np.abs(turn)))
    if not turn[fastest]:
        rates = np.repeat(path.rates[:, None], len(frictions), axis=1)
        return steady_loads(scene, cell, gamma, path.rates, frictions), rates
    top, count, n = path.rates[1:, fastest], len(_TURNS), len(gamma)
    rates = np.empty((3, count, n))
    rates[0], rates[1:] = path.rates[0], top[:, None, None] * _TURNS[:, None]
    table = steady_loads(scene, cell, np.tile(gamma, count), rates.reshape(3, -1), frictions)
    many = len(frictions), count, n
    # Along the commanded turn, so that it is positive.
    wound = np.sign(turn[fastest]) * table.lag[1:].sum(axis=0).reshape(many)
    speeds, commanded = np.abs(turn[fastest]) * _TURNS, np.abs(turn)
    share = np.empty((len(frictions), n))
    share[:] = commanded
    # Where B1 or B2 would have to pull there is no such state to be wound up to.
    lets_go = _between(table.normal, many, speeds, share)[1:].min(axis=0) < 0
    before = _between(wound.reshape(len(frictions), -1), many, speeds, share)[:, 0]
    for k in range(1, n):
        step = path.time[k] - path.time[k - 1]
        # What is wound up and turned together is what was commanded.
        off = wound[:, :, k] + step * speeds - (before + step * commanded[k])[:, None]
        found = _nearest_root(off, speeds, share[:, k - 1])
        share[:, k] = np.where(lets_go[:, k], share[:, k], found)
        before = before + step * (commanded[k] - share[:, k])
    turned = top[:, None, None] * share / np.abs(turn[fastest])
    closed = np.broadcast_to(path.rates[:1, None], (1, *share.shape))
    loads = Steady(*(_between(part, many, speeds, share) for part in table))
    return loads, np.concatenate([closed, turned])


def _nearest_root(off, speeds, start):
    """
    Return where a table rises through zero, row by row, nearest to a start; else its better end.

    The couple that a turn takes is not the largest for the fastest: there may be several roots, of
    which a falling one does not last.
    """
    low, high = off[:, :-1], off[:, 1:]
    rises = (low <= 0) & (high > 0)
    root = speeds[:-1] + np.diff(speeds) * np.where(rises, -low, 0) / np.where(
        rises, high - low, 1
    )
    far = np.where(rises, np.abs(root - start[:, None]), np.inf)
    best = np.argmin(far, axis=1)
    rows = np.arange(len(off))
    end = np.where(off[:, 0] > 0, speeds[0], speeds[-1])
    return np.where(rises[rows, best], root[rows, best], end)


def _between(part, many, speeds, share):
    """Return a table's values at the turns that came about, (..., f, n)."""
    part = part.reshape(*part.shape[: part.ndim - 2], *many)
    upper = np.clip(np.searchsorted(speeds, share), 1, len(speeds) - 1)
    weight = (share - speeds[upper - 1]) / (speeds[upper] - speeds[upper - 1])
    f, n = np.ogrid[: many[0], : many[2]]
    return (1 - weight) * part[..., f, upper - 1, n] + weight * part[..., f, upper, n]
