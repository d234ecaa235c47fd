"""Loads and margins along a closing, for all that friction and clearance may be."""

from collections.abc import Sequence
from enum import Enum
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.planning.cell import Cell
from peg_on_hole_ros.mechanics.planning.chatter import growth
from peg_on_hole_ros.mechanics.planning.fineness import PLANNED, Fineness
from peg_on_hole_ros.mechanics.planning.holder_lag import followed
from peg_on_hole_ros.mechanics.planning.motion import NEAREST_TO_GAMMA0, Path
from peg_on_hole_ros.mechanics.planning.spread import Spread, probability_below, quantile
from peg_on_hole_ros.mechanics.planning.steady import Steady, steady_loads
from peg_on_hole_ros.records import CONTACTS

# Normalised determinant below which a motion counts as wedged: at 0 rigid motion ends.
WEDGED = 0.02
# B1 or B2 lets go this near gamma0 [rad]: that is the way into two-point contact.
TRANSITION = 2e-3
# Least margin that is told apart: twenty times a limit.
_LEAST_MARGIN = -20.0
# Share of its limit with which a contact is pressed firmly.
_FIRM = 0.05
# Decay with which a motion counts as calm [1/s].
_CALM_DECAY = 50.0
# What is stated of a load as its most.
LOAD_QUANTILE = 0.95


class Cause(Enum):
    """What a limit is passed by; the values are words for it."""

    WEDGE = "the peg wedges"
    K = "overload at K"
    B1 = "overload at B1"
    B2 = "overload at B2"
    PARTS = "a contact parts"
    CHATTERS = "the peg chatters"
    FORCE = "the holder's force limit is reached"
    TORQUE = "the holder's torque limit is reached"


class Margins(NamedTuple):
    """
    Loads and margins; points follow each other in time, with falling tilt.

    Attributes
    ----------
    normal : ndarray, shape (3, clearance, friction, ..., n)
        N_K, N_B1, N_B2 [N]; zero once it is wedged or two-point contact is reached.
    determinant : ndarray, shape (clearance, friction, ..., n)
        NaN once two-point contact is reached.
    wedge : ndarray, shape (clearance, friction, ..., n)
        Below zero where it wedges.
    others : ndarray, shape (7, clearance, friction, ..., n)
        Of loads at K, B1, B2, of a contact that parts, of chatter, of the holder's force and
        torque; of loads as shares of their limits.

    """

    normal: np.ndarray
    determinant: np.ndarray
    wedge: np.ndarray
    others: np.ndarray


def path_margins(
    spread: Spread,
    cell: Cell,
    max_normal: Sequence[float],
    path: Path,
    fineness: Fineness = PLANNED,
) -> Margins:
    """Return loads and margins along a path with its ramps."""
    found = []
    for scene in spread.scenes:
        inside = np.maximum(path.gamma, scene.gamma0 + NEAREST_TO_GAMMA0)
        loads, rates = followed(scene, cell, path, inside, spread.frictions)
        chatters = growth if fineness.chatter else _growth
        grows = chatters(scene, cell, inside, rates, spread.frictions, loads)
        found.append(_of_scene(loads, grows, cell, max_normal, *_ends(scene, path.gamma)))
    return _stacked(found)


def margins(
    spread: Spread,
    cell: Cell,
    max_normal: Sequence[float],
    gamma: np.ndarray,
    rates: np.ndarray,
    chatter: bool = True,
) -> Margins:
    """
    Return loads and margins along steady closings.

    Parameters
    ----------
    spread : Spread
    cell : Cell
    max_normal : sequence of 3 float
        Limits at K, B1, B2 [N].
    gamma : ndarray, shape (n,)
        Falling [rad].
    rates : ndarray, shape (3, ..., n)
        gamma', psi', phi' [rad/s].
    chatter : bool
        Whether it is looked for.

    Returns
    -------
    Margins

    """
    shape = rates.shape[1:]
    flat = np.broadcast_to(gamma, shape).ravel()
    found = []
    for scene in spread.scenes:
        inside = np.maximum(flat, scene.gamma0 + NEAREST_TO_GAMMA0)
        steady = steady_loads(scene, cell, inside, rates.reshape(3, -1), spread.frictions)
        ends = (np.broadcast_to(end, shape) for end in _ends(scene, gamma))
        grows = np.full(steady.determinant.shape, -np.inf)
        if chatter:
            flat_rates = rates.reshape(3, -1)
            grows = _growth(scene, cell, inside, flat_rates, spread.frictions, steady)
        found.append(_of_scene(steady, grows, cell, max_normal, *ends))
    return _stacked(found)


def _growth(scene, cell, gamma, rates, frictions, steady):
    """Return the growth of vibrations, at a few of the frictions alone: it is dear."""
    at = np.unique([0, len(frictions) // 2, len(frictions) - 1])
    some = Steady(*(part[..., at, :] for part in steady))
    along = rates[:, at] if rates.ndim == 3 else rates
    found = growth(scene, cell, gamma, along, frictions[at], some)
    nearest = np.argmin(np.abs(np.arange(len(frictions))[:, None] - at), axis=1)
    return found[nearest]


def _ends(scene, gamma):
    """Return where B1 or B2 may let go into two-point contact, and where that is reached."""
    return gamma < scene.gamma0 + TRANSITION, gamma <= scene.gamma0


def _stacked(found):
    normal, determinant, wedge, others = zip(*found)
    return Margins(
        np.stack(normal, 1), np.stack(determinant), np.stack(wedge), np.stack(others, 1)
    )


def _of_scene(steady, grows, cell, max_normal, near, below):
    many = (len(steady.determinant), *near.shape)
    normal = steady.normal.reshape(3, *many).copy()
    determinant = steady.determinant.reshape(many)
    lets_go = near & (np.minimum(normal[1], normal[2]) < 0)
    over = np.logical_or.accumulate(lets_go | below, axis=-1)
    first = lets_go & (np.cumsum(over, axis=-1) == 1)
    # Where one of B1, B2 lets go the other has the load of both.
    both = np.maximum(normal[1] + normal[2], 0)
    for k, other in ((1, 2), (2, 1)):
        normal[k] = np.where(first, np.where(normal[other] < 0, both, 0.0), normal[k])
    counted = ~over | first
    normal = np.where(counted, normal, 0.0)
    limits = np.reshape(np.asarray(max_normal, float), (3, *(1,) * len(many)))
    loads = 1 - normal / limits
    parting = np.where(first, 1.0, np.min(normal / (_FIRM * limits), axis=0))
    holder = np.stack(
        [
            1 - steady.force.reshape(many) / cell.force_limit,
            1 - steady.torque.reshape(many) / cell.torque_limit,
        ]
    )
    calm = np.where(counted, -grows.reshape(many) / _CALM_DECAY, 1.0)
    others = np.concatenate([loads, parting[None], calm[None], np.where(counted, holder, 1.0)])
    wedge = np.where(counted, determinant - WEDGED, 1.0)
    shown = np.where(counted, determinant, np.nan)
    # A wedge lets no load be known: what is beyond it is not counted twice.
    stopped = np.logical_or.accumulate(wedge < 0, axis=-1)
    normal = np.where(stopped, 0.0, normal)
    others = np.where(stopped | ~counted, 1.0, others)
    return normal, shown, np.clip(wedge, -1, 1), np.clip(others, _LEAST_MARGIN, 1)


class Outlook(NamedTuple):
    """
    What a closing leads to.

    Attributes
    ----------
    wedge, overload : float
        Probabilities: that it wedges; that it passes another limit before.
    expected : Cause or None
        What comes first with friction and clearance as stated; None: it goes through.
    expected_tilt : float or None
        Where [rad].
    causes : tuple of (Cause, float)
        All that may come with a probability of 0.1 % at least, the likeliest first.
    peak : tuple of 3 float
        Largest N_K, N_B1, N_B2 with friction and clearance as stated [N].
    peak_high : tuple of 3 float
        That 95 % of frictions and clearances stay under [N].
    least_determinant : float
        That 95 % stay above.

    """

    wedge: float
    overload: float
    expected: Cause | None
    expected_tilt: float | None
    causes: tuple[tuple[Cause, float], ...]
    peak: tuple[float, float, float]
    peak_high: tuple[float, float, float]
    least_determinant: float


_OTHER_CAUSES = (*(Cause[name] for name in CONTACTS), Cause.PARTS, Cause.CHATTERS, Cause.FORCE)
_OTHER_CAUSES += (Cause.TORQUE,)


def outlook(spread: Spread, found: Margins, gamma: np.ndarray) -> Outlook:
    """Return what one closing leads to, of its margins (no axes between friction and points)."""
    chances = [(Cause.WEDGE, float(probability_below(spread, found.wedge.min(axis=-1))))]
    for cause, margin in zip(_OTHER_CAUSES, found.others):
        chances.append((cause, float(probability_below(spread, margin.min(axis=-1)))))
    overload = float(probability_below(spread, found.others.min(axis=(0, -1))))
    c, f = spread.middle
    rows = np.concatenate([found.wedge[None, c, f], found.others[:, c, f]])
    hit = rows.min(axis=0) < 0
    expected = tilt = None
    if hit.any():
        k = int(np.argmax(hit))
        row = int(np.argmin(rows[:, k]))
        expected, tilt = chances[row][0], float(gamma[k])
        if k and rows[row, k - 1] > 0:
            # Between two points the margin is a straight line.
            share = rows[row, k - 1] / (rows[row, k - 1] - rows[row, k])
            tilt = float(gamma[k - 1] + share * (gamma[k] - gamma[k - 1]))
    peaks = found.normal.max(axis=-1)
    least = np.nanmin(found.determinant, axis=-1)
    likely = sorted((x for x in chances if x[1] >= 1e-3), key=lambda x: -x[1])
    return Outlook(
        chances[0][1],
        overload,
        expected,
        tilt,
        tuple(likely),
        tuple(float(x) for x in peaks[:, c, f]),  # type: ignore[arg-type]
        tuple(float(quantile(spread, peaks[k], LOAD_QUANTILE)) for k in range(len(CONTACTS))),  # type: ignore[arg-type]
        float(-quantile(spread, -least, LOAD_QUANTILE)),
    )
