"""How the plate around a hole lies, from places where the peg's lower end has touched it."""

from collections.abc import Sequence
from math import acos, degrees
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.identification.presses import Press
from peg_on_hole_ros.identification.tuned import TOUCHED_PLATE
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.records import AngleMeasurement


class TouchedPlate(NamedTuple):
    """
    A plate, in the axes of the hole as it is stated.

    Attributes
    ----------
    normal : ndarray, shape (3,)
        Out of the plate, of length 1.
    off, off_stddev : float
        Between it and the stated axis, and how well it is known [degrees].
    above : float
        How far the plate is above the stated centre of the hole's outer face [m].
    touches : int

    """

    normal: np.ndarray
    off: float
    off_stddev: float
    above: float
    touches: int


def touched_plate(
    presses: Sequence[Press], measured: Sequence[AngleMeasurement], scene: Scene
) -> TouchedPlate:
    """
    Return the plane through the lowest points of a peg that pressed on it at some places.

    Raises
    ------
    PegOnHoleError
        There are not three places, or they lie along one line.

    """
    places, axes = [], []
    for press in presses:
        rows = [each for each in measured if press.begin_ns <= each.t_ns <= press.end_ns]
        positions = [each.position for each in rows if each.position is not None]
        if positions:
            axes.append(peg_axes(np.mean([each.q for each in rows], axis=0))[:, 2])
            outermost = -scene.peg_chamfer * axes[-1]
            places.append(np.mean(positions, axis=0) + outermost)
    p, up = np.array(places).reshape(-1, 3), np.array(axes).reshape(-1, 3)
    spread = np.linalg.svd(p - p.mean(axis=0))[1] if len(p) >= 3 else np.zeros(2)
    if spread[1] < TOUCHED_PLATE.least_spread:
        raise PegOnHoleError(
            "press with 10 N for a second at three or more places of the plate around the hole, "
            f"{1e3 * TOUCHED_PLATE.least_spread:g} mm and more from one line, and lift the peg "
            f"between them: the recording has {len(p)} presses that do not suffice"
        )
    normal = up.mean(axis=0) / np.linalg.norm(up.mean(axis=0))
    for _ in range(TOUCHED_PLATE.most_passes):
        # Of a peg that leans, a point of the lower edge touches.
        lean = normal - (up @ normal)[:, None] * up
        size = np.linalg.norm(lean, axis=1, keepdims=True)
        low = p - 0.5 * scene.peg_diameter * lean / np.maximum(size, 1e-12)
        across = np.linalg.svd(low - low.mean(axis=0))[2][2]
        normal = across * np.sign(across @ up.mean(axis=0))
    doubt = degrees(TOUCHED_PLATE.stddev / float(spread[1]))
    off = degrees(acos(min(max(float(normal[2]), -1.0), 1.0)))
    face = np.array([0.0, 0.0, scene.hole_chamfer])
    above = float((low.mean(axis=0) - face) @ normal)
    return TouchedPlate(normal, off, doubt, above, len(p))
