"""An unscented filter on the estimator's own process: sigma points in place of tangents."""

from typing import Any

import numpy as np
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.methods import one_level
from peg_on_hole_ros.estimator.offset_uncertainty import OffsetUncertainty
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.estimator.state import FRICTION, OPEN_BEGIN
from peg_on_hole_ros.estimator.wrench_update import rim_load_bound
from peg_on_hole_ros.mechanics.kernel import workspace
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.study.equation_residual import unbalance, wrench_noise

# All weights of the mean are positive, so that no covariance is lost.
_SPREAD, _NORMAL, _KAPPA = 1.0, 2.0, 0.0


def make_unscented(
    scene: Scene,
    options: FilterOptions,
    wrench_noise: np.ndarray,
    offsets: OffsetUncertainty | None = None,
) -> "Unscented":
    """Return the filter; parameters as for `ContactFilter`."""
    settings = default_settings(**one_level.SETTINGS)
    return Unscented(scene, options, wrench_noise, offsets, settings)


class Unscented(ContactFilter):
    """
    filterpy's unscented filter for the wrench, with one level of acceleration.

    Process and orientations are linear: there sigma points give what Kalman's filter gives. What
    else a scene may leave open than friction is refused.
    """

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        if self._n != OPEN_BEGIN:
            raise ValueError("the unscented filter learns friction, and nothing else")
        w = self._n + 3
        points = MerweScaledSigmaPoints(w, _SPREAD, _NORMAL, _KAPPA)
        self._unscented = UnscentedKalmanFilter(w, 6, 0.0, self._left, None, points)
        self._points, self._work = points, workspace()

    def weigh(self, u: np.ndarray, contacts: ContactSet) -> None:
        """Take a wrench on the peg, and fill in the record; see `ContactFilter`."""
        state, mixture, n = self.state, self.mixture, self._n
        # The first wrench finds the reactions, by tangents that are taken anew.
        if contacts is not ContactSet.THREE or state.time_in_contact < 0.0:
            super().weigh(u, contacts)
            return
        self.fields.wrench[:] = u
        state.load = rim_load_bound(self.scalars, self.fields.wrench)
        state.time_in_contact += state.time_since_wrench
        state.time_since_wrench = 0.0
        x, P = mixture.x[0], mixture.P[0]
        P[n:, :] = P[:, n:] = 0.0
        P[range(n, n + 3), range(n, n + 3)] = (self.settings.reaction_prior * state.load) ** 2
        kalman = self._unscented
        kalman.x, kalman.P = x.copy(), P.copy()
        kalman.sigmas_f = self._points.sigma_points(kalman.x, kalman.P)
        noise = wrench_noise(
            self.scalars, x, self.fields.wrench, self.wrench_noise, False, self._work
        )
        kalman.update(np.zeros(6), noise)
        x[:], P[:] = kalman.x, 0.5 * (kalman.P + kalman.P.T)
        x[FRICTION] = max(x[FRICTION], 0.0)
        state.nis_wrench = float(kalman.y @ kalman.SI @ kalman.y)
        mixture.mean[:], mixture.covariance[:] = x, P
        state.friction_force2[:] = x[FRICTION] ** 2 * (x[n:] ** 2 + np.diagonal(P)[n:])
        self._fill()

    def _left(self, x):
        """Return by how much the six equations do not hold at a state with its reactions."""
        out = np.empty(6)
        unbalance(self.scalars, x, self.fields.wrench, False, self._work, out)
        return out
