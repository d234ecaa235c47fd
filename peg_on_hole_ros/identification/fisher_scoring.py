"""Greatest likelihood by Fisher's scoring, from several starts."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.identification.likelihood import Likelihood, LikelihoodRun
from peg_on_hole_ros.identification.quantities import SearchScales
from peg_on_hole_ros.identification.tuned import SCORING


class Peak(NamedTuple):
    """
    Where the likelihood is greatest.

    Attributes
    ----------
    x : ndarray, shape (14,)
    value : float
        Logarithm of likelihood and prior.
    information : ndarray, shape (k, k)
        Of the recording on the free coordinates, without the prior.
    scores : ndarray, shape (blocks, k)
        Slopes of the log likelihood, summed over `SCORING.block` events each.
    run : Run
    converged : bool

    """

    x: np.ndarray
    value: float
    information: np.ndarray
    scores: np.ndarray
    run: LikelihoodRun
    converged: bool


class Slopes(NamedTuple):
    """Information (k, k) and scores (n, k), an event a row."""

    information: np.ndarray
    scores: np.ndarray


class Search:
    """
    Searches for the greatest likelihood of one recording.

    Parameters
    ----------
    likelihood : Likelihood
    still : Likelihood
        Of the same recording with its noise smoothed away: what moves its innovations is the
        motion. Of the recording as it is, noise that goes through the equations' slopes makes ten
        times the information of what is hardly told.
    centre : ndarray, shape (14,)
        Of the prior, of spread `measures.range`.
    measures : SearchScales
    limits : tuple of ndarray, shape (14,)
        Least and greatest coordinates; nothing is run beyond them.
    progress : callable
        Told after each run.

    """

    def __init__(
        self,
        likelihood: Likelihood,
        still: Likelihood,
        centre: np.ndarray,
        measures: SearchScales,
        limits: tuple[np.ndarray, np.ndarray],
        progress: Callable[[], None] = lambda: None,
    ) -> None:
        self._likelihood, self._still = likelihood, still
        self._centre, self.measures = centre, measures
        self._limits, self._progress = limits, progress

    def _run(self, x):
        self._progress()
        return self._likelihood.run(x)

    def value(self, run: LikelihoodRun, x: np.ndarray) -> float:
        """Return the logarithm of likelihood and prior."""
        return run.total - 0.5 * float((((x - self._centre) / self.measures.range) ** 2).sum())

    def at(self, x: np.ndarray) -> float:
        """Return the same of coordinates, minus infinity where there is none."""
        run = self._run(np.clip(x, *self._limits))
        return -np.inf if run is None else self.value(run, x)

    def slopes(self, run: LikelihoodRun, x: np.ndarray, free: np.ndarray) -> Slopes | None:
        """
        Return what a recording tells of the free coordinates at a point; None where it cannot be.

        The information is that of normal innovations: how their mean moves, over their spread.
        Without noise it is true where the run explains the recording, and jumps elsewhere.
        """
        told_by = self._still if run.nis.mean() < SCORING.explained_nis else self._likelihood
        here = told_by.run(x, detailed=True)
        if here is None:
            return None
        told = np.einsum("nii->n", here.innovations.covariance) > 0
        covariance = here.innovations.covariance[told]
        try:
            root = np.linalg.inv(np.linalg.cholesky(covariance + _padding(covariance)))
        except np.linalg.LinAlgError:
            # Rounding has left a covariance that is not positive definite: of a scene that is far
            # off, or of innovations that say nothing.
            return None
        means, scores = [], []
        for i in free:
            ahead, behind = (np.clip(self._beside(x, i, sign), *self._limits) for sign in (1, -1))
            one, other = self._run(ahead), self._run(behind)
            end = ahead if ahead[i] > x[i] else behind
            moved = told_by.run(end, here.innovations.chosen, True)
            if one is None or other is None or moved is None:
                return None
            scores.append((one.log_likelihood - other.log_likelihood) / (ahead - behind)[i])
            gone = (moved.innovations.residual - here.innovations.residual)[told] / (end - x)[i]
            means.append(np.einsum("nij,nj->ni", root, gone))
        J = np.array(means).reshape(len(free), -1)
        found = Slopes(J @ J.T, np.array(scores).T)
        return found if all(np.isfinite(part).all() for part in found) else None

    def _beside(self, x, i, sign):
        there = x.copy()
        there[i] += sign * self.measures.step[i]
        return there

    def climb(self, x: np.ndarray, free: np.ndarray, most: int) -> Peak | None:
        """
        Return the peak that is reached from x; None where there is no likelihood.

        Parameters
        ----------
        x : ndarray, shape (14,)
        free : ndarray of int
            The coordinates that are searched for.
        most : int
            Iterations.

        """
        x = np.clip(x, *self._limits)
        run = self._run(x)
        if run is None:
            return None
        value, converged, slopes = self.value(run, x), False, None
        if not len(free):
            return Peak(x, value, np.zeros((0, 0)), np.zeros((1, 0)), run, True)
        for _ in range(most):
            slopes = self.slopes(run, x, free)
            if slopes is None:
                return None
            moved = self._ascend(x, value, slopes, free)
            if moved is None:
                converged = True
                break
            x, before, value = moved[0], value, moved[1]
            run = self._run(x)
            if value - before < SCORING.least_gain:
                converged = True
                break
        scores = _blocks(slopes.scores)
        return Peak(x, value, slopes.information, scores, run, converged)

    def _ascend(self, x, value, slopes, free):
        """Return better coordinates and their value; None where no step promises more."""
        prior = self.measures.range[free] ** -2.0
        slope = slopes.scores.sum(axis=0) - prior * (x - self._centre)[free]
        low, high = (limit[free] == x[free] for limit in self._limits)
        # What would go beyond its limit stays there, and the others move as if it were known.
        moving = ~(low & (slope < 0) | high & (slope > 0))
        weight = (slopes.information + np.diag(prior))[np.ix_(moving, moving)]
        step = np.zeros(len(free))
        step[moving] = np.linalg.solve(weight, slope[moving])
        if slope @ step < 2.0 * SCORING.least_promise:
            return None
        # No farther at once than the whole range of a quantity.
        step /= max(1.0, np.abs(step / self.measures.range[free]).max())
        for _ in range(SCORING.most_halvings):
            there = x.copy()
            there[free] += step
            there = np.clip(there, *self._limits)
            reached = self.at(there)
            if reached > value:
                return there, reached
            step = SCORING.shortening * step
        return None


def _padding(covariance):
    """Return ones for the rows that an orientation leaves empty."""
    empty = np.einsum("nii->ni", covariance) == 0.0
    return np.einsum("ni,ij->nij", empty.astype(float), np.eye(6))


def _blocks(scores):
    """Return sums over `SCORING.block` rows each, shape (blocks, k)."""
    count = max(len(scores) // SCORING.block, 1)
    return np.array([part.sum(axis=0) for part in np.array_split(scores, count)])
