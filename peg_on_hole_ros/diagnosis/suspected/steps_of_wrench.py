"""Steps of a wrench from one message to the next, in the axes in which it is received."""

from collections.abc import Iterator
from math import hypot, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.diagnosis.tuned import WRENCH_STEP
from peg_on_hole_ros.typed_record import Floats


class Step(NamedTuple):
    """
    A step of the wrench to another level.

    Attributes
    ----------
    at_ns : int
        Stamp of the first wrench behind it [ns].
    jump, after : ndarray, shape (6,)
        Its size, and what is read behind it, by lines through both sides [N], [N m].
    noise : ndarray, shape (6,)
        Standard deviation of what is read at the end of a line.
    no_force : bool
        Whether it reads no force behind it.
    zeroes : bool
        Whether all six components read zero behind it, but for what the load has changed since
        the readings before it of which a driver has taken the mean.
    stays : bool
        Whether the latest wrenches are still nearer to what is read behind it.

    """

    at_ns: int
    jump: Floats
    after: Floats
    noise: Floats
    no_force: bool
    zeroes: bool
    stays: bool


def find_steps(t_ns: np.ndarray, rows: Floats, stated: Floats) -> Iterator[Step]:
    """
    Yield the steps to less force in their order: stamps [ns], rows (n, 6), and their stated noise.

    Where stamps do not rise, or few wrenches are there, none is found.
    """
    periods = np.diff(t_ns)
    if len(periods) < 2 * WRENCH_STEP.fewest or periods.min() <= 0:
        return
    change, loses = np.abs(np.diff(rows, axis=0)), _loses_force(rows)
    # What takes longer to tell is looked at where something is to be told.
    loses &= (change > WRENCH_STEP.changes * stated).any(axis=1)
    if not loses.any():
        return
    usual, period = WRENCH_STEP.changes * _noise_of(rows), float(np.median(periods)) * 1e-9
    for k in np.flatnonzero(loses & (change > usual).any(axis=1)).tolist():
        step = _step_behind(k, t_ns, rows, period, stated)
        if step is not None:
            yield step


def _loses_force(rows: Floats) -> np.ndarray:
    """Return whether a few wrenches behind each but the last have less force than it, (n - 1,)."""
    force = rows[:, :3]
    few = min(WRENCH_STEP.first, len(force) - 1)
    sums = np.cumsum(np.vstack([np.zeros(3), force]), axis=0)
    at = np.arange(len(force) - 1)
    first, end = np.maximum(at + 1 - few, 0), np.minimum(at + 1 + few, len(force))
    before = (sums[at + 1] - sums[first]) / (at + 1 - first)[:, None]
    after = (sums[end] - sums[at + 1]) / (end - at - 1)[:, None]
    less: np.ndarray = (after**2).sum(axis=1) < WRENCH_STEP.less**2 * (before**2).sum(axis=1)
    return less


def _step_behind(
    k: int, t_ns: np.ndarray, rows: Floats, period: float, stated: Floats
) -> Step | None:
    """Return the step behind a wrench, if it is one by itself; None: it is not."""
    count = max(round(WRENCH_STEP.line / period), WRENCH_STEP.fewest)
    sides = []
    for side in (slice(max(k + 1 - count, 0), k + 1), slice(k + 1, k + 1 + count)):
        t = (t_ns[side] - t_ns[k + 1]) * 1e-9
        if len(t) < WRENCH_STEP.first or t[-1] - t[0] > WRENCH_STEP.gap * len(t) * period:
            return None
        sides.append(_at_end(t, rows[side], len(t) >= count, stated))
    (before, noise0), (after, noise1) = sides
    noise, jump = np.maximum(noise0, noise1), after - before
    ratio = float((np.abs(jump) / noise).max())
    if ratio < WRENCH_STEP.changes:
        return None
    # At the end of a line.
    known = noise * sqrt(8.0 / count)
    size = np.repeat([hypot(*jump[:3]), hypot(*jump[3:])], 3)
    off = WRENCH_STEP.sure * known + WRENCH_STEP.missed * size
    near, taken = np.abs(after) < off, _taken(-jump, off, rows[: k + 1], period)
    zeroes = bool(near.all()) or taken is not None
    # The mean of what was read is known better than where lines end.
    jump = jump if taken is None else -taken
    latest = rows[-WRENCH_STEP.first :].mean(axis=0)
    away, back = (np.linalg.norm((latest - level) / noise) for level in (before, after))
    stays = bool(back < away)
    return Step(int(t_ns[k + 1]), jump, after, known, bool(near[:3].all()), zeroes, stays)


def _taken(off_by: Floats, room: Floats, rows: Floats, period: float) -> Floats | None:
    """Return the mean of some of the last wrenches that was taken off; None: there is none."""
    most = min(round(WRENCH_STEP.taken / period), len(rows))
    last = rows[len(rows) - most :][::-1]
    means = np.cumsum(last, axis=0) / np.arange(1, most + 1)[:, None]
    away = np.abs((off_by - means) / room)[WRENCH_STEP.first - 1 :].max(axis=1)
    if not len(away) or away.min() > 1.0:
        return None
    found: Floats = means[WRENCH_STEP.first - 1 + int(away.argmin())]
    return found


def _at_end(t: Floats, rows: Floats, enough: bool, stated: Floats) -> tuple[Floats, Floats]:
    """
    Return what is read at time 0, and what is left, by the rows (n, 6) on one side.

    Where a line leaves more than noise, the load does not go on straight: a parabola tells where
    it was. Of a few wrenches neither is known.
    """
    powers = np.column_stack([np.ones(len(t)), t, t * t])
    (level, left), (bent, _) = (
        _fitted(powers[:, : columns if enough else 1], rows) for columns in (2, 3)
    )
    straight = left < WRENCH_STEP.straight * np.maximum(_noise_of(rows), stated)
    return np.where(straight, level, bent), np.maximum(left, stated)


def _fitted(powers: Floats, rows: Floats) -> tuple[Floats, Floats]:
    found = np.linalg.lstsq(powers, rows, rcond=None)[0]
    left = np.square(rows - powers @ found).sum(axis=0) / max(len(rows) - len(found), 1)
    return found[0], np.sqrt(left)


def _noise_of(rows: Floats) -> Floats:
    """Return the noise of rows (n, 6) by their steps, half of which are below it."""
    return np.median(np.abs(np.diff(rows, axis=0)), axis=0)
