"""Constant rates in plain numpy: what `bridging` and `constant_rates` are held to."""

import numpy as np
from filterpy.kalman import KalmanFilter

from peg_on_hole_ros.estimation.kernel.acceleration import FOLLOWED
from peg_on_hole_ros.estimation.kernel.bridging import (
    ADAPTATION,
    GROWS,
    LEANING,
    MOST_RATE_NOISE,
    SLOW_RATES,
    TILT_WALK,
)
from peg_on_hole_ros.estimation.kernel.constant_rates import STEADY
from peg_on_hole_ros.estimation.kernel.lean import LEANT_OVER, MOST_SURPRISE
from peg_on_hole_ros.estimation.reference.acceleration import FollowedAcceleration


def random_walk(density, h, size):
    """Return what a random walk of the rates, of density () or (3,), adds over a time."""
    Q = np.zeros((size, size))
    for i, each in enumerate(np.broadcast_to(density, 3)):
        walk = [[h**3 / 3, h**2 / 2], [h**2 / 2, h]]
        Q[np.ix_([i, 3 + i], [i, 3 + i])] = each * np.array(walk)
    return Q


class RateNoise:
    """
    The random walk of rates that are taken for constant, as innovations have it.

    Parameters
    ----------
    least : float
        Of slow rates [rad/s^1.5].

    Attributes
    ----------
    value : float
        [rad/s^1.5].
    lean : ndarray, shape (3,)
        Mean of the white innovations of late.

    """

    def __init__(self, least):
        self._least = self.value = least
        self.lean = np.zeros(3)

    def density(self, acceleration, tilt=TILT_WALK):
        """
        Return how each rate may wander [rad^2/s^3], shape (3,).

        Parameters
        ----------
        acceleration : ndarray, shape (3,)
            Of late [rad/s^2].
        tilt : float
            Share of the random walk by which the tilt's rate walks.

        """
        walk = self.value * np.array([tilt, 1.0, 1.0])
        return walk**2 + FOLLOWED * acceleration**2

    def adapt(self, residual, covariance, rates, spread, grows):
        """
        Follow an innovation.

        Parameters
        ----------
        residual, covariance : ndarray
            Of the innovation [rad].
        rates, spread : ndarray
            The estimate's, before it is corrected, and their covariance.
        grows : bool
            Whether the least walk grows with the rates.

        """
        white = np.linalg.solve(np.linalg.cholesky(covariance), residual)
        surprise = min(white @ white / 3, MOST_SURPRISE)
        white *= min(1.0, np.sqrt(3 * MOST_SURPRISE / max(white @ white, 1e-300)))
        self.lean = self.lean + (white - self.lean) / LEANT_OVER
        lean = min(self.lean @ self.lean / 3 * (2 * LEANT_OVER - 1), MOST_SURPRISE)
        growth = ADAPTATION * (surprise - 1) + LEANING * (lean - 1)
        least = self.least(rates, spread, grows)
        self.value = np.clip(self.value * np.exp(growth), least, MOST_RATE_NOISE)

    def least(self, rates, spread, grows):
        """Return the least that it may be; see `adapt`."""
        square = rates @ rates - np.trace(spread)
        faster = np.sqrt(max(square, SLOW_RATES**2)) / SLOW_RATES if grows else 1.0
        return self._least * faster**GROWS


class ConstantRates(KalmanFilter):
    """
    Angles and rates by filterpy, told by orientations alone.

    Parameters
    ----------
    slow_rate_noise : float
        Least random walk of slow rates [rad/s^1.5].
    x, P : ndarray, shape (6,), (6, 6)
        Where they begin.

    """

    def __init__(self, slow_rate_noise, x, P):
        super().__init__(dim_x=6, dim_z=3)
        self.x, self.P = x.copy(), P.copy()
        self.H = np.eye(6)[:3]
        self.noise, self.acceleration = RateNoise(slow_rate_noise), FollowedAcceleration()
        self.since = 0.0

    def advance(self, until):
        """Predict to so long after the last correction [s]."""
        dt, self.since = until - self.since, until
        F = np.eye(6)
        F[range(3), range(3, 6)] = dt
        tilt = max(abs(self.x[3]) / SLOW_RATES, 1.0) ** GROWS
        density = self.noise.density(self.acceleration.mean, tilt)
        self.predict(F=F, Q=random_walk(density, dt, 6))

    def steady(self, grows):
        """Return whether innovations say that the rates are constant; see `RateNoise.adapt`."""
        return self.noise.value <= STEADY * self.noise.least(self.x[3:], self.P[3:, 3:], grows)

    def correct(self, q, R, dt, grows):
        """Correct with an orientation, dt [s] after the last one; grows: see `RateNoise.adapt`."""
        self.advance(dt)
        S = self.P[:3, :3] + R
        self.noise.adapt(q - self.x[:3], S, self.x[3:], self.P[3:, 3:], grows)
        self.update(q, R=R)
        self.acceleration.follow(self.x[3:], dt)
        self.since = 0.0
