"""What is told by a recording and differs from the start, and its most likely values."""

from typing import NamedTuple

import numpy as np
from scipy.special import chdtri

# A normal variable lies within so many standard deviations in 95 of 100 cases.
NORMAL_95 = 1.96
# Chance that something changes where nothing has to.
LEVEL = 0.05
MOST_ROUNDS = 8
# What is told by more standard deviations than this is not put back on trial.
SURE = 10.0


class Selected(NamedTuple):
    """
    What a recording makes of the start.

    Attributes
    ----------
    x : ndarray, shape (k,)
        Most likely coordinates, of which those that stay are the start's.
    best : ndarray, shape (k,)
        Most likely ones if nothing has to stay.
    covariance : ndarray, shape (k, k)
        Of `best`.
    stddev : ndarray, shape (k,)
        Of `best`, each by its own measure.

    """

    x: np.ndarray
    best: np.ndarray
    covariance: np.ndarray
    stddev: np.ndarray


def search(runs, x0, x=None) -> Selected | None:
    """
    Return what differs from the start, with values; None where that leads nowhere.

    Everything is judged by the slopes at a point where as much as possible is as in the start,
    the first time at the start itself. Not by those at the likeliest point of all: coordinates
    that look nearly alike make a long and bent ridge of the likelihood. Noise moves its top far
    off along it, and the slopes there put the start outside of intervals that are too narrow:
    at (-0.1, 0, 0.5) rad/s nine of nine recordings of a right cell changed something, and with
    the slopes at the start one of 35.

    Parameters
    ----------
    runs : object
        With `tangent(x)`, see `scoring.Tangent`, and `peak(x, free)`, the most likely free
        coordinates near x; both None where there are none.
    x0 : ndarray, shape (k,)
        The start.
    x : ndarray, shape (k,), optional
        Where to look first instead.

    """
    at, kept = (x0, np.ones(len(x0), bool)) if x is None else (x, np.zeros(len(x0), bool))
    found, tried = _judged(runs, at), set()
    for _ in range(MOST_ROUNDS):
        if found is None:
            return None
        tried.add(kept.tobytes())
        again = kept_ones(found.best - x0, found.covariance)
        if again.tobytes() in tried and (again != kept).any():
            # Seen from there it looked otherwise: what is free by now stays so.
            again = kept_ones(found.best - x0, found.covariance, kept)
        if (again == kept).all():
            return _put_back(runs, x0, found, kept)
        found, kept = _with(runs, x0, found, again), again
    return None


def _judged(runs, x):
    at = runs.tangent(x)
    return at if at is None else Selected(x, x + at.step, at.covariance, at.stddev)


def _with(runs, x0, found, kept):
    """Return the most likely coordinates with some as in the start; None where there are none."""
    x = runs.peak(conditional(found.best, found.covariance, x0, kept), ~kept)
    return x if x is None else _judged(runs, x)


def _put_back(runs, x0, found, kept):
    """
    Return the same with each put back that is not told, seen from where it is as in the start.

    Where it was found, its slopes may be those of another top: a delay has several.
    """
    gone = np.abs(found.x - x0) / _given(found.covariance, kept)
    free = np.flatnonzero(~kept & (gone < SURE))
    for i in free[np.argsort(gone[free])]:
        fewer = kept.copy()
        fewer[i] = True
        there = _with(runs, x0, found, fewer)
        if there is None:
            continue
        away = there.best - x0
        own = _distance(away, there.covariance, fewer) - _distance(away, there.covariance, kept)
        if own <= chdtri(1, LEVEL) and passes(away, there.covariance, fewer):
            found, kept = there, fewer
    return found


def _given(covariance, kept):
    """Return the standard deviations where the kept ones are known; of these, 1."""
    stddev, free = np.ones(len(kept)), ~kept
    if free.any():
        block = np.linalg.inv(covariance)[np.ix_(free, free)]
        stddev[free] = np.sqrt(np.diagonal(np.linalg.inv(block)))
    return stddev


def passes(gone, covariance, kept) -> bool:
    """Return whether the kept ones may all be those of the start, in 95 of 100 cases."""
    return not kept.any() or _distance(gone, covariance, kept) <= chdtri(kept.sum(), LEVEL)


def kept_ones(gone, covariance, kept=None) -> np.ndarray:
    """
    Return what stays at the start: as much as together explains the recording as well.

    Tested together, so that of 20 recordings of a cell that is right 19 change nothing (4 of 100
    did in three simulated scenes; more do where noise is too large for tangents), and two
    that look alike are not both kept where only together they differ from the start. Of those
    that fail the test, the one that explains most is set free, until the others pass.

    Parameters
    ----------
    gone : ndarray, shape (k,)
        Most likely coordinates less those of the start.
    covariance : ndarray, shape (k, k)
    kept : ndarray of bool, shape (k,), optional
        What may stay; all.

    """
    kept = np.ones(len(gone), bool) if kept is None else kept.copy()
    while not passes(gone, covariance, kept):
        left = {}
        for i in np.flatnonzero(kept):
            without = kept.copy()
            without[i] = False
            left[i] = _distance(gone, covariance, without)
        kept[min(left, key=left.get)] = False
    return kept


def _distance(gone, covariance, chosen):
    block = covariance[np.ix_(chosen, chosen)]
    return gone[chosen] @ np.linalg.solve(block, gone[chosen]) if chosen.any() else 0.0


def conditional(x, covariance, x0, kept) -> np.ndarray:
    """Return the most likely coordinates where the kept ones are those of the start."""
    final = np.where(kept, x0, x)
    if kept.any():
        gain = np.linalg.solve(covariance[np.ix_(kept, kept)], covariance[np.ix_(kept, ~kept)])
        final[~kept] += (x0 - x)[kept] @ gain
    return final
