"""Snapshots of an estimate, to go back to."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.state import State
from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.typed_record import Floats, dtype_of

# Memory is copied in words of 8 bytes.
WORD = 8
Words = NDArray[np.int64]


def offset_of(record: np.dtype[np.void], field: str) -> int:
    """Return where a field of a record begins, in words."""
    fields = record.fields
    assert fields is not None
    return fields[field][1] // WORD


# What changes beside the components.
_BEGIN = offset_of(dtype_of(FilterRecord), "noise")
_END = offset_of(dtype_of(FilterRecord), "state") + offset_of(dtype_of(State), "x")


class EstimateSnapshots(NamedTuple):
    """
    Room for snapshots of an estimate, by their numbers.

    Attributes
    ----------
    beside : ndarray of int64, shape (snapshots, words)
        The estimate without its components.
    x, P : ndarray
        Of the components, see `estimator.state.State`; filled in where they are alive.

    """

    beside: Words
    x: Floats
    P: Floats


def room_for_estimates(snapshots: int, state: State) -> EstimateSnapshots:
    """Return room for so many snapshots of an estimate with a state of such sizes."""
    m, w = int(state.components), int(state.width)
    beside = np.empty((snapshots, _END - _BEGIN), np.int64)
    return EstimateSnapshots(beside, np.empty((snapshots, m, w)), np.empty((snapshots, m, w, w)))


@compiled
def save_estimate(snapshots: EstimateSnapshots, number: int, words: Words, state: State) -> None:
    """Save an estimate, as the words of its FilterRecord and its state."""
    snapshots.beside[number] = words[_BEGIN:_END]
    w, modes = state.width, state.components // max(state.hypotheses, 1)
    for c in range(state.components):
        if state.alive[c // modes] > 0.0:
            for i in range(w):
                snapshots.x[number, c, i] = state.x[c, i]
                for j in range(w):
                    snapshots.P[number, c, i, j] = state.P[c, i, j]


@compiled
def restore_estimate(
    snapshots: EstimateSnapshots, number: int, words: Words, state: State
) -> None:
    """Restore an estimate that was saved; what follows is bit for bit what followed it."""
    words[_BEGIN:_END] = snapshots.beside[number]
    w, modes = state.width, state.components // max(state.hypotheses, 1)
    for c in range(state.components):
        if state.alive[c // modes] > 0.0:
            for i in range(w):
                state.x[c, i] = snapshots.x[number, c, i]
                for j in range(w):
                    state.P[c, i, j] = snapshots.P[number, c, i, j]
