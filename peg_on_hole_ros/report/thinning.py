"""Fewer rows for a plot: what is left holds every peak, or the whole rows with most load."""

from array import array
from collections.abc import Callable, Sequence

import numpy as np

Reduction = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]

# Rows that are held at most; what a plot is given is thinned further.
MOST_HELD = 32_768
_STAGE = 8192


def peaks(t: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Return half of the rows: of each four the least and the greatest value of every column.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Never less than the one before.
    values : ndarray, shape (n, c)
        NaN is left out where there is a number beside it.

    Returns
    -------
    t : ndarray, shape (m,)
        Of the first and the third of each four; those of the last n % 4 rows as they are.
    values : ndarray, shape (m, c)
        The two of each column in their order, so at most three rows off their time.

    """
    whole = len(t) // 4 * 4
    fours = values[:whole].reshape(-1, 4, values.shape[1])
    low, high = np.fmin.reduce(fours, axis=1), np.fmax.reduce(fours, axis=1)
    first_low = np.where(np.isnan(fours), np.inf, fours).argmin(axis=1)
    first_high = np.where(np.isnan(fours), -np.inf, fours).argmax(axis=1)
    rises = first_low <= first_high
    pairs = np.stack([np.where(rises, low, high), np.where(rises, high, low)], axis=1)
    left = pairs.reshape(-1, values.shape[1])
    return (
        np.concatenate([t[:whole:2], t[whole:]]),
        np.concatenate([left, values[whole:]]),
    )


def most_loaded(t: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return half of the rows, whole ones: of each two that with more in its first column."""
    whole = len(t) // 2 * 2
    load = np.nan_to_num(values[:whole, 0], nan=-np.inf).reshape(-1, 2)
    chosen = 2 * np.arange(whole // 2) + load.argmax(axis=1)
    chosen = np.concatenate([chosen, np.arange(whole, len(t))])
    return t[chosen], values[chosen]


def thinned(
    t: np.ndarray, values: np.ndarray, most: int, reduce: Reduction = peaks
) -> tuple[np.ndarray, np.ndarray]:
    """Return times and rows, reduced by halves until there are at most `most`, 4 or more."""
    while len(t) > most:
        t, values = reduce(t, values)
    return t, values


class ThinnedRows:
    """
    Rows of numbers with their times, as many as come; beyond `most` all are thinned alike.

    Parameters
    ----------
    width : int
        Numbers of a row.
    reduce : callable
        `peaks` or `most_loaded`.
    most : int
        Rows to hold.

    """

    def __init__(self, width: int, reduce: Reduction = peaks, most: int = MOST_HELD) -> None:
        self._width, self._reduce, self._most = width, reduce, most
        self._level = 0
        self._held_t = np.empty(0, np.int64)
        self._held = np.empty((0, width), np.float32)
        self._blocks: list[tuple[np.ndarray, np.ndarray]] = []
        self._count = 0
        self._t, self._values = array("q"), array("f")

    def add(self, t_ns: int, row: Sequence[float]) -> None:
        """Take one row and its time [ns]; a row that is behind this time is let go."""
        while self._t and self._t[-1] > t_ns:
            del self._t[-1], self._values[-self._width :]
        self._t.append(t_ns)
        self._values.extend(row)
        # The last stays: it may be let go.
        if len(self._t) > _STAGE:
            self._flush(_STAGE)

    def add_all(self, t_ns: np.ndarray, rows: np.ndarray) -> None:
        """Take rows, shape (n, width), whose times never fall [ns], as `add` would each."""
        if not len(t_ns):
            return
        self.add(int(t_ns[0]), rows[0].tolist())
        self._t.frombytes(np.ascontiguousarray(t_ns[1:], np.int64).tobytes())
        self._values.frombytes(np.ascontiguousarray(rows[1:], np.float32).tobytes())
        while len(self._t) > _STAGE:
            self._flush(_STAGE)

    def _flush(self, count):
        block = self._staged(count)
        del self._t[:count], self._values[: count * self._width]
        for _ in range(self._level):
            block = self._reduce(*block)
        self._blocks.append(block)
        self._count += len(block[0])
        while self._count > self._most:
            self._held_t, self._held = self._reduce(*self._joined())
            self._blocks.clear()
            self._count = len(self._held_t)
            self._level += 1

    def _staged(self, count):
        values = np.array(self._values[: count * self._width], np.float32)
        return np.array(self._t[:count], np.int64), values.reshape(-1, self._width)

    def _joined(self, *more):
        parts = [(self._held_t, self._held), *self._blocks, *more]
        return tuple(np.concatenate(column) for column in zip(*parts))

    def arrays(self, most: int) -> tuple[np.ndarray, np.ndarray]:
        """Return times [ns], shape (n,), and rows, shape (n, width), at most `most` of them."""
        rest = self._staged(len(self._t))
        for _ in range(self._level):
            rest = self._reduce(*rest)
        return thinned(*self._joined(rest), max(most, 4), self._reduce)  # type: ignore[call-arg]
