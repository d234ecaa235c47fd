"""What is still possible from a present state, found while the peg moves."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.mechanics.planning.cell import Cell
from peg_on_hole_ros.mechanics.planning.fineness import AT_ONCE
from peg_on_hole_ros.mechanics.planning.motion import ClosingMotion, motion_of
from peg_on_hole_ros.mechanics.planning.outlook import Outlook
from peg_on_hole_ros.mechanics.planning.search import judge, kept, plan_motion
from peg_on_hole_ros.mechanics.scene import Scene

# By how much loads may be above those of a steady motion, near gamma0.
_STEADY = 1.05
# Share of the push that is tried where that which the loads tell does not do.
_LIGHT = 0.3


class WayOn(NamedTuple):
    """
    A way on from a present state.

    Attributes
    ----------
    possible, goes_on : bool
        Whether there is one, and whether it is the present motion.
    share : float
        Of the present push.
    motion : ClosingMotion
        Where none is possible, the one that comes nearest.
    outlook : Outlook
        Of the motion.
    contact : int
        0, 1, 2 for K, B1, B2: whose load comes nearest to its limit.
    load : float
        That this stays under, two digits [N].

    """

    possible: bool
    goes_on: bool
    share: float
    motion: ClosingMotion
    outlook: Outlook
    contact: int
    load: float


def way_on(
    scene: Scene, cell: Cell, max_normal: Sequence[float], tilt: float, rates: ArrayLike
) -> WayOn:
    """
    Return what keeps the limits from a present state, by the plan's own functions, coarsely.

    Parameters
    ----------
    scene : Scene
        With friction, and its spread, as they are known by now.
    cell : Cell
        Its `press` is the present push.
    max_normal : sequence of 3 float
        Limits of the reactions at K, B1, B2 [N].
    tilt : float
        [rad]
    rates : array_like, shape (3,)
        Present gamma', psi', phi' [rad/s].

    Returns
    -------
    WayOn
        The present motion where it will do; or another turn; or that with less push.

    Raises
    ------
    PegOnHoleError
        Where the tilt is none of three-point contact.

    """
    going = _going_on(scene, cell, tilt, np.asarray(rates, float))
    if going is not None:
        ahead = judge(scene, cell, max_normal, going, AT_ONCE)
        if kept(ahead, cell):
            return WayOn(True, True, 1.0, going, ahead, *_most(ahead, max_normal))
    plan, share = plan_motion(scene, cell, max_normal, tilt, rates, AT_ONCE), 1.0
    # A wedge does not go with the push, loads do.
    if not plan.possible and plan.outlook.wedge <= cell.wedge_probability:
        over = max(load / most for load, most in zip(plan.outlook.peak_high, max_normal))
        told = max(float(np.floor(9.5 / max(over, 1.0))), 1.0) / 10
        for less in (told, _LIGHT):
            lighter = replace(cell, press=tuple(less * x for x in cell.press))  # type: ignore[arg-type]
            found = plan_motion(scene, lighter, max_normal, tilt, rates, AT_ONCE)
            if found.possible:
                plan, share = found, less
                break
    most = _most(plan.outlook, max_normal)
    return WayOn(plan.possible, False, share, plan.motion, plan.outlook, *most)


def _going_on(scene, cell, tilt, rates):
    # At rest there is nothing to go on with.
    if not rates[0] <= -cell.min_closing_rate or not tilt > scene.gamma0:
        return None
    legs = [(rates, scene.gamma0)]
    return motion_of(tilt, rates, legs, scene.gamma0, cell.max_acceleration)


def _most(ahead, max_normal):
    """Return which load comes nearest to its limit, and what it stays under."""
    k = int(np.argmax(np.array(ahead.peak_high) / max_normal))
    # Two digits, rounded up: it is an upper end.
    most = _STEADY * max(ahead.peak_high[k], 1e-3)
    step = 10.0 ** (np.floor(np.log10(most)) - 1)
    return k, float(min(np.ceil(most / step) * step, max_normal[k]))
