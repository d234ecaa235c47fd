"""Greatest likelihood by Fisher's scoring, and what it promises beside a point."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.special import chdtri

from peg_on_hole_ros.estimation.identification.likelihood import DELAY, Innovations, Measures

MOST_ITERATIONS = 20
MOST_HALVINGS = 4
# The search ends where a step promises less than this of the logarithm of the likelihood: a tenth
# of a standard deviation in each of ten directions; or less than ROUGH, and none is better.
ENOUGH, ROUGH = 0.05, 1.0
# So many innovations in a row are summed to see how much the scores vary. Those of a filter that
# is right are independent, those under a smoothed wrench or coloured noise are not.
BLOCK = 25
# White noise in one block of a slope is at most so many times that in the median one.
MOST_NOISE = 4.0


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
    anew : callable or None
        As quiet, over the same recording with as much noise of the wrench again: what differs
        from quiet is noise, and no motion tells of it.

    """

    run: Callable[[np.ndarray], Innovations | None]
    quiet: Callable[[np.ndarray], Innovations | None] | None
    centre: np.ndarray
    measures: Measures
    limits: tuple[np.ndarray, np.ndarray]
    anew: Callable[[np.ndarray], Innovations | None] | None = None

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

    def slopes(self, found, x, chosen, told=False):
        """
        Return the scores of all innovations, shape (n, k), and Fisher's information.

        If told, without what noise makes of them: that is what a recording promises. A search
        goes by the whole, whose steps are shorter.
        """
        run, spread = self.quiet or self.run, self.quiet is None
        given = found, x, self.measures.step, self.limits
        means, spreads = _slopes(run, *given, chosen, spread)
        if told and self.anew and DELAY in chosen:
            again, _ = _slopes(self.anew, *given, [DELAY], spread)
            i = chosen.tolist().index(DELAY)
            means[i] = _told(means[i], again[0] - means[i], np.delete(means, i, axis=0))
        return _scores(found, means, spreads)


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
    last = np.zeros(len(chosen))
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
        if move @ information @ last < 0:
            # Each step is the best under the covariances that it begins with: where these go with
            # the coordinates, steps may lead to and fro over the top.
            move = 0.5 * move
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
        last = move
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
    scores, information = likelihood.slopes(found, x, chosen, told=True)
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


def _slopes(run, found, x, steps, limits, chosen, spread):
    """Return slopes of mean and covariance, white, shapes (k, n, 3) and (k, n, 3, 3)."""
    over = np.linalg.inv(found.root)
    means, spreads = [], []
    for i in chosen:
        width, low, high = _beside(run, x, i, steps[i], limits) or (np.inf, found, found)
        means.append(np.einsum("nij,nj->ni", over, (high.residual - low.residual) / width))
        wider = (_square(high.root) - _square(low.root)) / width * spread
        spreads.append(over @ wider @ np.swapaxes(over, 1, 2))
    return np.array(means), np.array(spreads)


def _told(slope, noise, others):
    """
    Return as much of a slope as the motion tells.

    A delay's slope is the wrench's in time, in which what is left of its noise weighs most. That
    is no motion: counted as one, an even motion would tell a delay to a millisecond, wherever it
    is looked at, and any other motion less than it is off by. Of what no other slope explains the
    share stays that is more than noise, as where a regressor is measured with errors (Fuller,
    Measurement Error Models, 1987): the step is then right in the mean, and as uncertain as it is.

    Parameters
    ----------
    slope, noise : ndarray, shape (n, 3)
        White; and what as much noise anew adds to it.
    others : ndarray, shape (k, n, 3)

    """
    size = np.sqrt((others**2).sum(axis=(1, 2)))
    A = (others[size > 0] / size[size > 0, None, None]).reshape(-1, slope.size).T
    own, noise = (
        (one.ravel() - A @ np.linalg.lstsq(A, one.ravel(), rcond=None)[0]).reshape(slope.shape)
        for one in (slope, noise)
    )
    blocks = np.add.reduceat((noise**2).sum(axis=1), np.arange(0, len(noise), BLOCK))
    # Beside a wedge one run takes another way than the other: once, and not for its noise.
    noise = np.minimum(blocks, MOST_NOISE * np.median(blocks)).sum()
    total = (own**2).sum()
    share = max(1.0 - noise / total, 0.0) if total > 0 else 0.0
    return slope - (1.0 - share) * own


def _scores(found, means, spreads):
    """Return the scores of all innovations, shape (n, k), and Fisher's information."""
    white = np.linalg.solve(found.root, found.residual[:, :, None])[:, :, 0]
    scores = (
        0.5 * np.einsum("knij,ni,nj->nk", spreads, white, white)
        - 0.5 * np.einsum("knii->nk", spreads)
        - np.einsum("kni,ni->nk", means, white)
    )
    flat, wide = (part.reshape(len(means), -1) for part in (means, spreads))
    return scores, flat @ flat.T + 0.5 * wide @ wide.T


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
