"""A low-pass before the wrench, by how alike it makes the noise of neighbours."""

from collections import deque
from math import log, pi

import numpy as np

from peg_on_hole_ros.identification.tuned import LOW_PASS_TEST


class NoiseOfNeighbours:
    """
    The noise of neighbouring wrenches beside that of wrenches apart, in forces and in torques.

    Of white noise both are one; a motion makes those apart differ, so the quietest stretch counts.

    Parameters
    ----------
    force_stddev, torque_stddev : float
        Stated noise, of which far less is none to compare [N], [N m].

    Attributes
    ----------
    stretches : int
        So many have been compared.

    """

    def __init__(self, force_stddev: float, torque_stddev: float) -> None:
        stated = np.array([force_stddev] * 3 + [torque_stddev] * 3)
        self._least = np.square(LOW_PASS_TEST.noisy * stated)
        self._ratio, self._period = float("inf"), 0.0
        self._ratios: deque[float] = deque(maxlen=LOW_PASS_TEST.kept)
        self.stretches = 0

    def compare(self, t_ns: np.ndarray, wrenches: np.ndarray) -> bool:
        """
        Compare a stretch of `LOW_PASS_TEST.stretch` wrenches.

        Parameters
        ----------
        t_ns : ndarray of int64, shape (n,)
            [ns].
        wrenches : ndarray, shape (n, 6)
            [N], [N m].

        Returns
        -------
        bool
            Whether it could be compared.

        """
        steps = np.diff(t_ns)
        period = float(np.median(steps)) * 1e-9
        # Values that repeat, or are rounded, are another matter; so is a gap.
        still = (np.diff(wrenches, axis=0) == 0.0).all(axis=1).mean()
        if period <= 0.0 or steps.max() > 2.0 * np.median(steps) or still > 0.02:
            return False
        near, apart = (_curved(wrenches, lag) for lag in (1, LOW_PASS_TEST.apart))
        if not (near > self._least).all():
            return False
        # A motion is in some of the six.
        ratio = apart / near
        quieter = min(float(np.median(ratio[:3])), float(np.median(ratio[3:])))
        self._ratios.append(quieter)
        self._ratio = min(self._ratio, quieter)
        self._period = period
        self.stretches += 1
        return True

    @property
    def enough(self) -> bool:
        """Whether enough stretches have been compared for anything to be said."""
        return self.stretches >= LOW_PASS_TEST.enough

    @property
    def pole(self) -> float:
        """Pole of the first-order low-pass that makes neighbours so alike; 0: none is seen."""
        alike = LOW_PASS_TEST.alike <= self._ratio <= LOW_PASS_TEST.steepest
        if not (self.enough and alike):
            return 0.0
        # The quietest of many is quieter than the noise, by chance; those like it are not.
        like = [ratio for ratio in self._ratios if ratio < LOW_PASS_TEST.as_quiet * self._ratio]
        return _pole(min(float(np.mean(like or [self._ratio])), LOW_PASS_TEST.steepest))

    @property
    def cutoff(self) -> float:
        """Cut-off of that low-pass [Hz]; 0: none is seen."""
        return -log(self.pole) / (2.0 * pi * self._period) if self.pole > 0.0 else 0.0


def noise_of_neighbours(
    t: np.ndarray, wrenches: np.ndarray, stated: tuple[float, float]
) -> NoiseOfNeighbours:
    """
    Compare a whole recording.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Stamps [s].
    wrenches : ndarray, shape (n, 6)
        [N], [N m].
    stated : tuple of float
        Noise of force and torque [N], [N m].

    """
    found, length = NoiseOfNeighbours(*stated), LOW_PASS_TEST.stretch
    t_ns = np.round(t * 1e9).astype(np.int64)
    for begin in range(0, len(t) - length + 1, length):
        found.compare(t_ns[begin : begin + length], wrenches[begin : begin + length])
    return found


def white_ratio(pole: float, weights: np.ndarray) -> float:
    """
    Return by how much filtered noise is underestimated as white noise of its density.

    Parameters
    ----------
    pole : float
        Of a first-order low-pass.
    weights : ndarray, shape (k,)
        Of neighbouring samples, in whose weighted sums the noise was measured.

    Returns
    -------
    float
        Standard deviation of white noise of the same density over that which was measured.

    """
    lags = np.abs(np.subtract.outer(np.arange(len(weights)), np.arange(len(weights))))
    seen = float(weights @ pole**lags @ weights) / float(weights @ weights)
    return float(np.sqrt((1.0 + pole) / (1.0 - pole) / seen))


def _curved(wrenches: np.ndarray, lag: int) -> np.ndarray:
    """Return the variance of second differences over a lag, of white noise that of the noise."""
    second = wrenches[2 * lag :] - 2.0 * wrenches[lag:-lag] + wrenches[: -2 * lag]
    return np.asarray(np.mean(np.square(second), axis=0) / 6.0)


def _pole(ratio: float) -> float:
    """Return the pole of a first-order filter that has such a ratio, by halving."""
    low, high = 0.0, 1.0 - 1e-6
    for _ in range(50):
        pole = 0.5 * (low + high)
        near, apart = (
            3.0 - 4.0 * pole**lag + pole ** (2 * lag) for lag in (1, LOW_PASS_TEST.apart)
        )
        low, high = (pole, high) if apart / near < ratio else (low, pole)
    return pole
