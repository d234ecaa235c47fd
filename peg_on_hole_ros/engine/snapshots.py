"""Snapshots of the engine's state before wrenches of the ring, to go back to; compiled."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.engine.state import ENGINE_MEMORY_BYTES
from peg_on_hole_ros.engine.tuned import REPROCESSING
from peg_on_hole_ros.estimator.snapshot import (
    WORD,
    EstimateSnapshots,
    Words,
    restore_estimate,
    room_for_estimates,
    save_estimate,
)
from peg_on_hole_ros.estimator.state import State
from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.typed_record import Record, dtype_of

_SNAPSHOTS = (
    REPROCESSING.recent_snapshots + REPROCESSING.most_wrenches // REPROCESSING.snapshot_stride + 64
)
_NO_SNAPSHOT = -1

_BESIDE_AT, _FILTER_AT = ENGINE_MEMORY_BYTES.start // WORD, ENGINE_MEMORY_BYTES.stop // WORD


class SnapshotPlaces(Record):
    """
    Before which wrenches there are snapshots, and which of these are in no use.

    Attributes
    ----------
    appended
        Wrenches in order, of which each of a stride has one.
    alert
        So many wrenches from here on have one each.
    bare
        Wrenches without one, since one with it, behind the latest.
    unused
        Snapshots that are in no use, `Snapshots.unused[:unused]`.

    """

    appended: int
    alert: int
    bare: int
    unused: int


class Snapshots(NamedTuple):
    """
    Snapshots by the wrenches before which they are.

    Attributes
    ----------
    places : ndarray of SnapshotPlaces, shape (1,)
    number : ndarray of int64, shape (wrenches,)
        Which snapshot is that before a wrench of the ring; -1: none.
    unused : ndarray of int64, shape (snapshots,)
    beside : ndarray of int64, shape (snapshots, words)
        What the engine remembers beside the estimate.
    estimates : EstimateSnapshots

    """

    places: np.ndarray
    number: np.ndarray
    unused: np.ndarray
    beside: Words
    estimates: EstimateSnapshots


def new_snapshots(wrenches: int, state: State) -> Snapshots:
    """Return room for snapshots before so many wrenches, of an estimate by its state."""
    snapshots = Snapshots(
        places=np.zeros(1, dtype_of(SnapshotPlaces)),
        number=np.empty(wrenches, np.int64),
        unused=np.empty(_SNAPSHOTS, np.int64),
        beside=np.empty((_SNAPSHOTS, _FILTER_AT - _BESIDE_AT), np.int64),
        estimates=room_for_estimates(_SNAPSHOTS, state),
    )
    empty(snapshots)
    return snapshots


def with_room(snapshots: Snapshots, state: State) -> Snapshots:
    """Return snapshots of another estimate, by its state; `empty` them."""
    return snapshots._replace(
        beside=np.empty_like(snapshots.beside), estimates=room_for_estimates(_SNAPSHOTS, state)
    )


def empty(snapshots: Snapshots) -> None:
    """Forget all of them."""
    places = snapshots.places[0]
    places["appended"] = places["alert"] = places["bare"] = 0
    snapshots.unused[:] = np.arange(_SNAPSHOTS)
    places["unused"] = _SNAPSHOTS


def in_use(snapshots: Snapshots) -> int:
    """Return how many there are."""
    return _SNAPSHOTS - int(snapshots.places[0]["unused"])


@compiled
def has_snapshot(snapshots: Snapshots, unit: int) -> bool:
    """Return whether there is one before a wrench of the ring."""
    return snapshots.number[unit] != _NO_SNAPSHOT


@compiled
def is_due(snapshots: Snapshots) -> bool:
    """Return whether the newest wrench is to have one."""
    places = snapshots.places[0]
    return places.alert > 0 or places.appended % REPROCESSING.snapshot_stride == 0


@compiled
def count_wrench(snapshots: Snapshots) -> None:
    """Count a wrench that came in order."""
    places = snapshots.places[0]
    places.appended += 1
    places.alert -= places.alert > 0


@compiled
def begin_stride(snapshots: Snapshots) -> None:
    """Make the next wrench the first of a stride: it has a snapshot."""
    snapshots.places[0].appended = 0


@compiled
def begin_alert(snapshots: Snapshots) -> None:
    """Give each of the next wrenches a snapshot: a message was late, and others follow."""
    snapshots.places[0].alert = REPROCESSING.every_snapshot


@compiled
def clear_snapshot(snapshots: Snapshots, unit: int) -> None:
    """Mark a wrench of the ring as one without a snapshot."""
    snapshots.number[unit] = _NO_SNAPSHOT


@compiled
def save(snapshots: Snapshots, unit: int, words: Words, s: State) -> None:
    """Save the engine's memory, as words, and its estimate before a wrench, if there is room."""
    places = snapshots.places[0]
    if snapshots.number[unit] == _NO_SNAPSHOT:
        if not places.unused:
            return
        places.unused -= 1
        snapshots.number[unit] = snapshots.unused[places.unused]
    number = snapshots.number[unit]
    snapshots.beside[number] = words[_BESIDE_AT:_FILTER_AT]
    save_estimate(snapshots.estimates, number, words[_FILTER_AT:], s)


@compiled
def restore(snapshots: Snapshots, unit: int, words: Words, s: State) -> None:
    """Restore what was saved before a wrench; what follows is bit for bit what followed it."""
    number = snapshots.number[unit]
    words[_BESIDE_AT:_FILTER_AT] = snapshots.beside[number]
    restore_estimate(snapshots.estimates, number, words[_FILTER_AT:], s)


@compiled
def release(snapshots: Snapshots, unit: int) -> None:
    """Forget the snapshot before a wrench, if there is one."""
    places = snapshots.places[0]
    if snapshots.number[unit] != _NO_SNAPSHOT:
        snapshots.unused[places.unused] = snapshots.number[unit]
        places.unused += 1
        snapshots.number[unit] = _NO_SNAPSHOT


@compiled
def move(snapshots: Snapshots, unit: int, to: int) -> None:
    """Give a wrench another place in the ring."""
    snapshots.number[to] = snapshots.number[unit]


@compiled
def thin(snapshots: Snapshots, first: int, last: int) -> None:
    """Of the wrenches [first, last) leave one snapshot of a stride before the latest ones."""
    places, unit = snapshots.places[0], last - REPROCESSING.recent_snapshots - 1
    if unit <= first:
        places.bare = 0
    elif snapshots.number[unit] == _NO_SNAPSHOT or places.bare < REPROCESSING.snapshot_stride - 1:
        release(snapshots, unit)
        places.bare += 1
    else:
        places.bare = 0
