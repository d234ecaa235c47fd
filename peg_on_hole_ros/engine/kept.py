"""States of the engine that are kept on the way, to go back to."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.engine.state import BESIDE, ENGINE
from peg_on_hole_ros.estimator.kept import (
    WORD,
    KeptEstimates,
    keep_estimate,
    put_estimate_back,
    room_for_estimates,
)
from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.record_types import StateRecord

_HELD = ENGINE.fields["held"][1] // WORD  # type: ignore[index]
_BEGIN, _END = BESIDE.start // WORD, BESIDE.stop // WORD


class Kept(NamedTuple):
    """
    Room for states; of many, that before wrench i stands in place i modulo the number of places.

    Attributes
    ----------
    beside : ndarray of int64, shape (places, words)
        What the engine remembers beside the estimate.
    estimates : KeptEstimates

    """

    beside: np.ndarray
    estimates: KeptEstimates

    def of(self, place: int) -> "Kept":
        """Return one of the states alone."""
        one = slice(place, place + 1)
        estimate = KeptEstimates(*(each[one].copy() for each in self.estimates))
        return Kept(self.beside[one].copy(), estimate)


def room(places: int, state: np.void) -> Kept:
    """Return room for so many states of an estimate, which is a record of STATE."""
    beside = np.empty((places, _END - _BEGIN), np.int64)
    return Kept(beside, room_for_estimates(places, state))


@compiled
def keep(kept: Kept, place: int, words: np.ndarray, s: StateRecord) -> None:
    """Keep what the engine's memory, as words, and its estimate say."""
    kept.beside[place] = words[_BEGIN:_END]
    keep_estimate(kept.estimates, place, words[_HELD:], s)


@compiled
def go_back(kept: Kept, place: int, words: np.ndarray, s: StateRecord) -> None:
    """Put what was kept into the engine's memory; what follows is bit for bit what followed it."""
    words[_BEGIN:_END] = kept.beside[place]
    put_estimate_back(kept.estimates, place, words[_HELD:], s)


@compiled
def keep_now(kept: Kept, memory: np.ndarray, words: np.ndarray) -> None:
    """Keep what an array of ENGINE, shape (1,), and as words, says now, as the only state."""
    keep(kept, 0, words, memory[0].held.state)


@compiled
def put_back(kept: Kept, memory: np.ndarray, words: np.ndarray) -> None:
    """Put the only state that was kept into an array of ENGINE, shape (1,), and as words."""
    go_back(kept, 0, words, memory[0].held.state)
