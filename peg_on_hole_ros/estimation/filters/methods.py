"""Filters on one interface: the compiled default, and slower ones for reference and charts."""

from math import isfinite

import numpy as np

from peg_on_hole_ros.estimation.filters.contact import ContactFilter, Correction, Prediction
from peg_on_hole_ros.estimation.filters.flow import (
    Flow,
    joint_estimate,
    joint_mean,
    scaled_gain,
    set_joint,
)
from peg_on_hole_ros.estimation.filters.offset import OffsetFilter
from peg_on_hole_ros.estimation.filters.square_root import SquareRootFilter
from peg_on_hole_ros.estimation.kernel import correction
from peg_on_hole_ros.estimation.kernel.friction_lag import follow_friction


class IteratedFilter(ContactFilter):
    """
    Iterated extended Kalman filter: the step is linearised again where the measurement puts it.

    An orientation is linear in the state, so there is nothing to iterate in the correction alone.
    What is not linear is the step before it: prediction and correction are one least-squares
    problem in the joint state before the step, solved by Gauss and Newton's method (Bell and
    Cathey, IEEE Trans. Automatic Control 38, 1993, over one interval).
    """

    ITERATIONS = 5
    # Of a standard deviation.
    TOLERANCE = 1e-3

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self._last = None

    def predict(self, dt, in_contact):
        """Predict, and remember where from."""
        result = super().predict(dt, in_contact)
        self._last = (*self._before, Flow(self, dt)) if result is Prediction.CONTACT else None
        return result

    def _begin(self, changed):
        self._before = joint_estimate(self)

    def correct(self, q, R):
        """Correct, then linearise the step anew; one that had to be widened is left as it is."""
        last, self._last = self._last, None
        lag = self._friction_lag.copy()
        result, nis = super().correct(q, R)
        if result is Correction.USED and last is not None and self._iterate(*last, q):
            self._friction_lag[:] = lag
            follow_friction(self._memory)
            self._keep_least_clearance()
        return result, nis

    def _iterate(self, prior, P0, flow, q):
        """Return whether there was anything to iterate: it is then corrected anew."""
        start, again = prior, False
        end, F, noise = flow(start)
        stddev = np.sqrt(np.diagonal(P0))
        for _ in range(self.ITERATIONS):
            mean, P = end + F @ (prior - start), F @ P0 @ F.T + noise
            moved = prior + scaled_gain(P0 @ F.T, P) @ (joint_mean(self) - mean)
            if (np.abs(moved - start) <= self.TOLERANCE * stddev).all():
                break
            start = moved
            end, F, noise = flow(start)
            if end is None:
                break
            kept = self._memory.copy()
            set_joint(self, end + F @ (prior - start), F @ P0 @ F.T + noise)
            if not isfinite(correction.innovation(self._memory, q)):
                self._memory[:] = kept
                break
            correction.correct(self._memory)
            again = True
        return again

    def snapshot(self):
        """Return what `restore` takes back."""
        return super().snapshot(), self._last

    def restore(self, snapshot):
        """Go back to a snapshot."""
        kalman, self._last = snapshot
        super().restore(kalman)


class UnscentedFilter(ContactFilter):
    """
    Unscented Kalman filter: filterpy's, on all of the joint state that is uncertain (12 to 14).

    Sigma points at sqrt(3) standard deviations, each through the same step. Where one of them has
    no step, or the spread that they give is no covariance, the extended filter's prediction stays.
    """

    def __init__(self, *arguments):
        super().__init__(*arguments)
        from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter

        self._points, self._make = MerweScaledSigmaPoints, UnscentedKalmanFilter
        self.kept_extended = 0

    def predict(self, dt, in_contact):
        """Predict by sigma points."""
        result = super().predict(dt, in_contact)
        if result is not Prediction.CONTACT:
            return result
        prior, P0 = self._before
        flow = Flow(self, dt)
        _, _, noise = flow(prior)
        # Cholesky's factor needs a variance.
        free = np.diagonal(P0) > 0
        some = np.ix_(free, free)

        def fx(values, _):
            full = prior.copy()
            full[free] = values
            end = flow(full)[0]
            if end is None:
                raise np.linalg.LinAlgError
            return end[free]

        n = int(free.sum())
        points = self._points(n, alpha=np.sqrt(3.0 / n), beta=2.0, kappa=0.0)
        unscented = self._make(n, 3, dt, lambda x: x[:3], fx, points)
        unscented.x, unscented.P, unscented.Q = prior[free], P0[some], noise[some]
        try:
            unscented.predict()
            np.linalg.cholesky(unscented.P)
        except np.linalg.LinAlgError:
            self.kept_extended += 1
            return result
        P = np.zeros_like(P0)
        prior[free], P[some] = unscented.x, unscented.P
        set_joint(self, prior, P)
        return result

    def _begin(self, changed):
        self._before = joint_estimate(self)


FILTERS = {
    "extended": ContactFilter,
    "iterated": IteratedFilter,
    "unscented": UnscentedFilter,
    "square_root": SquareRootFilter,
}


def make_filter(scene, options, wrench_noise, offsets=None) -> ContactFilter:
    """Return the filter that the options name; parameters as for `ContactFilter`."""
    if offsets is not None and offsets.variance.any() and options.method == "extended":
        return OffsetFilter(scene, options, wrench_noise, offsets)
    return FILTERS[options.method](scene, options, wrench_noise, offsets)
