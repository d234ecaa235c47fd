"""Fixed-interval smoothing: what a whole recording says of every one of its stamps."""

from math import exp
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.estimator.held_peg import HeldPeg
from peg_on_hole_ros.estimator.state import ACCELERATION, RATE


class _Step(NamedTuple):
    # A prediction: mean and covariance before and after it, and the transition between them; None
    # where a motion began instead.
    before: tuple[np.ndarray, np.ndarray]
    after: tuple[np.ndarray, np.ndarray] | None
    F: np.ndarray | None


class Smoother(HeldPeg):
    """
    The estimator, keeping what `smooth` needs: some 3 kB a prediction.

    Its own estimates are those of `HeldPeg`, bit for bit. Backwards the mixture counts as one
    normal distribution at each stamp, that of its mean and covariance (Rauch, Tung, Striebel).
    """

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._steps: list[_Step] = []
        self._marks: list[tuple[int, int]] = []

    def start(self, q: ArrayLike, R: ArrayLike) -> None:
        """Start; nothing later tells of what was before."""
        super().start(q, R)
        self._steps.append(_Step(self._estimate(), None, None))

    def predict(self, dt: float) -> None:
        """Move the estimate on by dt [s], and keep how."""
        before = self._estimate()
        super().predict(dt)
        self._steps.append(_Step(before, self._estimate(), self._transition(dt)))

    def mark(self, t_ns: int) -> None:
        """Take note of the stamp [ns] of a wrench that has been taken."""
        self._marks.append((t_ns, len(self._steps)))

    def _estimate(self):
        n = self._n
        return self.state.mean[:n].copy(), self.state.covariance[:n, :n].copy()

    def _transition(self, dt):
        weight = self.state.weight.reshape(-1, len(self.constants.level)).sum(axis=0)
        kept = sum(w * exp(-dt / tau) for w, tau in zip(weight, self.constants.time))
        F = np.eye(self._n)
        for i in range(3):
            F[i, RATE + i] = dt
            F[i, ACCELERATION + i] = 0.5 * dt * dt
            F[RATE + i, ACCELERATION + i] = dt
            F[ACCELERATION + i, ACCELERATION + i] = kept
        return F

    def smooth(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """
        Return the smoothed state at the stamps of all wrenches.

        Returns
        -------
        t_ns : ndarray, shape (k,)
        state : ndarray, shape (k, 6)
            As `HeldPeg.x`.
        covariance : ndarray, shape (k, 6, 6)

        """
        t_ns, state, covariance = self.smooth_all()
        return t_ns, state[:, :6], covariance[:, :6, :6]

    def smooth_all(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return what `smooth` does of all that is estimated, n values, but the reactions."""
        t_ns, n = np.array([t for t, _ in self._marks], np.int64), self._n
        state, covariance = np.empty((len(t_ns), n)), np.empty((len(t_ns), n, n))
        x, P = self._estimate()
        row = len(t_ns) - 1
        for k in range(len(self._steps), 0, -1):
            # A step's end is where the next one, or the recording's end, stands.
            while row >= 0 and self._marks[row][1] == k:
                state[row], covariance[row] = x, P
                row -= 1
            x, P = _back(self._steps[k - 1], x, P)
        return t_ns, state, covariance


def _back(step: _Step, x, P):
    """Return mean and covariance before a prediction by those after it."""
    mean, cov = step.before
    if step.F is None:
        return mean, cov
    predicted, spread = step.after
    # In units of its own deviations, since rates and angles differ by orders of magnitude.
    scale = 1.0 / np.sqrt(np.maximum(np.diagonal(spread), 1e-30))
    scaled = spread * np.outer(scale, scale)
    gain = np.linalg.lstsq(scaled, (step.F @ cov) * scale[:, None], rcond=1e-12)[0].T * scale
    back = cov + gain @ (P - spread) @ gain.T
    return mean + gain @ (x - predicted), 0.5 * (back + back.T)
