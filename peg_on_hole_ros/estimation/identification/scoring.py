"""Greatest likelihood by Fisher's scoring, and the curvature that intervals come from."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimation.identification.likelihood import QUANTITIES, Innovations

STEPS = np.array([quantity.step for quantity in QUANTITIES])
RANGES = np.array([quantity.range for quantity in QUANTITIES])
MOST_ITERATIONS = 8
MOST_HALVINGS = 4
# The search ends where a step promises less than this of the logarithm of the likelihood: a tenth
# of a standard deviation in each of ten directions; or less than ROUGH, and none is better.
ENOUGH, ROUGH = 0.05, 1.0
# So many innovations in a row are summed to see how much the scores vary. Those of a filter that
# is right are independent, those under a smoothed wrench or coloured noise are not.
BLOCK = 25


class Peak(NamedTuple):
    """
    Where the likelihood is greatest.

    Attributes
    ----------
    x : ndarray, shape (14,)
    covariance : ndarray, shape (k, k)
        Of the k coordinates that were free, from the curvature and a wide prior, as a whole wider
        by how much the scores vary more than the curvature promises.
    stddev : ndarray, shape (k,)
        The same, each wider by its own measure.
    found : Innovations
    converged : bool

    """

    x: np.ndarray
    covariance: np.ndarray
    stddev: np.ndarray
    found: Innovations
    converged: bool


def greatest(
    run: Callable[[np.ndarray], Innovations | None],
    x: np.ndarray,
    centre: np.ndarray,
    free: np.ndarray,
    limits: tuple[np.ndarray, np.ndarray],
    quiet: Callable[[np.ndarray], Innovations | None] | None = None,
) -> Peak | None:
    """
    Return the peak near x, or None where the filter has no finite innovations there.

    Parameters
    ----------
    run : callable
        From coordinates to innovations.
    x, centre : ndarray, shape (14,)
        Where to begin, and the centre of the prior, of spread `Quantity.range`.
    free : ndarray of bool, shape (14,)
        What is searched for.
    limits : tuple of ndarray, shape (14,)
        Least and greatest coordinates.
    quiet : callable, optional
        As run, over the same recording with its noise smoothed away; where given, slopes are
        taken there, and covariances stay during a step. Slopes along the noisy motion go with
        the very noise that is in the innovations, and covariances are never quite right: each
        would move values by one to two standard deviations. None, for noise levels: slopes of
        mean and covariance where the innovations are.

    """
    chosen = np.flatnonzero(free)
    weight = np.diag(RANGES[chosen] ** -2.0)

    def at(x, root=None):
        found = run(np.clip(x, *limits))
        return found if found is None or root is None else found._replace(root=root)

    def value(found, x):
        gone = (x - centre)[chosen]
        return float(found.log_likelihood.sum() - 0.5 * gone @ weight @ gone)

    found = at(x)
    if found is None:
        return None
    for _ in range(MOST_ITERATIONS):
        root = found.root if quiet else None
        scores, information = _slopes(found, quiet or run, x, chosen, spread=not quiet)
        slope = scores.sum(axis=0) - weight @ (x - centre)[chosen]
        move = np.linalg.solve(information + weight, slope)
        promised = float(0.5 * slope @ move)
        if promised < ENOUGH:
            break
        best = value(found, x)
        for _ in range(MOST_HALVINGS):
            trial = x.copy()
            trial[chosen] += move
            trial = np.clip(trial, *limits)
            there = at(trial, root)
            if there is not None and value(there, trial) > best:
                break
            move = 0.5 * move
        else:
            break
        x, found = trial, at(trial) if quiet else there
    inverse = np.linalg.inv(information + weight)
    wider = _widening(inverse, scores)
    stddev = np.sqrt(np.diagonal(inverse) * np.maximum(wider, 1.0))
    # One measure for all keeps the directions in which the recording tells little.
    return Peak(x, inverse * max(wider.mean(), 1.0), stddev, found, promised < ROUGH)


def _slopes(found, run, x, chosen, spread):
    """Return the scores of all innovations, shape (n, k), and Fisher's information."""
    over = np.linalg.inv(found.root)
    white = np.einsum("nij,nj->ni", over, found.residual)
    scores, means, spreads = [], [], []
    for i in chosen:
        sides = []
        for step in (-STEPS[i], STEPS[i]):
            beside = x.copy()
            beside[i] += step
            # Where it has no finite innovations, the difference is one-sided.
            there = run(beside)
            sides.append((0.0, found) if there is None else (step, there))
        (low_step, low), (high_step, high) = sides
        width = high_step - low_step or np.inf
        means.append(np.einsum("nij,nj->ni", over, (high.residual - low.residual) / width))
        wider = (_square(high.root) - _square(low.root)) / width * spread
        spreads.append(over @ wider @ np.swapaxes(over, 1, 2))
        scores.append(
            0.5 * np.einsum("nij,ni,nj->n", spreads[-1], white, white)
            - 0.5 * np.einsum("nii->n", spreads[-1])
            - (means[-1] * white).sum(axis=1)
        )
    flat, wide = (np.array(part).reshape(len(chosen), -1) for part in (means, spreads))
    return np.array(scores).T, flat @ flat.T + 0.5 * wide @ wide.T


def _square(root):
    return root @ np.swapaxes(root, 1, 2)


def _widening(inverse, scores):
    """Return the variances that the scores show over those of the curvature, shape (k,)."""
    blocks = np.add.reduceat(scores, np.arange(0, len(scores), BLOCK), axis=0)
    blocks = blocks - blocks.mean(axis=0)
    few = len(blocks) / max(len(blocks) - len(inverse), 1)
    shown = few * np.diagonal(inverse @ (blocks.T @ blocks) @ inverse)
    return shown / np.diagonal(inverse)
