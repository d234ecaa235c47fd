"""Fixed-interval smoothing: what a whole recording shows of every one of its stamps."""

from collections.abc import Iterator
from math import exp
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.offset_uncertainty import OffsetUncertainty
from peg_on_hole_ros.estimator.settings import Settings
from peg_on_hole_ros.estimator.snapshot import Words
from peg_on_hole_ros.estimator.state import ACCELERATION, RATE
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.typed_record import Floats


class _Prediction(NamedTuple):
    # Mean and covariance after a prediction, and the transition to them.
    mean: Floats
    covariance: Floats
    F: Floats


class _Step(NamedTuple):
    # Mean and covariance before a prediction; there is none where a motion began instead.
    before: tuple[Floats, Floats]
    prediction: _Prediction | None


class Smoother(ContactFilter):
    """
    The estimator, keeping what `smooth` needs: some 3 kB a prediction.

    Its own estimates are those of `ContactFilter`, bit for bit. Backwards the mixture counts as
    one normal distribution at each stamp, that of its mean and covariance (Rauch, Tung, Striebel).
    """

    def __init__(
        self,
        scene: Scene,
        options: FilterOptions,
        wrench_noise: Floats,
        offsets: OffsetUncertainty | None = None,
        settings: Settings | None = None,
    ) -> None:
        super().__init__(scene, options, wrench_noise, offsets, settings)
        self._steps: list[_Step] = []
        self._marks: list[tuple[int, int]] = []

    def start(self, q: ArrayLike, R: ArrayLike) -> None:
        """Start; what comes later determines nothing of what was before."""
        super().start(q, R)
        self._steps.append(_Step(self._estimate(), None))

    def predict(self, dt: float) -> None:
        """Predict by dt [s], and keep how."""
        before = self._estimate()
        super().predict(dt)
        self._steps.append(_Step(before, _Prediction(*self._estimate(), self._transition(dt))))

    def mark(self, t_ns: int) -> None:
        """Note the stamp [ns] of a wrench that has been taken."""
        self._marks.append((t_ns, len(self._steps)))

    def _estimate(self) -> tuple[Floats, Floats]:
        n, whole = self._n, self.mixture
        return whole.mean[:n].copy(), whole.covariance[:n, :n].copy()

    def _transition(self, dt: float) -> Floats:
        modes = int(self.settings.modes)
        weight = self.mixture.weight.reshape(-1, modes).sum(axis=0)
        kept = sum(w * exp(-dt / tau) for w, tau in zip(weight, self.settings.mode_time))
        F = np.eye(self._n)
        for i in range(3):
            F[i, RATE + i] = dt
            F[i, ACCELERATION + i] = 0.5 * dt * dt
            F[RATE + i, ACCELERATION + i] = dt
            F[ACCELERATION + i, ACCELERATION + i] = kept
        return F

    def smooth(self) -> tuple[Words, Floats, Floats]:
        """
        Return the smoothed state at the stamps of all wrenches.

        Returns
        -------
        t_ns : ndarray, shape (k,)
        state : ndarray, shape (k, 6)
            As `ContactFilter.x`.
        covariance : ndarray, shape (k, 6, 6)

        """
        t_ns, state, covariance = self.smooth_all()
        return t_ns, state[:, :6], covariance[:, :6, :6]

    def smooth_all(self, lag_ns: int | None = None) -> tuple[Words, Floats, Floats]:
        """
        Return what `smooth` does of all that is estimated, n values, but the reactions.

        Parameters
        ----------
        lag_ns : int, optional
            A stamp is told by what comes until one to two such times after it [ns]; None: by the
            whole recording.

        """
        t_ns, n = np.array([t for t, _ in self._marks], np.int64), self._n
        state, covariance = np.empty((len(t_ns), n)), np.empty((len(t_ns), n, n))
        for rows, end in self._stretches(t_ns, lag_ns):
            at_end = end == len(self._steps)
            x, P = self._estimate() if at_end else self._steps[end].before
            row = rows.stop - 1
            for k in range(end, 0, -1):
                # A step's end is where the next one, or the recording's end, stands.
                while row >= rows.start and self._marks[row][1] == k:
                    state[row], covariance[row] = x, P
                    row -= 1
                if row < rows.start:
                    break
                x, P = _back(self._steps[k - 1], x, P)
        return t_ns, state, covariance

    def _stretches(self, t_ns: Words, lag_ns: int | None) -> Iterator[tuple[range, int]]:
        """Yield rows that are told together, and how many steps are known by then."""
        if lag_ns is None or not len(t_ns):
            yield range(len(t_ns)), len(self._steps)
            return
        for begin in range(int(t_ns[0]), int(t_ns[-1]) + 1, lag_ns):
            first, after = np.searchsorted(t_ns, [begin, begin + lag_ns]).tolist()
            known = int(np.searchsorted(t_ns, begin + 2 * lag_ns, side="right")) - 1
            if first < after:
                yield range(first, after), self._marks[known][1]


def _back(step: _Step, x: Floats, P: Floats) -> tuple[Floats, Floats]:
    """Return mean and covariance before a prediction by those after it."""
    mean, cov = step.before
    if step.prediction is None:
        return mean, cov
    predicted, spread, F = step.prediction
    # In units of its own deviations, since rates and angles differ by orders of magnitude.
    scale = 1.0 / np.sqrt(np.maximum(np.diagonal(spread), 1e-30))
    scaled = spread * np.outer(scale, scale)
    gain = np.linalg.lstsq(scaled, (F @ cov) * scale[:, None], rcond=1e-12)[0].T * scale
    back = cov + gain @ (P - spread) @ gain.T
    return mean + gain @ (x - predicted), 0.5 * (back + back.T)
