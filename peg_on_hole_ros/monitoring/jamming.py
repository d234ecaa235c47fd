"""How near the peg is to wedging: the distance to the singular set of the six equations."""

from math import sqrt

import numpy as np

from peg_on_hole_ros.mechanics.kernel import SceneScalars, accelerate, workspace

# Slower than any motion a cell makes and faster than rounding: friction is then Coulomb's.
_COULOMB = (1e-9, 1e-9, 1e-9)


class WedgingMargin:
    """The normalised determinant for the closing motion from an estimate."""

    def __init__(self, scalars: SceneScalars):
        self._scalars = scalars
        self._x = np.zeros(6)
        self._u = np.zeros(6)
        self._work = workspace()
        self._y = np.zeros(6)

    def determinant(self, x, P) -> float:
        """
        Return the determinant over its frictionless value for dry friction.

        A rate within two of its standard deviations of zero has no direction that could be
        trusted: psi' and phi' then count as none, and gamma' as closing, the direction in which a
        held or jammed peg is pushed.

        Parameters
        ----------
        x : ndarray, shape (6,)
        P : ndarray, shape (6, 6)

        """
        self._x[:3] = x[:3]
        for i in range(3, 6):
            known = abs(x[i]) > 2 * sqrt(P[i, i])
            self._x[i] = x[i] if known else 0.0
        if self._x[3] == 0.0:
            self._x[3] = -2 * sqrt(P[3, 3]) - 1e-6
        return accelerate(self._scalars, _COULOMB, self._x, self._u, self._work, self._y)


def jamming_risk(determinant: float) -> float:
    """
    Return the risk of wedging in 0 .. 1.

    1 - determinant, cut to the range: 0 without friction, 1 where rigid three-point motion has no
    solution (Painleve's paradox) and beyond.
    """
    return min(1.0, max(0.0, 1.0 - determinant))
