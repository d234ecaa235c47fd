"""Where the equations of three contacts end: wedging, between gamma0 and a lying peg."""

from math import pi
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.reference import critical_frictions, friction_cubic
from peg_on_hole_ros.mechanics.scene import Scene

# Rates of gamma, psi, phi [rad/s]: those of the paper's motions, and the turning by itself.
MOTIONS = {
    "closing": (-0.16, 0.0, 0.0),
    "opening": (0.16, 0.0, 0.0),
    "closing with spin": (-0.16, 0.0, 2.0),
    "turning about the hole's axis": (0.0, 0.6, 0.0),
}
# Up to here a motion is said to wedge or not.
MOST_FRICTION = 1.2
_TILTS = 161
# Of gamma0 and of 90 degrees, where B1 and B2 are one point [rad].
_MARGIN = 1e-6


class Wedging(NamedTuple):
    """
    From which friction on a motion has no way on.

    Attributes
    ----------
    motion : str
        Of MOTIONS.
    tilt : ndarray, shape (n,)
        From gamma0 to a lying peg [rad].
    friction : ndarray, shape (n,)
        The least at which rigid sliding has no solution; NaN: none up to MOST_FRICTION.

    """

    motion: str
    tilt: np.ndarray
    friction: np.ndarray


def wedging(scene: Scene, motion: str) -> Wedging:
    """Return from which friction on a motion wedges, at tilts even in the logarithm."""
    tilts = np.geomspace(scene.gamma0 + _MARGIN, pi / 2 - _MARGIN, _TILTS)
    least = [_critical(scene, tilt, MOTIONS[motion]) for tilt in tilts]
    return Wedging(motion, tilts, np.array(least))


def _critical(scene, tilt, rates):
    roots = critical_frictions(friction_cubic(scene, (tilt, 0.0, 0.0), rates))
    return roots[0] if roots and roots[0] <= MOST_FRICTION else np.nan
