"""Loads and determinant of a motion against tilt, with the bands of what is not known."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.planning.cell import Cell
from peg_on_hole_ros.mechanics.planning.motion import ClosingMotion, path_of
from peg_on_hole_ros.mechanics.planning.outlook import LOAD_QUANTILE, path_margins
from peg_on_hole_ros.mechanics.planning.spread import quantile, spread_of
from peg_on_hole_ros.mechanics.scene import Scene


class LoadProfile(NamedTuple):
    """
    A motion against tilt, until friction and clearance as stated reach two-point contact.

    Attributes
    ----------
    time, gamma : ndarray, shape (n,)
        [s], [rad]
    normal, low, high : ndarray, shape (3, n)
        N_K, N_B1, N_B2 as stated, and what 5 and 95 % of frictions stay under [N].
    determinant, least : ndarray, shape (n,)
        As stated, and what 95 % of frictions stay above.

    """

    time: np.ndarray
    gamma: np.ndarray
    normal: np.ndarray
    low: np.ndarray
    high: np.ndarray
    determinant: np.ndarray
    least: np.ndarray


def profile(
    scene: Scene, cell: Cell, max_normal: Sequence[float], motion: ClosingMotion
) -> LoadProfile:
    """Return loads and determinant of a motion, of which friction is spread and clearance not."""
    spread = spread_of(scene)
    k = spread.middle[0]
    spread = spread._replace(scenes=spread.scenes[k : k + 1], weights=np.ones(1))
    path = path_of(motion, scene.gamma0)
    found = path_margins(spread, cell, max_normal, path)
    _, f = spread.middle
    on = np.isfinite(found.determinant[0, f])
    determinant = np.where(np.isfinite(found.determinant), found.determinant, 1.0)
    return LoadProfile(  # type: ignore[call-arg]
        path.time[on],
        path.gamma[on],
        found.normal[:, 0, f][:, on],
        *(
            np.array([quantile(spread, normal, share) for normal in found.normal])[:, on]
            for share in (1 - LOAD_QUANTILE, LOAD_QUANTILE)
        ),
        determinant[0, f, on],
        -quantile(spread, -determinant, LOAD_QUANTILE)[on],
    )
