"""The default estimator smoothed, with the reactions that each wrench then leaves."""

from typing import Any

import numpy as np

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.methods import balance
from peg_on_hole_ros.estimator.offset_uncertainty import OffsetUncertainty
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.estimator.smoother import Smoother
from peg_on_hole_ros.estimator.state import OPEN_BEGIN
from peg_on_hole_ros.mechanics.scene import Scene

LAG_NS = 50_000_000
# Angles, rates and reactions, where nothing but friction is open.
_TOLD = [*range(6), *range(OPEN_BEGIN, OPEN_BEGIN + 3)]


def make_smoothed(
    scene: Scene,
    options: FilterOptions,
    noise: np.ndarray,
    offsets: OffsetUncertainty | None = None,
) -> "Smoothed":
    """Return the default estimator with smoothing; parameters as for `ContactFilter`."""
    return Smoothed(scene, options, noise, offsets, default_settings())


def make_fixed_lag(
    scene: Scene,
    options: FilterOptions,
    noise: np.ndarray,
    offsets: OffsetUncertainty | None = None,
) -> "Smoothed":
    """Return the same, told LAG_NS to twice as much later; parameters as for `ContactFilter`."""
    made = make_smoothed(scene, options, noise, offsets)
    made.lag_ns = LAG_NS
    return made


class Smoothed(Smoother):
    """
    A `Smoother` that keeps the wrenches; nothing but friction may be left open.

    Attributes
    ----------
    lag_ns : int or None
        As of `smooth_all`.

    """

    lag_ns: int | None = None

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        if self._n != OPEN_BEGIN:
            raise ValueError("nothing but friction is left open here")
        settings = default_settings(**balance.SETTINGS | {"inertia": 1.0})
        scene, options, noise, offsets = arguments[:4]
        self._balance = ContactFilter(scene, options, noise, offsets, settings)
        self._wrenches: list[np.ndarray] = []

    def weigh(self, u: np.ndarray, contacts: ContactSet) -> None:
        """Take a wrench on the peg; see `ContactFilter`."""
        self._wrenches.append(np.array(u, float))
        super().weigh(u, contacts)

    def smooth_with_reactions(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """
        Return the smoothed state and the reactions at the stamps of all wrenches.

        Returns
        -------
        t_ns : ndarray, shape (k,)
        values, stddev : ndarray, shape (k, 9)
            Angles [rad], rates [rad/s], reactions [N].

        """
        t_ns, state, covariance = self.smooth_all(self.lag_ns)
        n, kalman = self._n, self._balance
        values, stddev = np.empty((len(t_ns), 9)), np.empty((len(t_ns), 9))
        kalman.start(state[0][:3], covariance[0][:3, :3])
        for k, u in enumerate(self._wrenches):
            # Every wrench is one of a peg that has been in contact for long.
            kalman.predict(kalman.settings.settling)
            x, P = kalman.mixture.x[0], kalman.mixture.P[0]
            x[:n], P[:n, :n] = state[k], covariance[k]
            kalman.mixture.mean[:n], kalman.mixture.covariance[:n, :n] = state[k], covariance[k]
            kalman.weigh(u, ContactSet.THREE)
            values[k], stddev[k] = x[_TOLD], np.sqrt(np.diagonal(P)[_TOLD])
        return t_ns, values, stddev
