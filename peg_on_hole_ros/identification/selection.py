"""Which parameters stay at the values that a search starts with, and the likeliest others."""

import numpy as np
from scipy.special import chdtri

from peg_on_hole_ros.identification.tuned import CALIBRATION_SEARCH

# A normal variable lies within so many standard deviations in 95 of 100 cases.
NORMAL_95 = 1.96


def passes(gone: np.ndarray, covariance: np.ndarray, kept: np.ndarray) -> bool:
    """Return whether keeping these values of the start passes the 95 % test."""
    if not kept.any():
        return True
    chance = chdtri(kept.sum(), CALIBRATION_SEARCH.change_level)
    return bool(_distance(gone, covariance, kept) <= chance)


def kept_ones(
    gone: np.ndarray, covariance: np.ndarray, kept: np.ndarray | None = None
) -> np.ndarray:
    """
    Return what stays at the start: as much as together explains the recording as well.

    Tested together, so that of 20 recordings of a cell that is right 19 change nothing, and two
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
        kept[min(left, key=left.get)] = False  # type: ignore[arg-type]
    return kept


def _distance(gone, covariance, chosen):
    block = covariance[np.ix_(chosen, chosen)]
    return gone[chosen] @ np.linalg.solve(block, gone[chosen]) if chosen.any() else 0.0


def conditional(
    x: np.ndarray, covariance: np.ndarray, x0: np.ndarray, kept: np.ndarray
) -> np.ndarray:
    """Return the most likely coordinates where the kept ones are those of the start."""
    final = np.where(kept, x0, x)
    if kept.any():
        gain = np.linalg.solve(covariance[np.ix_(kept, kept)], covariance[np.ix_(kept, ~kept)])
        final[~kept] += (x0 - x)[kept] @ gain
    return final
