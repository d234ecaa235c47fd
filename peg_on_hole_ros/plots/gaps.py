"""Gaps in plots: where nothing came for long, no line is drawn."""

from collections.abc import Sequence

import numpy as np

# Without settings that say it, as `filter.max_gap` does by default [s].
SILENCE = 0.1
# A silence is so many times longer than what is usual between two rows of a thinned table.
_TIMES_USUAL = 8.0


def with_gaps(columns: dict[str, np.ndarray], longest: float = SILENCE) -> dict[str, np.ndarray]:
    """
    Return columns with a row without numbers in each silence, so that a line breaks there.

    Parameters
    ----------
    columns : dict of str to ndarray, shape (n,) or (n, m)
        `t` [s], which never falls, and others.
    longest : float
        Time between two rows that is no silence yet [s].

    """
    t = columns["t"]
    silent = silences(t, longest)
    if not len(silent):
        return columns
    middles = 0.5 * (t[silent] + t[silent + 1])
    return {
        name: np.insert(column, silent + 1, middles if name == "t" else np.nan, axis=0)
        for name, column in columns.items()
    }


def silences(t: np.ndarray, longest: float) -> np.ndarray:
    """Return the rows after which nothing came for long, at times `t` [s]."""
    steps = np.diff(t)
    if not len(steps):
        return np.empty(0, np.int64)
    return np.flatnonzero(steps > max(longest, _TIMES_USUAL * float(np.median(steps))))


def changes_with_gaps(
    changes: Sequence[tuple[int, str]], t: np.ndarray, longest: float
) -> list[tuple[int, str]]:
    """
    Return changes of the contact mode [ns], with an empty one for each silence.

    Parameters
    ----------
    changes : sequence of (int, str)
        Time [ns] and the mode from there on.
    t : ndarray, shape (n,)
        When an estimate came [s].
    longest : float
        See `with_gaps`.

    """
    found = list(changes)
    for row in silences(t, longest).tolist():
        begin, end = round(t[row] * 1e9), round(t[row + 1] * 1e9)
        before = [mode for at, mode in changes if at <= begin]
        held = [mode for at, mode in changes if at <= end]
        found = [change for change in found if not begin < change[0] <= end]
        if before and held:
            found += [(begin, ""), (end, held[-1])]
    return sorted(found, key=lambda change: change[0])
