"""The default estimator smoothed, with the reactions that each wrench then leaves."""

from typing import Any

import numpy as np

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.offset_uncertainty import OffsetUncertainty
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.estimator.smoother import Smoother
from peg_on_hole_ros.estimator.state import OPEN_BEGIN
from peg_on_hole_ros.mechanics.kernel import workspace
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.study.balance import balanced


def make_smoothed(
    scene: Scene,
    options: FilterOptions,
    noise: np.ndarray,
    offsets: OffsetUncertainty | None = None,
) -> "Smoothed":
    """Return the default estimator with smoothing; parameters as for `ContactFilter`."""
    return Smoothed(scene, options, noise, offsets, default_settings())


class Smoothed(Smoother):
    """A `Smoother` that keeps the wrenches; nothing but friction may be left open."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        if self._n != OPEN_BEGIN:
            raise ValueError("nothing but friction is left open here")
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
        t_ns, state, covariance = self.smooth_all()
        spread = np.sqrt(np.maximum(np.diagonal(covariance, axis1=1, axis2=2), 0.0))
        values, stddev = np.empty((len(t_ns), 9)), np.empty((len(t_ns), 9))
        values[:, :6], stddev[:, :6] = state[:, :6], spread[:, :6]
        work = workspace()
        for k, u in enumerate(self._wrenches):
            found, P = balanced(
                self.scalars, state[k], spread[k], u, self.wrench_noise, False, work
            )
            values[k, 6:], stddev[k, 6:] = found, np.sqrt(np.diagonal(P))
        return t_ns, values, stddev
