"""An estimate that stands where a test wants it."""

import numpy as np

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.mechanics.scene import Scene

LONG_SINCE = 1.0


def placed(q, rates=(0.0, 0.0, 0.0), scene=None, noise=1e-4, variance=1e-8, rate_variance=1e-6):
    """Return an estimate at angles [rad] and rates [rad/s], each known to a variance."""
    noise = noise * np.eye(6) if np.isscalar(noise) else noise
    kalman = ContactFilter(scene or Scene(), FilterOptions(), noise)
    kalman.start(np.array(q, float), variance * np.eye(3))
    move(kalman, rates, rate_variance)
    return kalman


def move(kalman, rates, variance=0.0, q=None):
    """Let all components of an estimate have these rates [rad/s], and angles if given."""
    whole = kalman.mixture
    for x, P in (*zip(whole.x, whole.P), (whole.mean, whole.covariance)):
        x[3:6] = rates
        if q is not None:
            x[:3] = q
        P[3:9], P[:, 3:9] = 0.0, 0.0
        P[range(3, 6), range(3, 6)] = variance
        # Accelerations that are as good as none.
        P[range(6, 9), range(6, 9)] = 1e-12
    kalman.state.time_since_start = LONG_SINCE


def press(kalman, wrench, contacts=ContactSet.UNKNOWN):
    """Hand a wrench on the peg to an estimate, peg axes; return its record."""
    kalman.weigh(np.array(wrench, float), contacts)
    return kalman.record
