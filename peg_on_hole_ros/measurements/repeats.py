"""Values that repeat bit for bit while stamps go on: how often each comes."""

import numpy as np

from peg_on_hole_ros.measurements.tuned import REPEATED_VALUES
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.number_text import quantity
from peg_on_hole_ros.typed_record import Floats, Record, new


class Repeats(Record):
    """
    How often the values of a source come; all zeros: there were none yet.

    Attributes
    ----------
    run, since
        How often the present value has come, and since when [s].
    length, alike, begun
        Length of the runs before it, how many of these there were in a row, and since when [s].
    runs
        How many runs there were.
    most_length, most_alike, rate
        Of the longest row of runs of one length: that, how many, and the rate of new values [Hz].

    """

    run: int
    since: float
    length: int
    alike: int
    begun: float
    runs: int
    most_length: int
    most_alike: int
    rate: float


def new_repeats() -> Repeats:
    """Return a memory that has seen nothing."""
    return new(Repeats)


@compiled
def notice(m: Repeats, t: float, values: Floats | tuple[float, ...], latest: Floats) -> int:
    """
    Process values; return how often they have come in a row, 1: they are new.

    Parameters
    ----------
    m : Repeats
        Changed.
    t : float
        Stamp [s].
    values : ndarray or tuple
    latest : ndarray
        The values before them; changed to them.

    """
    same = m.run > 0
    for i in range(len(values)):
        same = same and latest[i] == values[i]
        latest[i] = values[i]
    if same:
        m.run += 1
        return m.run
    if m.run > 0:
        # The first run may have begun before.
        if m.run == m.length and m.runs > 1:
            m.alike += 1
        else:
            m.alike, m.begun = 1, m.since
        m.length = m.run
        most_alike = max(m.most_alike, REPEATED_VALUES.runs)
        if m.length > 1 and m.alike >= most_alike and t > m.begun:
            m.most_length, m.most_alike = m.length, m.alike
            m.rate = m.alike / (t - m.begun)
    m.run, m.since = 1, t
    m.runs += 1
    return 1


@compiled
def notice_all(memory: Repeats, t: Floats, values: Floats, latest: Floats) -> None:
    """Process rows of values, each with its stamp [s]; see `notice`."""
    for k in range(len(t)):
        notice(memory, t[k], values[k], latest)


class Runs:
    """How often each of many rows of values has come in a row."""

    def __init__(self) -> None:
        self._latest: np.ndarray | None = None
        self._run = 0

    def take(self, rows: np.ndarray) -> np.ndarray:
        """
        Process rows of values, in the order in which they came.

        Parameters
        ----------
        rows : ndarray, shape (n, values)

        Returns
        -------
        ndarray of int64, shape (n,)
            How often each has come in a row, bit for bit; 1: it differs from the one before it.

        """
        first = rows[:1] if self._latest is None else self._latest
        new = (rows != np.vstack([first, rows[:-1]])).any(axis=1)
        at = np.arange(len(rows))
        begun = np.maximum.accumulate(np.where(new, at, -1))
        runs = np.where(begun < 0, self._run + at + 1, at - begun + 1)
        if len(rows):
            self._latest, self._run = rows[-1:].copy(), int(runs[-1])
        return runs


@compiled
def held(memory: Repeats) -> int:
    """Return how many messages in a row usually have the same value; 1: each is new."""
    return memory.length if memory.alike >= REPEATED_VALUES.runs else 1


def describe(memory: Repeats) -> str:
    """Return what is reported of values that come so many times each, or nothing."""
    if not memory.most_length:
        return ""
    return (
        f"values repeat: each comes {memory.most_length} times in a row, new ones at "
        f"{quantity(memory.rate, 'Hz')}, as where a driver holds those of a slower sensor; they "
        "count as one"
    )
