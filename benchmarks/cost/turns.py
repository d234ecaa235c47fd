"""Ways to do a thing, timed in turns: a busy machine slows all of them alike."""

from collections.abc import Callable
from statistics import median
from time import process_time
from typing import Any, NamedTuple


class Turns(NamedTuple):
    """
    What each way took.

    Attributes
    ----------
    seconds : dict of str to list of float
        Of each turn, by way.
    results : dict of str
        What each way returned in the last turn.

    """

    seconds: dict[str, list[float]]
    results: dict[str, Any]

    def least(self, name: str) -> float:
        """Return the shortest time of a way [s]."""
        return min(self.seconds[name])

    def median(self, name: str) -> float:
        """Return the median time of a way [s]."""
        return median(self.seconds[name])


def in_turns(
    ways: dict[str, Callable[[], Any]],
    count: int,
    clock: Callable[[], float] = process_time,
    before: Callable[[str], None] = lambda name: None,
) -> Turns:
    """
    Go so many turns through all ways.

    Parameters
    ----------
    ways : dict of str to callable
    count : int
    clock : callable
        Returns a time [s]: the processor's, or the wall clock's.
    before : callable
        Is given the name of the way that is next, and not timed.

    """
    seconds: dict[str, list[float]] = {name: [] for name in ways}
    results = {}
    for _ in range(count):
        for name, way in ways.items():
            before(name)
            begun = clock()
            results[name] = way()
            seconds[name].append(clock() - begun)
    return Turns(seconds, results)
