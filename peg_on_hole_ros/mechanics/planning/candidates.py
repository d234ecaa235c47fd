"""Pairs of rates, and the tilt between them, with what each would lead to; the best first."""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.planning.cell import Cell
from peg_on_hole_ros.mechanics.planning.fineness import Fineness
from peg_on_hole_ros.mechanics.planning.motion import NEAREST_TO_GAMMA0, ClosingMotion, motion_of
from peg_on_hole_ros.mechanics.planning.outlook import margins
from peg_on_hole_ros.mechanics.planning.spread import Spread, probability_below
from peg_on_hole_ros.mechanics.planning.steady import steady_loads
from peg_on_hole_ros.mechanics.scene import Scene

# The slowest turning that is looked at, as a share of the fastest.
_LEAST_TURN = 0.01


class Candidates(NamedTuple):
    """
    Motions that are tried: closing alone down to a tilt, then closing while turning.

    Attributes
    ----------
    tilt : ndarray, shape (k,)
        At which turning is under way [rad].
    alone, turning : ndarray, shape (a, 3), (t, 3)
        gamma', psi', phi' [rad/s]; some of `turning` do not turn.
    wedge, overload : ndarray, shape (a, t, k)
        Probabilities.
    stated : ndarray, shape (a, t, k)
        Least margin with friction and clearance as stated, as a share of the limits.

    """

    tilt: np.ndarray
    alone: np.ndarray
    turning: np.ndarray
    wedge: np.ndarray
    overload: np.ndarray
    stated: np.ndarray


def candidates(
    spread: Spread,
    cell: Cell,
    max_normal: Sequence[float],
    tilt: float,
    present: bool,
    fineness: Fineness,
) -> Candidates:
    """
    Return all candidates from a tilt on; ramps between their rates are left out.

    Parameters
    ----------
    spread : Spread
    cell : Cell
    max_normal : sequence of 3 float
        [N]
    tilt : float
        At the begin [rad].
    present : bool
        Whether turning has to begin at once.
    fineness : Fineness

    """
    alone, turning = _rates(cell, fineness)
    gamma0 = min(scene.gamma0 for scene in spread.scenes)
    gamma = gamma0 + np.geomspace(tilt - gamma0, NEAREST_TO_GAMMA0, fineness.tilts)
    rates = np.concatenate([alone, turning], axis=1)
    spanned = np.broadcast_to(rates[:, :, None], (*rates.shape, len(gamma)))
    found = margins(spread, cell, max_normal, gamma, spanned, fineness.chatter)
    count = alone.shape[1]

    def least(margin):
        down = np.minimum.accumulate(margin[:, :, :count], axis=-1)
        up = np.minimum.accumulate(margin[:, :, count:, ::-1], axis=-1)[..., ::-1]
        # Where turning is under way from the begin, nothing is closed alone.
        down = np.concatenate([np.ones_like(down[..., :1]), down[..., :-1]], axis=-1)
        return np.minimum(down[:, :, :, None], up[:, :, None])[..., : 1 if present else None]

    wedge, overload = least(found.wedge), least(found.others.min(axis=0))
    return Candidates(
        gamma,
        alone.T,
        turning.T,
        probability_below(spread, wedge),
        probability_below(spread, overload),
        np.minimum(wedge, overload)[spread.middle],
    )


def _rates(cell, fineness):
    """Return rates of closing alone (3, a), and those with turns beside them (3, t)."""
    closings = -np.geomspace(cell.max_closing_rate, cell.min_closing_rate, fineness.closings)
    if cell.min_closing_rate == cell.max_closing_rate:
        closings = closings[:1]
    shares = np.geomspace(_LEAST_TURN, 1, fineness.turns)
    turns = [(0.0, slip) for slip in cell.max_slip_rate * shares if slip]
    # Slide beside the fastest slip, or alone.
    shares = shares[fineness.turns // 2 :] if turns else shares
    turns += [(slide, cell.max_slip_rate) for slide in cell.max_slide_rate * shares if slide]
    alone = np.array([[c, 0.0, 0.0] for c in closings])
    both = np.array([[c, *turn] for c in closings for turn in turns]).reshape(-1, 3)
    return alone.T, np.concatenate([alone, both]).T


def best_first(
    table: Candidates, cell: Cell, tilt: float, end: float, present: bool
) -> np.ndarray:
    """
    Return the flat indices of all candidates, by the cell's aim.

    From a present state margin comes first: it is asked for where something is amiss.
    """
    shape = table.wedge.shape
    at = table.tilt[: shape[2]][None, None]
    before = (tilt - at) / -table.alone[:, 0][:, None, None]
    after = np.maximum(at - end, 0) / -table.turning[:, 0][None, :, None]
    time = np.broadcast_to(before + after, shape).ravel()
    turn = after * np.abs(table.turning[:, 1:]).sum(axis=1)[None, :, None]
    turn = np.broadcast_to(turn, shape).ravel()
    # A thousandth of a second or of a radian decides nothing.
    keys = [np.round(time, 3), np.round(turn, 3)]
    if cell.aim == "time":
        keys.reverse()
    if present:
        keys.append(-np.round(table.stated.ravel(), 2))
    return np.lexsort(keys)


def motions(
    scene: Scene,
    table: Candidates,
    order: Iterable[int],
    cell: Cell,
    tilt: float,
    rates: np.ndarray,
) -> Iterator[ClosingMotion]:
    """Yield the motions of candidates in an order, as far as their ramps have room."""
    end = scene.gamma0
    for flat in order:
        a, t, k = np.unravel_index(flat, table.wedge.shape)
        alone, turning = table.alone[a], table.turning[t]
        legs = [(turning, end)]
        if k and np.any(turning[1:]):
            ramp = 1.5 * np.max(np.abs(turning - alone)) / cell.max_acceleration
            begin = table.tilt[k] - (turning[0] + alone[0]) / 2 * ramp + cell.tilt_margin
            # Until the holder is wound up the peg turns less than it is led.
            begin -= turning[0] * _winding(scene, cell, table.tilt[k], turning)
            if begin < tilt:
                legs.insert(0, (alone, begin))
        found = motion_of(tilt, rates, legs, end, cell.max_acceleration)
        if found is None and len(legs) > 1:
            found = motion_of(tilt, rates, legs[1:], end, cell.max_acceleration)
        if found is not None:
            yield found


def _winding(scene, cell, gamma, rates):
    """Return the time that a turn takes to wind the holder up [s]."""
    above = np.array([max(gamma, scene.gamma0 + NEAREST_TO_GAMMA0)])
    loads = steady_loads(scene, cell, above, rates, [scene.friction])
    return abs(float(loads.lag[1:].sum()) / (rates[1] + rates[2]))
