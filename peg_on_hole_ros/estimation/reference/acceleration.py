"""How a held peg moves of late, in plain numpy: what `acceleration` and `tangent` are held to."""

import numpy as np

from peg_on_hole_ros.estimation.kernel.acceleration import (
    CHANGED,
    CHANGES_AVERAGED,
    FOLLOWED,
    SHORTEST_TIME,
)
from peg_on_hole_ros.estimation.kernel.tangent import AVERAGED, KNOWN
from peg_on_hole_ros.estimation.kernel.tangent import CHANGED as FAR


class FollowedAcceleration:
    """
    The angles' accelerations as their rates went of late, and how much that has changed.

    Attributes
    ----------
    mean : ndarray, shape (3,)
        Followed acceleration [rad/s^2].
    before : ndarray, shape (3,)
        What that was within its own time constant [rad/s^2].
    changes : ndarray, shape (3,)
        Mean square of its changes of late [rad^2/s^4].
    seen : float
        Share of them that was seen, from 0 at the start to 1.
    rates : ndarray, shape (3,), or None
        At the last correction [rad/s]; None before the first.

    """

    def __init__(self):
        self.mean, self.before, self.changes = np.zeros(3), np.zeros(3), np.zeros(3)
        self.seen, self.rates = 0.0, None

    def follow(self, rates, dt):
        """Follow the rates [rad/s], dt [s] after the last ones; the first are no change."""
        dt = max(dt, SHORTEST_TIME)
        if self.rates is not None:
            now = (rates - self.rates) / dt
            share, averaged = min(dt / FOLLOWED, 1.0), min(dt / CHANGES_AVERAGED, 1.0)
            self.mean = self.mean + share * (now - self.mean)
            change = self.mean - self.before
            self.before = self.before + share * change
            self.changes = self.changes + averaged * (change**2 - self.changes)
            self.seen += averaged * (1 - self.seen)
        self.rates = rates.copy()

    def covariance(self, stddev, least, silence):
        """Return how far the accelerations may be from the mean, shape (3, 3), see there."""
        unseen = 1 - self.seen + max(silence - FOLLOWED, 0.0) / CHANGES_AVERAGED
        seen = self.changes + unseen * stddev**2
        of_late = np.clip(seen, (least * stddev) ** 2, stddev**2)
        return np.diag(of_late + (CHANGED * self.mean) ** 2)


class MeanRates:
    """
    The mean of the rates of late, each correction by what it knows of them.

    Attributes
    ----------
    mean : ndarray, shape (3,)
        [rad/s].
    weight : ndarray, shape (3,)
        [s/(rad/s)^2].

    """

    def __init__(self):
        self.mean, self.weight = np.zeros(3), np.zeros(3)

    def follow(self, rates, variance, dt):
        """Follow rates [rad/s] and their variance, each (3,), dt [s] after the last ones."""
        dt = max(dt, SHORTEST_TIME)
        self.weight = max(1 - dt / AVERAGED, 0.0) * self.weight + dt / variance
        self.mean = self.mean + dt / variance / self.weight * (rates - self.mean)

    def known(self, rates, variance) -> bool:
        """Return whether the mean is known, and that of rates which have not changed since."""
        near = (rates - self.mean) ** 2 <= FAR**2 * variance
        return bool(near.all() and (self.weight * variance > KNOWN * AVERAGED).all())
