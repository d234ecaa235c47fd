"""Greatest likelihood by Fisher's scoring, and what it promises beside a point."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.special import chdtri

from peg_on_hole_ros.estimation.identification.likelihood import Innovations, Measures

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
    converged : bool

    """

    x: np.ndarray
    converged: bool


class Tangent(NamedTuple):
    """
    What the scores at a point promise, with all coordinates free.

    Attributes
    ----------
    step : ndarray, shape (k,)
        From the point to where the likelihood would be greatest, were it as it is at the point.
    covariance : ndarray, shape (k, k)
        Of the end of the step: from Fisher's information and a wide prior, as a whole wider by
        how much the scores vary more than the information promises.
    stddev : ndarray, shape (k,)
        The same, each wider by its own measure.
    found : Innovations

    """

    step: np.ndarray
    covariance: np.ndarray
    stddev: np.ndarray
    found: Innovations


class Likelihood(NamedTuple):
    """
    A likelihood of a recording, and where its slopes are taken.

    Attributes
    ----------
    run : callable
        From coordinates, shape (14,), to innovations; None where they are not finite.
    quiet : callable or None
        As run, over the same recording with its noise smoothed away; where given, slopes are
        taken there, and covariances stay during a step. Slopes along the noisy motion go with
        the very noise that is in the innovations, and covariances are never quite right: each
        would move values by one to two standard deviations. None, for noise levels: slopes of
        mean and covariance where the innovations are.
    centre : ndarray, shape (14,)
        Of the prior, of spread `measures.range`.
    measures : Measures
    limits : tuple of ndarray, shape (14,)
        Least and greatest coordinates; nothing is run beyond them.

    """

    run: Callable[[np.ndarray], Innovations | None]
    quiet: Callable[[np.ndarray], Innovations | None] | None
    centre: np.ndarray
    measures: Measures
    limits: tuple[np.ndarray, np.ndarray]

    def at(self, x, root=None) -> Innovations | None:
        """Return the innovations at x, with a given root of their covariance if any."""
        found = self.run(np.clip(x, *self.limits))
        return found if found is None or root is None else found._replace(root=root)

    def weight(self, chosen) -> np.ndarray:
        """Return the prior's information on chosen coordinates, shape (k, k)."""
        return np.diag(self.measures.range[chosen] ** -2.0)

    def value(self, found, x, chosen) -> float:
        """Return the logarithm of likelihood and prior."""
        gone = (x - self.centre)[chosen]
        return float(found.log_likelihood.sum() - 0.5 * gone @ self.weight(chosen) @ gone)

    def slopes(self, found, x, chosen):
        """Return the scores of all innovations, shape (n, k), and Fisher's information."""
        run, spread = self.quiet or self.run, self.quiet is None
        return _slopes(found, run, x, chosen, self.measures.step, self.limits, spread)


def greatest(likelihood: Likelihood, x: np.ndarray, free: np.ndarray) -> Peak | None:
    """
    Return the peak near x, or None where the filter has no finite innovations there.

    Parameters
    ----------
    likelihood : Likelihood
    x : ndarray, shape (14,)
        Where to begin.
    free : ndarray of bool, shape (14,)
        What is searched for.

    """
    chosen = np.flatnonzero(free)
    weight = likelihood.weight(chosen)
    x = np.clip(x, *likelihood.limits)
    found = likelihood.at(x)
    if found is None:
        return None
    for _ in range(MOST_ITERATIONS):
        root = found.root if likelihood.quiet else None
        scores, information = likelihood.slopes(found, x, chosen)
        slope = scores.sum(axis=0) - weight @ (x - likelihood.centre)[chosen]
        # What would go on beyond its limit stays there, and the others move as if it were known.
        low, high = (limit[chosen] == x[chosen] for limit in likelihood.limits)
        moving = ~(low & (slope < 0) | high & (slope > 0))
        move = np.zeros(len(chosen))
        among = np.ix_(moving, moving)
        move[moving] = np.linalg.solve((information + weight)[among], slope[moving])
        promised = float(0.5 * slope @ move)
        if promised < ENOUGH:
            break
        best = likelihood.value(found, x, chosen)
        for _ in range(MOST_HALVINGS):
            trial = x.copy()
            trial[chosen] += move
            trial = np.clip(trial, *likelihood.limits)
            there = likelihood.at(trial, root)
            if there is not None and likelihood.value(there, trial, chosen) > best:
                break
            move = 0.5 * move
        else:
            break
        x, found = trial, likelihood.at(trial) if likelihood.quiet else there
    return Peak(x, promised < ROUGH)


def tangent(likelihood: Likelihood, x, chosen) -> Tangent | None:
    """
    Return what the scores at x promise, or None where the innovations are not finite.

    Parameters
    ----------
    likelihood : Likelihood
    x : ndarray, shape (14,)
    chosen : ndarray of int, shape (k,)
        Coordinates that are looked at.

    """
    found = likelihood.at(x)
    if found is None:
        return None
    scores, information = likelihood.slopes(found, x, chosen)
    weight = likelihood.weight(chosen)
    inverse = np.linalg.inv(information + weight)
    step = inverse @ (scores.sum(axis=0) - weight @ (x - likelihood.centre)[chosen])
    blocks = _blocks(scores)
    own = np.diagonal(inverse @ (blocks.T @ blocks) @ inverse) / np.diagonal(inverse)
    # One measure for all keeps the directions in which the recording tells little. Of all blocks
    # and directions it is known far better than of any one, and a few outliers do not hide that
    # a noise level is wrong.
    k = len(chosen)
    squares = len(blocks) * np.einsum("ni,ij,nj->n", blocks, inverse, blocks)
    wider = max(np.median(squares) / chdtri(k, 0.5), 1.0)
    stddev = np.sqrt(np.diagonal(inverse) * np.maximum(own, 1.0))
    return Tangent(step, inverse * wider, stddev, found)


def _slopes(found, run, x, chosen, steps, limits, spread):
    over = np.linalg.inv(found.root)
    white = np.einsum("nij,nj->ni", over, found.residual)
    scores, means, spreads = [], [], []
    for i in chosen:
        width, low, high = _beside(run, x, i, steps[i], limits) or (np.inf, found, found)
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


def _beside(run, x, i, step, limits):
    """
    Return how far apart two points along a coordinate are, and the innovations there, or None.

    A step to either side, but not beyond limits, where a configuration may not exist, nor to where
    no innovation is finite: on that side the difference ends at x. None where it has no two ends.
    """
    ends = []
    for offset in (max(-step, limits[0][i] - x[i]), min(step, limits[1][i] - x[i])):
        beside = x.copy()
        beside[i] += offset
        there = run(beside)
        if there is None:
            offset, there = 0.0, run(x)
        ends.append((offset, there))
    (low_offset, low), (high_offset, high) = ends
    if low is None or high is None or high_offset <= low_offset:
        return None
    return high_offset - low_offset, low, high


def _square(root):
    return root @ np.swapaxes(root, 1, 2)


def _blocks(scores):
    """Return sums over blocks less their mean, with squares that add up to the whole's, (b, k)."""
    blocks = np.add.reduceat(scores, np.arange(0, len(scores), BLOCK), axis=0)
    return (blocks - blocks.mean(axis=0)) * np.sqrt(len(blocks) / (len(blocks) - 1))
