"""Where a hole is, by the end of a recording that leaves the peg in it: from the motion alone."""

from collections.abc import Sequence
from math import acos, degrees
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.identification.tuned import INSERTED_END
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.records import AngleMeasurement


class HoleByEnd(NamedTuple):
    """
    The hole in which a peg has ended, in the axes of the hole as it is stated.

    Attributes
    ----------
    axis : ndarray, shape (3,)
        Up the hole, of length 1.
    off, off_bound : float
        Between it and the stated axis, and how far it may be off itself [degrees].
    top : ndarray, shape (3,)
        Where the lower end was as the way along the axis began: at the rim [m].
    depth : float
        Of that way [m].

    """

    axis: np.ndarray
    off: float
    off_bound: float
    top: np.ndarray
    depth: float

    @property
    def aside(self) -> float:
        """How far the stated centre of the rim is from the axis [m]."""
        return float(np.linalg.norm(self.top - (self.top @ self.axis) * self.axis))

    @property
    def above(self) -> float:
        """How far the way into the hole begins above the stated rim [m]."""
        return float(self.top @ self.axis)


def hole_by_end(measured: Sequence[AngleMeasurement], scene: Scene) -> HoleByEnd | None:
    """
    Return the hole by the last way of a peg along its own axis; None: it ends in none.

    A peg of clearance c that has gone down by L is within c / L of the hole's axis, and its way
    within c of a line. In free air it may go so too: only a peg that was tilted by more than
    gamma0 before, as one that is set on the rim, counts.
    """
    rows = [each for each in measured if each.position is not None]
    if not rows:
        return None
    p = np.array([each.position for each in rows])
    R = peg_axes(np.array([each.q for each in rows]).T)
    up, t = R[:, 2].T, np.array([each.t_ns for each in rows]) * 1e-9
    last = t > t[-1] - INSERTED_END.averaged
    axis, end = up[last].mean(axis=0), p[last].mean(axis=0)
    axis = axis / np.linalg.norm(axis)
    clearance = scene.hole_diameter - scene.peg_diameter
    way = p - end
    along = way @ axis
    aside = np.linalg.norm(way - along[:, None] * axis, axis=1)
    out = np.flatnonzero(aside > INSERTED_END.aside * clearance + INSERTED_END.flex)
    begin = int(out[-1]) + 1 if len(out) else 0
    depth, before = float(along[begin:].max()), up[:begin] @ axis
    least = INSERTED_END.least_depth * clearance
    if depth < least or not len(before) or before.min() > np.cos(scene.gamma0):
        return None
    first = begin + int(np.argmax(along[begin:]))
    # Deepest the hole leads best.
    deep = along < 0.5 * depth
    deep[:begin] = False
    axis = up[deep].mean(axis=0)
    axis = axis / np.linalg.norm(axis)
    off = degrees(acos(min(max(float(axis[2]), -1.0), 1.0)))
    return HoleByEnd(axis, off, degrees(clearance / depth), p[first], depth)
