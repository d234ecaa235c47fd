"""States of the engine that are kept on the way, one before each wrench, to go back to."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.engine.state import BESIDE, ENGINE
from peg_on_hole_ros.estimator.held import KEPT
from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.record_types import StateRecord

# The engine's memory in words of 8 bytes, and what of it is kept beside the components.
WORD = 8
_HELD = ENGINE.fields["held"][1]  # type: ignore[index]
_BESIDE = slice(BESIDE.start // WORD, BESIDE.stop // WORD)
_ESTIMATE = slice((_HELD + KEPT.start) // WORD, (_HELD + KEPT.stop) // WORD)


class Kept(NamedTuple):
    """
    Room for states; that before wrench i stands in place i modulo the number of places.

    Attributes
    ----------
    beside, estimate : ndarray of int64
        What the engine remembers, and the estimate without its components.
    x, P : ndarray
        Of the components, see `estimator.state.State`.

    """

    beside: np.ndarray
    estimate: np.ndarray
    x: np.ndarray
    P: np.ndarray


def room(places: int, state: np.void) -> Kept:
    """Return room for so many states of an estimate, which is a record of STATE."""
    m, w = int(state["components"]), int(state["width"])
    return Kept(
        np.empty((places, _BESIDE.stop - _BESIDE.start), np.int64),
        np.empty((places, _ESTIMATE.stop - _ESTIMATE.start), np.int64),
        np.empty((places, m, w)),
        np.empty((places, m, w, w)),
    )


@compiled
def keep(kept: Kept, place: int, words: np.ndarray, s: StateRecord) -> None:
    """Keep what the engine's memory, as words, and its estimate say."""
    kept.beside[place] = words[_BESIDE]
    kept.estimate[place] = words[_ESTIMATE]
    w, levels = s.width, s.components // max(s.frictions, 1)
    for c in range(s.components):
        if s.alive[c // levels] > 0.0:
            for i in range(w):
                kept.x[place, c, i] = s.x[c, i]
                for j in range(w):
                    kept.P[place, c, i, j] = s.P[c, i, j]


@compiled
def go_back(kept: Kept, place: int, words: np.ndarray, s: StateRecord) -> None:
    """Put what was kept into the engine's memory; what follows is bit for bit what followed it."""
    words[_BESIDE] = kept.beside[place]
    words[_ESTIMATE] = kept.estimate[place]
    w, levels = s.width, s.components // max(s.frictions, 1)
    for c in range(s.components):
        if s.alive[c // levels] > 0.0:
            for i in range(w):
                s.x[c, i] = kept.x[place, c, i]
                for j in range(w):
                    s.P[c, i, j] = kept.P[place, c, i, j]
