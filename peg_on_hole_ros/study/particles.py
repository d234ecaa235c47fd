"""A particle filter on the estimator's own process: a wrench is weighed at points drawn anew."""

from typing import Any

import numpy as np

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.methods import one_level
from peg_on_hole_ros.estimator.offset_uncertainty import OffsetUncertainty
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.estimator.state import FRICTION, OPEN_BEGIN
from peg_on_hole_ros.mechanics.kernel import workspace
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.study.equation_residual import unbalanced, wrench_noise

PARTICLES = 300
# Of the tangents' covariance, what particles are drawn from: they reach a little further.
_WIDER = 1.5
# Of a correlation: what is known exactly still has a square root.
_JITTER = 1e-9
_SEED = 1


def make_particles(
    scene: Scene,
    options: FilterOptions,
    noise: np.ndarray,
    offsets: OffsetUncertainty | None = None,
) -> "Particles":
    """Return the filter; parameters as for `ContactFilter`."""
    settings = default_settings(**one_level.SETTINGS)
    return Particles(scene, options, noise, offsets, settings)


class Particles(ContactFilter):
    """
    A Gaussian particle filter (Kotecha, Djuric 2003) for the wrench, with one level.

    Particles are drawn from what tangents make of a wrench, and weighed by its true likelihood
    over the prior; their mean and covariance go on. Each has its own best reactions, in closed
    form. Process and orientations are linear, and taken exactly.
    """

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        if self._n != OPEN_BEGIN:
            raise ValueError("the particle filter learns friction, and nothing else")
        self._drawn, self._work = np.random.default_rng(_SEED), workspace()

    def weigh(self, u: np.ndarray, contacts: ContactSet) -> None:
        """Take a wrench on the peg, and fill in the record; see `ContactFilter`."""
        state, mixture, n = self.state, self.mixture, self._n
        begins = state.time_in_contact < 0.0
        before, spread = mixture.x[0, :n].copy(), mixture.P[0, :n, :n].copy()
        super().weigh(u, contacts)
        # The first wrench finds the reactions, by tangents that are taken anew.
        if contacts is not ContactSet.THREE or begins or state.time_in_contact < 0.0:
            return
        x, P = mixture.x[0], mixture.P[0]
        middle, wide = x[:n].copy(), _WIDER * P[:n, :n]
        points = np.zeros((PARTICLES, n + 3))
        normal = self._drawn.standard_normal((PARTICLES, n))
        points[:, :n] = middle + normal @ _root(wide).T
        points[:, FRICTION] = np.maximum(points[:, FRICTION], 0.0)
        log = _log_normal(points[:, :n] - before, spread) + 0.5 * np.sum(normal**2, axis=1)
        own, reactions, each = self._reactions(points, x)
        log += own
        weight = np.exp(log - log.max())
        weight /= weight.sum()
        points[:, n:] = reactions
        x[:] = weight @ points
        off = points - x
        P[:, :] = (off * weight[:, None]).T @ off
        P[n:, n:] += np.einsum("k,kij->ij", weight, each)
        mixture.mean[:], mixture.covariance[:] = x, P
        state.friction_force2[:] = x[FRICTION] ** 2 * (x[n:] ** 2 + np.diagonal(P)[n:])
        self._fill()

    def _reactions(self, points, x):
        """Return log likelihood of each particle, its reactions and their covariance."""
        prior = (self.settings.reaction_prior * self.state.load) ** 2
        left, carried = unbalanced(self.scalars, points, self.fields.wrench, False, self._work)
        noise = wrench_noise(
            self.scalars, x, self.fields.wrench, self.wrench_noise, False, self._work
        )
        weighted = np.linalg.solve(noise, carried)
        told = np.linalg.inv(np.swapaxes(carried, 1, 2) @ weighted + np.eye(3) / prior)
        reactions = np.einsum("kij,klj,kl->ki", told, weighted, left)
        # What the reactions cannot carry, and how freely they carry the rest.
        misfit = np.einsum("ki,ki->k", left, np.linalg.solve(noise, left.T).T)
        misfit -= np.einsum("kli,kl,ki->k", weighted, left, reactions)
        return 0.5 * (np.linalg.slogdet(told)[1] - misfit), reactions, told


def _root(covariance):
    """Return a square root, scaled, so that what is known exactly does no harm."""
    scale = np.sqrt(np.maximum(np.diagonal(covariance), 1e-300))
    correlation = covariance / np.outer(scale, scale)
    return scale[:, None] * np.linalg.cholesky(correlation + _JITTER * np.eye(len(scale)))


def _log_normal(off, covariance):
    return -0.5 * np.sum(np.linalg.solve(_root(covariance), off.T) ** 2, axis=0)
