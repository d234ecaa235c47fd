"""How near the peg is to wedging: the distance to the singular set of the six equations."""

from math import fabs, sqrt

from peg_on_hole_ros.mechanics.kernel import (
    compiled,
    determinant_at,
    scene_of,
    workspace,
)

# Slower than any motion a cell makes and faster than rounding: friction is then Coulomb's.
_COULOMB = (1e-9, 1e-9, 1e-9)


class WedgingMargin:
    """
    The normalised determinant for the closing motion from an estimate.

    Parameters
    ----------
    scene : ndarray
        The fields of `kernel.SceneScalars`, read anew each time: friction may be learnt.

    """

    def __init__(self, scene):
        self._scene = scene
        self._work = workspace()

    def determinant(self, x, P) -> float:
        """
        Return the determinant over its frictionless value for dry friction.

        A motion within three of its standard deviations of zero has no direction that could be
        trusted: gamma' then counts as closing, the direction in which a held or jammed peg is
        pushed, and the turning as none. Turning is judged by the slip that psi' and phi' make
        together: at a small tilt each alone is hardly known, and their slip well.

        Parameters
        ----------
        x : ndarray, shape (6,)
        P : ndarray, shape (6, 6)

        """
        return _closing_determinant(self._scene, x, P, self._work)


@compiled
def _known(rate, variance):
    return rate if fabs(rate) > 3.0 * sqrt(variance) else 0.0


@compiled
def _closing_determinant(scene, x, P, work):
    dgamma = _known(x[3], P[3, 3])
    if dgamma == 0.0:
        dgamma = -3.0 * sqrt(P[3, 3]) - 1e-6
    p = scene_of(scene)
    turning = 0.5 * (p.D * x[4] + p.d * x[5])
    variance = 0.25 * (p.D * p.D * P[4, 4] + p.d * p.d * P[5, 5] + 2.0 * p.D * p.d * P[4, 5])
    known = _known(turning, variance) != 0.0
    rates = (dgamma, x[4] if known else 0.0, x[5] if known else 0.0)
    return determinant_at(p, _COULOMB, x[0], rates, work)


def jamming_risk(determinant: float) -> float:
    """
    Return the risk of wedging in 0 .. 1.

    1 - determinant, cut to the range: 0 without friction, 1 where rigid three-point motion has no
    solution (Painleve's paradox) and beyond.
    """
    return min(1.0, max(0.0, 1.0 - determinant))
