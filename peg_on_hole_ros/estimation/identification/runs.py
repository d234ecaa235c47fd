"""The likelihoods of one recording, of motion and of noise, with their slopes and peaks."""

from math import log

import numpy as np

from peg_on_hole_ros.estimation.identification.likelihood import (
    IS_NOISE,
    coordinates,
    innovations,
)
from peg_on_hole_ros.estimation.identification.noise_levels import noise_levels
from peg_on_hole_ros.estimation.identification.recording import quiet, smoothed
from peg_on_hole_ros.estimation.identification.scoring import (
    Likelihood,
    Tangent,
    greatest,
    tangent,
)

# The weights of the first search rest on a guess of the noise; off by more, it is done again.
NOISE_OFF = log(1.2)
# In ranges of a quantity, from the start.
FARTHEST = 2.0
# As often at most: two likelihoods that take turns need not come to an end.
MOST_TURNS = 6
# A larger share of joint states without motion, and slopes say nothing.
MOST_LOST = 0.01


def _noisier(record, start):
    """Return the recording with as much white noise of the wrench again, always the same."""
    stated = start.wrench.force_stddev, start.wrench.torque_stddev
    levels = [found or one for found, one in zip(noise_levels(record), stated)]
    drawn = np.random.default_rng(0).normal(size=record.wrench.shape)
    return record._replace(wrench=record.wrench + drawn * np.repeat(levels, 3))


class Runs:
    """
    Runs of the filter over one recording, counted for the progress.

    Attributes
    ----------
    scale : Measures
    left : float
        Share that is left to do, as the progress has been told.

    """

    # Of a usual calibration.
    USUAL = 120

    def __init__(self, record, parts, start, limits, scale, progress):
        self._record, self._parts, self._start = record, parts, start
        self._progress, self._count = progress, 0
        self.scale, self.left = scale, 1.0
        records = smoothed(record), quiet(record), quiet(_noisier(record, start))
        loud, still, anew = (lambda x, r=r: self.once(x, r) for r in records)
        centre = coordinates(start)
        self._motion = Likelihood(loud, still, centre, scale, limits, anew)
        self._noise = Likelihood(self.once, None, centre, scale, limits)

    def once(self, x, record=None):
        """Return the innovations at x, of the recording as it is or of another one; or None."""
        self._count += 1
        # Ever nearer to the end, also where it takes longer than usual.
        self.left = 2.0 ** (-2.0 * self._count / self.USUAL)
        self._progress(1.0 - self.left)
        return innovations(record or self._record, self._parts, self._start, x)

    def tangent(self, x):
        """Return what motion and noise promise at x, or None where nothing can be promised."""
        step, stddev = np.zeros((2, len(x)))
        covariance = np.zeros((len(x), len(x)))
        for likelihood, part in ((self._motion, ~IS_NOISE), (self._noise, IS_NOISE)):
            found = tangent(likelihood, x, np.flatnonzero(part))
            if found is None or found.found.lost > MOST_LOST:
                return None
            step[part], stddev[part] = found.step, found.stddev
            covariance[np.ix_(part, part)] = found.covariance
        return Tangent(step, covariance, stddev, found.found)

    def peak(self, x, free):
        """Return the most likely free coordinates near x; None where there are none."""
        # Farther off than is likely at all, slopes that led there have not been these.
        centre, most = self._motion.centre, FARTHEST * self._motion.measures.range
        return self.climb(np.clip(x, centre - most, centre + most), free)

    def climb(self, x, free):
        """Return the most likely free coordinates from x on, however far off it is; or None."""
        noise = free & IS_NOISE
        for _ in range(MOST_TURNS):
            x = self._greatest(self._motion, x, free & ~IS_NOISE)
            x, before = self._greatest(self._noise, x, noise), x
            # The motion's weights rest on the noise.
            if x is None or np.abs(x - before)[noise].max(initial=0.0) <= NOISE_OFF:
                return x
        return None

    @staticmethod
    def _greatest(likelihood, x, free):
        if x is None or not free.any():
            return x
        peak = greatest(likelihood, x, free)
        return peak.x if peak is not None and peak.converged else None
