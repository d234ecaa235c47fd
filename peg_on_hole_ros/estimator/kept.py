"""States of an estimate that are kept, to go back to."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimator.held import HELD
from peg_on_hole_ros.estimator.state import STATE
from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.record_types import StateRecord

# Memory is copied in words of 8 bytes.
WORD = 8
_FIELDS, _STATE = HELD.fields, STATE.fields
# What changes beside the components.
_BEGIN = _FIELDS["noise"][1] // WORD  # type: ignore[index]
_END = (_FIELDS["state"][1] + _STATE["x"][1]) // WORD  # type: ignore[index]


class KeptEstimates(NamedTuple):
    """
    Room for states of an estimate, by their places.

    Attributes
    ----------
    beside : ndarray of int64, shape (places, words)
        The estimate without its components.
    x, P : ndarray
        Of the components, see `estimator.state.State`; filled in where they are alive.

    """

    beside: np.ndarray
    x: np.ndarray
    P: np.ndarray


def room_for_estimates(places: int, state: np.void) -> KeptEstimates:
    """Return room for so many states of an estimate, which is a record of STATE."""
    m, w = int(state["components"]), int(state["width"])
    beside = np.empty((places, _END - _BEGIN), np.int64)
    return KeptEstimates(beside, np.empty((places, m, w)), np.empty((places, m, w, w)))


@compiled
def keep_estimate(kept: KeptEstimates, place: int, words: np.ndarray, s: StateRecord) -> None:
    """Keep an estimate, as the words of HELD and its record of STATE."""
    kept.beside[place] = words[_BEGIN:_END]
    w, levels = s.width, s.components // max(s.frictions, 1)
    for c in range(s.components):
        if s.alive[c // levels] > 0.0:
            for i in range(w):
                kept.x[place, c, i] = s.x[c, i]
                for j in range(w):
                    kept.P[place, c, i, j] = s.P[c, i, j]


@compiled
def put_estimate_back(kept: KeptEstimates, place: int, words: np.ndarray, s: StateRecord) -> None:
    """Put back an estimate that was kept; what follows is bit for bit what followed it."""
    words[_BEGIN:_END] = kept.beside[place]
    w, levels = s.width, s.components // max(s.frictions, 1)
    for c in range(s.components):
        if s.alive[c // levels] > 0.0:
            for i in range(w):
                s.x[c, i] = kept.x[place, c, i]
                for j in range(w):
                    s.P[c, i, j] = kept.P[place, c, i, j]
