"""Motion from joint states alone, and the reactions that balance the wrench: without inertia."""

import numpy as np

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.methods import one_level
from peg_on_hole_ros.estimator.offset_uncertainty import OffsetUncertainty
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.estimator.state import ACCELERATION, FRICTION, OPEN_BEGIN
from peg_on_hole_ros.estimator.wrench_update import rim_load_bound
from peg_on_hole_ros.mechanics.kernel import SceneScalars, workspace
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.study.equation_residual import unbalanced, wrench_noise


def make_balance(
    scene: Scene,
    options: FilterOptions,
    noise: np.ndarray,
    offsets: OffsetUncertainty | None = None,
) -> "Balance":
    """Return the balance with the lengths as they are; parameters as for `ContactFilter`."""
    return Balance(False, scene, options, noise, offsets)


def make_small_angle(
    scene: Scene,
    options: FilterOptions,
    noise: np.ndarray,
    offsets: OffsetUncertainty | None = None,
) -> "Balance":
    """Return the balance with the lengths of a small tilt; parameters as for `ContactFilter`."""
    return Balance(True, scene, options, noise, offsets)


def balanced(
    p: SceneScalars,
    state: np.ndarray,
    spread: np.ndarray,
    u: np.ndarray,
    wrench_covariance: np.ndarray,
    small: bool,
    work: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the three reactions that fit a wrench best, by least squares, and their covariance.

    Parameters
    ----------
    p : SceneScalars
    state : ndarray, shape (OPEN_BEGIN,)
        Angles, rates, accelerations, friction.
    spread : ndarray, shape (OPEN_BEGIN,)
        Their standard deviations; 0: known.
    u : ndarray, shape (6,)
        Force and moment about the mass centre, peg axes [N], [N m].
    wrench_covariance : ndarray, shape (6, 6)
    small, work
        As for `unbalance`.

    """
    points = np.zeros((1 + OPEN_BEGIN, OPEN_BEGIN + 3))
    points[:, :OPEN_BEGIN] = state
    points[1:, :OPEN_BEGIN] += np.diag(spread)
    left, carried = unbalanced(p, points, u, small, work)
    noise = wrench_noise(p, points[0], u, wrench_covariance, small, work)
    weighted = np.linalg.solve(noise, carried[0])
    told = np.linalg.inv(carried[0].T @ weighted)
    reactions = told @ weighted.T @ left[0]
    # What a deviation of each leaves unbalanced, with these reactions.
    off = (left[1:] - left[0]) - (carried[1:] - carried[0]) @ reactions
    moved = told @ weighted.T @ off.T
    return reactions, told + moved @ moved.T


class Balance(ContactFilter):
    """
    A Kalman filter on orientations alone; at each wrench least squares for the three reactions.

    Friction is as stated. Bounds hold the wrench's noise, and what angles, rates and friction may
    be off by, one deviation of each at a time.
    """

    def __init__(
        self,
        small: bool,
        scene: Scene,
        options: FilterOptions,
        noise: np.ndarray,
        offsets: OffsetUncertainty | None,
    ) -> None:
        settings = default_settings(**one_level.SETTINGS)
        super().__init__(scene, options, noise, offsets, settings)
        if self._n != OPEN_BEGIN:
            raise ValueError("a balance learns nothing")
        self._small, self._work = small, workspace()

    def weigh(self, u: np.ndarray, contacts: ContactSet) -> None:
        """Balance a wrench on the peg, and fill in the record; see `ContactFilter`."""
        state, mixture, n = self.state, self.mixture, self._n
        if contacts is not ContactSet.THREE or state.time_since_start < self.settings.settling:
            super().weigh(u, contacts)
            return
        self.fields.wrench[:] = u
        state.load = rim_load_bound(self.scalars, self.fields.wrench)
        state.time_in_contact = max(state.time_in_contact, 0.0) + state.time_since_wrench
        state.time_since_wrench = 0.0
        x, P = mixture.x[0], mixture.P[0]
        still = x[:n].copy()
        still[ACCELERATION:FRICTION] = 0.0
        spread = np.sqrt(np.maximum(np.diagonal(P)[:n], 0.0))
        spread[ACCELERATION:FRICTION] = 0.0
        P[n:, :] = P[:, n:] = 0.0
        x[n:], P[n:, n:] = balanced(
            self.scalars,
            still,
            spread,
            self.fields.wrench,
            self.wrench_noise,
            self._small,
            self._work,
        )
        mixture.mean[:], mixture.covariance[:] = x, P
        state.friction_force2[:] = x[FRICTION] ** 2 * (x[n:] ** 2 + np.diagonal(P)[n:])
        # Rates are what joint states make of them.
        state.nis_wrench = np.nan
        self._fill()
