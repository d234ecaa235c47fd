"""The estimator for a peg that moves in fewer ways: turns that are left out count as still."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.estimator.contact_filter import ContactFilter, Correction
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.methods import one_level
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.estimator.state import ACCELERATION, ANGLE, RATE

# Places among gamma, psi, phi.
_SLIDE, _SLIP = 1, 2


def _make(still, scene, options, noise, offsets=None):
    settings = default_settings(**one_level.SETTINGS)
    return Fewer(still, scene, options, noise, offsets, settings)


# The tilt alone; the tilt and the turn about the peg's own axis.
make_one, make_two = partial(_make, (_SLIDE, _SLIP)), partial(_make, (_SLIDE,))


class Fewer(ContactFilter):
    """
    The estimator with one process-noise mode, and with some turns taken for still.

    Parameters
    ----------
    still : tuple of int
        Their places among gamma, psi, phi: each is where joint states have it, at no rate.
    arguments
        As for `ContactFilter`.

    """

    def __init__(self, still: Sequence[int], *arguments: Any) -> None:
        super().__init__(*arguments)
        self._angles = [ANGLE + i for i in still]
        self._motion = [first + i for first in (RATE, ACCELERATION) for i in still]

    def start(self, q: ArrayLike, R: ArrayLike) -> None:
        """Start from an orientation; see `ContactFilter`."""
        super().start(q, R)
        self._hold()

    def predict(self, dt: float) -> None:
        """Move the estimate on by dt [s]."""
        super().predict(dt)
        self._hold()

    def correct(self, q: np.ndarray, R: np.ndarray) -> tuple[Correction, float]:
        """Correct with an orientation, which has the still turns; see `ContactFilter`."""
        mixture, angles = self.mixture, self._angles
        for x, P in (*zip(mixture.x, mixture.P), (mixture.mean, mixture.covariance)):
            x[angles] = np.asarray(q)[angles]
            P[angles, :] = P[:, angles] = 0.0
            P[np.ix_(angles, angles)] = np.asarray(R)[np.ix_(angles, angles)]
        found = super().correct(q, R)
        self._hold()
        return found

    def weigh(self, u: np.ndarray, contacts: ContactSet) -> None:
        """Take a wrench on the peg, and fill in the record; see `ContactFilter`."""
        super().weigh(u, contacts)
        self._hold()

    def _hold(self):
        """Let the still turns be still."""
        mixture = self.mixture
        for x, P in (*zip(mixture.x, mixture.P), (mixture.mean, mixture.covariance)):
            x[self._motion] = 0.0
            P[self._motion, :] = P[:, self._motion] = 0.0
