"""Find the closing, slip and slide rates, and where to begin to turn, that keep the limits."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.checks import require_finite
from peg_on_hole_ros.mechanics.planning.candidates import best_first, candidates, motions
from peg_on_hole_ros.mechanics.planning.cell import AIMS, Cell, check_start
from peg_on_hole_ros.mechanics.planning.fineness import PLANNED, Fineness
from peg_on_hole_ros.mechanics.planning.motion import ClosingMotion, motion_of, path_of
from peg_on_hole_ros.mechanics.planning.outlook import Outlook, outlook, path_margins
from peg_on_hole_ros.mechanics.planning.spread import spread_of
from peg_on_hole_ros.mechanics.scene import Scene


class MotionPlan(NamedTuple):
    """
    A motion that keeps the limits, or the best that is known where none does.

    Attributes
    ----------
    possible : bool
    motion : ClosingMotion
        Where none is possible, the one that comes nearest.
    outlook : Outlook
        Of the motion.
    plain : ClosingMotion
        Closing alone, at the fastest rate allowed, or from a present state at its own.
    plain_outlook : Outlook

    """

    possible: bool
    motion: ClosingMotion
    outlook: Outlook
    plain: ClosingMotion
    plain_outlook: Outlook


def plan_motion(
    scene: Scene,
    cell: Cell,
    max_normal: Sequence[float],
    tilt: float | None = None,
    rates: ArrayLike | None = None,
    fineness: Fineness = PLANNED,
) -> MotionPlan:
    """
    Return the motion to gamma0 that keeps wedging and loads within what is allowed.

    Parameters
    ----------
    scene : Scene
        With the spread of friction and clearance.
    cell : Cell
    max_normal : sequence of 3 float
        Limits of the reactions at K, B1, B2 [N].
    tilt : float, optional
        Present tilt [rad]; the cell's `start_tilt` by default.
    rates : array_like, shape (3,), optional
        Present gamma', psi', phi' [rad/s]; by default the peg has just been set down.
    fineness : Fineness

    Returns
    -------
    MotionPlan

    Raises
    ------
    PegOnHoleError
        Where the tilt is none of three-point contact, or limits contradict.

    Notes
    -----
    The motion closes alone at first, then closes and turns, each at constant rates. All pairs of
    candidates and tilts between them are judged by the six equations, steady; the best are judged
    again with their ramps. From a present state turning begins at once, at the present closing
    rate where that is possible, and the most margin is sought instead of the least time.

    """
    _check(cell)
    tilt = cell.start_tilt if tilt is None else float(tilt)
    check_start(scene, tilt, "plan.start_tilt" if rates is None else "gamma")
    if rates is not None:
        rates = require_finite("rates", "rad/s", rates, 3)
        return _from_present(scene, cell, max_normal, tilt, rates, fineness)
    return _search(scene, cell, max_normal, tilt, np.zeros(3), False, fineness)


def judge(
    scene: Scene,
    cell: Cell,
    max_normal: Sequence[float],
    motion: ClosingMotion,
    fineness: Fineness = PLANNED,
) -> Outlook:
    """Return what a given motion leads to."""
    spread = spread_of(scene, fineness)
    path = path_of(motion, min(s.gamma0 for s in spread.scenes), fineness)
    found = path_margins(spread, cell, max_normal, path, fineness)
    return outlook(spread, found, path.gamma)


def kept(ahead: Outlook, cell: Cell) -> bool:
    """Return whether a motion keeps to the allowed probabilities."""
    return ahead.wedge <= cell.wedge_probability and ahead.overload <= cell.overload_probability


def _check(cell):
    if cell.aim not in AIMS:
        raise PegOnHoleError(f"plan.aim = {cell.aim!r} is not one of {', '.join(AIMS)}")
    if cell.min_closing_rate > cell.max_closing_rate:
        raise PegOnHoleError(
            f"plan.min_closing_rate = {cell.min_closing_rate:g} rad/s is above "
            f"plan.max_closing_rate = {cell.max_closing_rate:g} rad/s; it has to be at most that"
        )


def _from_present(scene, cell, max_normal, tilt, rates, fineness):
    """Return what is possible at the present closing rate, or else at a slower one."""
    fastest = min(max(-rates[0], cell.min_closing_rate), cell.max_closing_rate)
    for slowest in dict.fromkeys((fastest, cell.min_closing_rate)):
        held = replace(cell, min_closing_rate=slowest, max_closing_rate=fastest)
        found = _search(scene, held, max_normal, tilt, rates, True, fineness)
        if found.possible:
            break
    return found


def _search(scene, cell, max_normal, tilt, rates, present, fineness):
    spread, end = spread_of(scene, fineness), scene.gamma0
    plain = _plain(scene, cell, tilt, rates)
    plain_outlook = judge(scene, cell, max_normal, plain, fineness)
    table = candidates(spread, cell, max_normal, tilt, present, fineness)
    order = best_first(table, cell, tilt, end, present)
    nearest = plain, plain_outlook
    for share in fineness.shares:
        allowed = (table.wedge <= share * cell.wedge_probability) & (
            table.overload <= share * cell.overload_probability
        )
        fit = (k for k in order if allowed.flat[k])
        for motion in islice(motions(scene, table, fit, cell, tilt, rates), fineness.tried):
            ahead = judge(scene, cell, max_normal, motion, fineness)
            if kept(ahead, cell):
                return MotionPlan(True, motion, ahead, plain, plain_outlook)
            nearest = _nearer(nearest, (motion, ahead), cell, max_normal)
    # What wedges is further than any load.
    wedges = table.wedge > cell.wedge_probability
    by_margin = np.lexsort((-table.stated.ravel(), wedges.ravel()))
    for motion in islice(motions(scene, table, by_margin, cell, tilt, rates), fineness.tried):
        ahead = judge(scene, cell, max_normal, motion, fineness)
        nearest = _nearer(nearest, (motion, ahead), cell, max_normal)
    # Closing alone is no candidate, and near gamma0 it may be what keeps the limits.
    return MotionPlan(kept(nearest[1], cell), *nearest, plain, plain_outlook)  # type: ignore[call-arg]


def _plain(scene, cell, tilt, rates):
    """Return closing alone; where a ramp has no room, at once."""
    speed = -rates[0] if rates[0] < 0 else cell.max_closing_rate
    legs = [((-speed, 0.0, 0.0), scene.gamma0)]
    plain = motion_of(tilt, (rates[0], 0, 0), legs, scene.gamma0, cell.max_acceleration)
    return plain or motion_of(tilt, (-speed, 0, 0), legs, scene.gamma0, cell.max_acceleration)


def _nearer(a, b, cell, max_normal):
    """Return the motion that passes its limits less often, or where all do, by less."""

    def excess(pair):
        ahead = pair[1]
        often = max(
            ahead.wedge / max(cell.wedge_probability, 1e-6),
            ahead.overload / max(cell.overload_probability, 1e-6),
        )
        return often, max(load / most for load, most in zip(ahead.peak_high, max_normal))

    return b if excess(b) < excess(a) else a


def remedies(scene: Scene, cell: Cell, max_normal: Sequence[float]) -> tuple[str, ...]:
    """Return changes of the cell, each alone, that make a motion possible; each was tried."""
    tried = (
        (
            "push with at most {:.0%} of plan.press",
            (0.8, 0.6, 0.4, 0.25, 0.1),
            lambda x: {"press": tuple(x * p for p in cell.press)},
        ),
        (
            "set plan.max_slip_rate: {:.3g} rad/s",
            tuple(x * (cell.max_slip_rate or 0.25) for x in (2, 4, 8)),
            lambda x: {"max_slip_rate": x},
        ),
        (
            "set plan.min_closing_rate: {:.3g} rad/s",
            tuple(x * cell.min_closing_rate for x in (0.5, 0.25, 0.1)),
            lambda x: {"min_closing_rate": x},
        ),
    )
    found = []
    for words, values, change in tried:
        for value in values:
            changed = replace(cell, **change(value))
            if plan_motion(scene, changed, max_normal).possible:
                found.append(words.format(value))
                break
    return tuple(found)
