"""Find the closing, slip and slide rates, and where to begin to turn, that keep the limits."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.checks import require_finite
from peg_on_hole_ros.mechanics.planning.cell import AIMS, Cell, check_start
from peg_on_hole_ros.mechanics.planning.motion import Motion, motion_of, path_of
from peg_on_hole_ros.mechanics.planning.outlook import NEAREST, Outlook, margins, outlook
from peg_on_hole_ros.mechanics.planning.spread import probability_below, spread_of
from peg_on_hole_ros.mechanics.scene import Scene

# Candidates: rates of closing, of turning, and tilts at which turning is under way.
_CLOSINGS, _TURNS, _TILTS = 6, 12, 70
_LEAST_TURN = 0.01
# Shares of the allowed probabilities that candidates are asked for, before ramps are looked at.
_STRICTER = (1.0, 0.7, 0.4, 0.1, 0.0)
_TRIED = 4


class MotionPlan(NamedTuple):
    """
    A motion that keeps the limits, or the best that is known where none does.

    Attributes
    ----------
    possible : bool
    motion : Motion
        Where none is possible, the one that comes nearest.
    outlook : Outlook
        Of the motion.
    plain : Motion
        Closing alone, at the fastest rate allowed, or from a present state at its own.
    plain_outlook : Outlook
    remedies : tuple of str
        Where none is possible: changes of the cell that make one so; each was tried.

    """

    possible: bool
    motion: Motion
    outlook: Outlook
    plain: Motion
    plain_outlook: Outlook
    remedies: tuple[str, ...]


def plan_motion(scene: Scene, cell: Cell, max_normal, tilt=None, rates=None) -> MotionPlan:
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
        Present gamma', psi', phi' [rad/s]; at rest by default.

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
    again with their ramps.

    """
    _check(cell)
    tilt = cell.start_tilt if tilt is None else float(tilt)
    check_start(scene, tilt, "plan.start_tilt" if rates is None else "gamma")
    present = rates is not None
    rates = require_finite("rates", "rad/s", np.zeros(3) if rates is None else rates, 3)
    found = _search(scene, cell, max_normal, tilt, rates, present)
    if not found.possible and not present:
        found = found._replace(remedies=_remedies(scene, cell, max_normal, tilt, rates))
    return found


def judge(scene: Scene, cell: Cell, max_normal, motion: Motion) -> Outlook:
    """Return what a given motion leads to."""
    spread = spread_of(scene)
    path = path_of(motion, min(s.gamma0 for s in spread.scenes))
    found = margins(spread, cell, max_normal, path.gamma, path.rates)
    return outlook(spread, found, path.gamma)


def _check(cell):
    if cell.aim not in AIMS:
        raise PegOnHoleError(f"plan.aim = {cell.aim!r} is not one of {', '.join(AIMS)}")
    if cell.min_closing_rate > cell.max_closing_rate:
        raise PegOnHoleError(
            f"plan.min_closing_rate = {cell.min_closing_rate:g} rad/s is above "
            f"plan.max_closing_rate = {cell.max_closing_rate:g} rad/s; it has to be at most that"
        )


class _Table(NamedTuple):
    """
    Candidates (alone, turning, tilt): closing alone down to a tilt, and turning from it on.

    `wedge` and `overload` are probabilities, `stated` the least margin with friction and clearance
    as stated.
    """

    gamma: np.ndarray
    alone: np.ndarray
    turning: np.ndarray
    wedge: np.ndarray
    overload: np.ndarray
    stated: np.ndarray


def _search(scene, cell, max_normal, tilt, rates, present):
    spread = spread_of(scene)
    gamma0 = min(s.gamma0 for s in spread.scenes)
    end = scene.gamma0
    speed = -rates[0] if present and rates[0] < 0 else cell.max_closing_rate
    plain = motion_of(tilt, [rates[0], 0, 0], [((-speed, 0, 0), end)], end, cell.max_acceleration)
    if plain is None:
        plain = motion_of(tilt, (-speed, 0, 0), [((-speed, 0, 0), end)], end, 1e9)
    plain_outlook = judge(scene, cell, max_normal, plain)
    table = _table(spread, cell, max_normal, gamma0, tilt, present)
    order = _costs(table, cell, tilt, end)
    best, nearest = None, None
    for share in _STRICTER:
        allowed = (table.wedge <= share * cell.wedge_probability) & (
            table.overload <= share * cell.overload_probability
        )
        for at in [k for k in order if allowed.flat[k]][:_TRIED]:
            motion = _motion(
                table, np.unravel_index(at, table.wedge.shape), cell, tilt, rates, end
            )
            if motion is None:
                continue
            ahead = judge(scene, cell, max_normal, motion)
            if kept(ahead, cell):
                best = motion, ahead
                break
            nearest = _nearer(nearest, (motion, ahead), cell, max_normal)
        if best:
            break
    if best is None:
        for at in np.argsort(-table.stated, axis=None)[:_TRIED]:
            motion = _motion(
                table, np.unravel_index(at, table.wedge.shape), cell, tilt, rates, end
            )
            if motion is not None:
                ahead = judge(scene, cell, max_normal, motion)
                nearest = _nearer(nearest, (motion, ahead), cell, max_normal)
        nearest = nearest or (plain, plain_outlook)
    motion, ahead = best or nearest
    return MotionPlan(best is not None, motion, ahead, plain, plain_outlook, ())


def kept(ahead: Outlook, cell: Cell) -> bool:
    """Return whether a motion keeps to the allowed probabilities."""
    return ahead.wedge <= cell.wedge_probability and ahead.overload <= cell.overload_probability


def _nearer(a, b, cell, max_normal):
    """Return the motion that passes its limits less often, or where all do, by less."""

    def excess(pair):
        ahead = pair[1]
        often = max(
            ahead.wedge / max(cell.wedge_probability, 1e-6),
            ahead.overload / max(cell.overload_probability, 1e-6),
        )
        return often, max(load / most for load, most in zip(ahead.peak_high, max_normal))

    return b if a is None or excess(b) < excess(a) else a


def _candidates(cell):
    """Return rates of closing alone (3, a) and of closing and turning (3, t)."""
    closings = -np.geomspace(cell.max_closing_rate, cell.min_closing_rate, _CLOSINGS)
    if cell.min_closing_rate == cell.max_closing_rate:
        closings = closings[:1]
    shares = np.geomspace(_LEAST_TURN, 1, _TURNS)
    slips = cell.max_slip_rate * shares if cell.max_slip_rate else np.zeros(0)
    # Slide beside the fastest slip, or alone.
    slides = cell.max_slide_rate * shares[_TURNS // 2 :] if len(slips) else None
    if not len(slips):
        slides = cell.max_slide_rate * shares
    turns = [(0.0, slip) for slip in slips]
    if cell.max_slide_rate:
        turns += [(slide, cell.max_slip_rate) for slide in slides]
    alone = np.array([[c, 0.0, 0.0] for c in closings])
    both = np.array([[c, *turn] for c in closings for turn in turns]).reshape(-1, 3)
    return alone.T, np.concatenate([alone, both]).T


def _table(spread, cell, max_normal, gamma0, tilt, present):
    alone, turning = _candidates(cell)
    gamma = gamma0 + np.geomspace(tilt - gamma0, NEAREST, _TILTS)
    rates = np.concatenate([alone, turning], axis=1)
    spanned = np.broadcast_to(rates[:, :, None], (*rates.shape, len(gamma)))
    found = margins(spread, cell, max_normal, gamma, spanned)
    others, count = found.others.min(axis=0), alone.shape[1]

    # [clearance, friction, alone, turning, tilt]: alone down to a tilt, turning from it on.
    def worst(margin):
        down = np.minimum.accumulate(margin[:, :, :count], axis=-1)
        up = np.minimum.accumulate(margin[:, :, count:, ::-1], axis=-1)[..., ::-1]
        # From the start on nothing is closed alone.
        down = np.concatenate([np.ones_like(down[..., :1]), down[..., :-1]], axis=-1)
        # A present state begins to turn now.
        return np.minimum(down[:, :, :, None], up[:, :, None])[..., : 1 if present else None]

    wedge, overload = worst(found.wedge), worst(others)
    stated = np.minimum(wedge, overload)[spread.middle]
    wedge, overload = probability_below(spread, wedge), probability_below(spread, overload)
    return _Table(gamma, alone.T, turning.T, wedge, overload, stated)


def _costs(table, cell, tilt, end):
    """Return all candidates, the best first."""
    shape = table.wedge.shape
    at = table.gamma[: shape[2]][None, None]
    before = (tilt - at) / -table.alone[:, 0][:, None, None]
    after = np.maximum(at - end, 0) / -table.turning[:, 0][None, :, None]
    time = np.broadcast_to(before + after, shape).ravel()
    turn = after * np.abs(table.turning[:, 1:]).sum(axis=1)[None, :, None]
    turn = np.broadcast_to(turn, shape).ravel()
    keys = (time, turn) if cell.aim == "turning" else (turn, time)
    # A thousandth of a second or of a radian decides nothing.
    return np.lexsort([np.round(key, 3) for key in keys])


def _motion(table, at, cell, tilt, rates, end):
    a, t, k = at
    alone, turning = table.alone[a], table.turning[t]
    legs = [(turning, end)]
    if k and np.any(turning[1:]):
        ramp = 1.5 * np.max(np.abs(turning - alone)) / cell.max_acceleration
        begin = table.gamma[k] - (turning[0] + alone[0]) / 2 * ramp + cell.tilt_margin
        if begin < tilt:
            legs.insert(0, (alone, begin))
    found = motion_of(tilt, rates, legs, end, cell.max_acceleration)
    if found is None and len(legs) > 1:
        found = motion_of(tilt, rates, legs[1:], end, cell.max_acceleration)
    return found


def _remedies(scene, cell, max_normal, tilt, rates):
    """Return changes of the cell, each alone, that make a motion possible."""
    tried = (
        (
            "push with at most {:.0%} of plan.press",
            (0.8, 0.6, 0.4, 0.25, 0.1),
            lambda x: {"press": tuple(x * p for p in cell.press)},
        ),
        (
            "let plan.max_slip_rate be {:.3g} rad/s",
            tuple(x * (cell.max_slip_rate or 0.25) for x in (2, 4, 8)),
            lambda x: {"max_slip_rate": x},
        ),
        (
            "let plan.min_closing_rate be {:.3g} rad/s",
            tuple(x * cell.min_closing_rate for x in (0.5, 0.25, 0.1)),
            lambda x: {"min_closing_rate": x},
        ),
    )
    remedies = []
    for words, values, change in tried:
        for value in values:
            changed = replace(cell, **change(value))
            if _search(scene, changed, max_normal, tilt, rates, False).possible:
                remedies.append(words.format(value))
                break
    return tuple(remedies)
