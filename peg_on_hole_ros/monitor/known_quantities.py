"""What is known of friction, clearance and reactions: with every mode, and without any."""

from math import fabs, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimator.record import CONTACTS, LASTING, REACTIONS, SCENE, SPREAD, X, Y
from peg_on_hole_ros.mechanics.kernel import compiled

# Reactions are known where no spread is more than a third of their mean, and what friction makes
# of none more than half of that: with a friction that is too high reactions come out too low, and
# too sure, so that a limit on their spread alone picks those that are wrong.
_SHARE, _BY_FRICTION = 9.0, 18.0
# Loaded surfaces leave the clearance open by so much [m]: 100 N press a contact of steel in by
# 1 um. Friction that was learnt on the rim is off by that share, however long it was learnt.
_GIVES = 2e-6


class Known(NamedTuple):
    """
    What is known of the scene and of the reactions.

    Attributes
    ----------
    friction, friction_stddev : float
        [-].
    clearance, clearance_stddev : float
        [m].
    reactions : float
        1 where the reactions of three contacts, if there are three, are numbers to trust.

    """

    friction: float
    friction_stddev: float
    clearance: float
    clearance_stddev: float
    reactions: float


@compiled
def fill_known(f: np.ndarray, determinant: float, band: float, out: np.ndarray) -> None:
    """
    Fill in what is known.

    Parameters
    ----------
    f : ndarray
        Record of the estimate.
    determinant : float
        Of the six equations over its frictionless value.
    band : float
        `monitor.singular_band`.
    out : ndarray
        Filled in the order of `Known`.

    """
    clearance, variance = f[SCENE + 1] - f[SCENE], max(f[SPREAD], 0.0)
    if variance > 0.0 and f[X] < f[SCENE + 3]:
        variance += (f[SCENE + 7] * _GIVES / clearance) ** 2
    out[0], out[1] = f[SCENE + 7], sqrt(variance)
    out[2], out[3] = clearance, sqrt(max(f[SPREAD + 3], 0.0))
    total = f[Y + 3] + f[Y + 4] + f[Y + 5]
    # Beside the singular set little is known; two points in the hole have none.
    two = f[CONTACTS] == 2.0
    clear = determinant > band or two
    for i in range(3):
        # There B1 and B2 are halves.
        share = 2.0 if two and i > 0 else 1.0
        clear = clear and share * sqrt(max(f[REACTIONS + 21 + 7 * i], 0.0)) <= total / _SHARE
        clear = clear and share * fabs(f[LASTING + 3 + i]) <= total / _BY_FRICTION
    out[4] = 1.0 if clear else 0.0
