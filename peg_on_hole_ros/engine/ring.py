"""
The latest wrenches and orientations in the order of their stamps.

A late message is put where its stamp belongs, and everything since is processed again from the
last snapshot before it. Compiled: the whole of it is arrays.
"""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from peg_on_hole_ros.engine import snapshots
from peg_on_hole_ros.engine.snapshots import Snapshots
from peg_on_hole_ros.engine.state import ORIENTATION_WIDTH
from peg_on_hole_ros.engine.tuned import REPROCESSING, TARE
from peg_on_hole_ros.estimator.state import State
from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.monitor.states import NO_STAMP
from peg_on_hole_ros.typed_record import Floats, Record, dtype_of

# Rows that there is room for; what is in use moves to the front when the end is reached.
_UNITS = 2 * REPROCESSING.most_wrenches + 4096
_ORIENTATIONS = REPROCESSING.room_for_orientations
_NONE = -1


class RingPlaces(Record):
    """
    Where things stand in the arrays of a Ring.

    Attributes
    ----------
    first, last
        The oldest wrench, and one behind the newest.
    done
        Wrenches before it have been processed.
    restored : bool
        Whether the estimate is that of the snapshot before `done`.
    changed
        First wrench that a late message reached; -1: none.
    late_wrenches, late_joints
        Put in their place and not yet processed.
    kept_from_ns
        What is not after it has no place here [ns].
    joints_first, joints_last
        The oldest orientation, and one behind the newest, those that wait among them.
    measured_ns, measured : int, shape (ORIENTATION_WIDTH,)
        The newest orientation whose time has come [ns].
    recent, recent_ns, recent_wrenches
        Wrenches in a row, the latest of which are at hand: how many, stamps [ns], values.
    went_back
        How often the estimate went back.
    reprocessed
        Wrenches that were processed again.
    without_wrench
        Orientations that waited in vain.
    ahead
        Wrenches that were taken back.

    """

    first: int
    last: int
    done: int
    restored: bool
    changed: int
    late_wrenches: int
    late_joints: int
    kept_from_ns: int
    joints_first: int
    joints_last: int
    measured_ns: int
    measured: Annotated[Floats, (ORIENTATION_WIDTH,)]
    recent: int
    recent_ns: Annotated[NDArray[np.int64], (TARE.most_recent,)]
    recent_wrenches: Annotated[Floats, (TARE.most_recent, 6)]
    went_back: int
    reprocessed: int
    without_wrench: int
    ahead: int


class Ring(NamedTuple):
    """
    Wrenches and orientations by their stamps.

    Attributes
    ----------
    places : ndarray of RingPlaces, shape (1,)
    t_ns : ndarray of int64, shape (wrenches,)
        Stamps [ns].
    wrenches : ndarray, shape (wrenches, 6)
        As received [N], [N m].
    before : ndarray of int64, shape (wrenches,)
        End of the orientations that are processed before each wrench; they begin where those of
        the wrench before it end.
    after : ndarray of int64, shape (wrenches,)
        End of those that came with a wrench's own stamp behind it.
    joint_ns : ndarray of int64, shape (orientations,)
        Stamps; those behind the newest wrench wait for the next one [ns].
    orientations : ndarray, shape (orientations, ORIENTATION_WIDTH)
    snapshots : Snapshots
        Before each wrench.

    """

    places: np.ndarray
    t_ns: np.ndarray
    wrenches: np.ndarray
    before: np.ndarray
    after: np.ndarray
    joint_ns: np.ndarray
    orientations: np.ndarray
    snapshots: Snapshots


class Unit(NamedTuple):
    """
    One wrench with its orientations, each with its stamp [ns] and as a row of ORIENTATION_WIDTH.

    Attributes
    ----------
    t_ns : int
        Its stamp [ns].
    wrench : ndarray, shape (6,)
    before, after : list of (int, ndarray)
        Those that are processed before it, and those of its own stamp behind it.

    """

    t_ns: int
    wrench: np.ndarray
    before: list[tuple[int, np.ndarray]]
    after: list[tuple[int, np.ndarray]]


def new_ring(state: State) -> Ring:
    """Return an empty ring for an estimate, by its state."""
    # What is never written to takes no memory.
    places = np.zeros(1, dtype_of(RingPlaces))
    places["changed"] = _NONE
    places["measured_ns"] = places["kept_from_ns"] = NO_STAMP
    return Ring(
        places=places,
        t_ns=np.empty(_UNITS, np.int64),
        wrenches=np.empty((_UNITS, 6)),
        before=np.empty(_UNITS, np.int64),
        after=np.empty(_UNITS, np.int64),
        joint_ns=np.empty(_ORIENTATIONS, np.int64),
        orientations=np.empty((_ORIENTATIONS, ORIENTATION_WIDTH)),
        snapshots=snapshots.new_snapshots(_UNITS, state),
    )


def with_room(ring: Ring, state: State) -> Ring:
    """Return a ring for another estimate, by its state; `empty` it."""
    return ring._replace(snapshots=snapshots.with_room(ring.snapshots, state))


def empty(ring: Ring, from_ns: int) -> None:
    """Forget all but the orientations that wait; nothing up to a stamp [ns] is gone back to."""
    r = ring.places[0]
    r["kept_from_ns"] = from_ns
    r["joints_first"] = begin_of_waiting(ring)
    r["first"] = r["last"] = r["done"] = r["restored"] = 0
    r["changed"], r["late_wrenches"], r["late_joints"] = _NONE, 0, 0
    snapshots.empty(ring.snapshots)


def restart(ring: Ring) -> None:
    """Forget the orientations that wait, too, and which wrenches came last."""
    empty(ring, NO_STAMP)
    r = ring.places[0]
    r["joints_first"] = r["joints_last"] = r["recent"] = 0
    r["measured_ns"] = NO_STAMP


def begin_of_waiting(ring: Ring) -> int:
    """Return the place of the first orientation that waits."""
    r = ring.places[0]
    return int(ring.after[r["last"] - 1] if r["last"] > r["first"] else r["joints_first"])


def recent(ring: Ring) -> tuple[np.ndarray, np.ndarray]:
    """Return stamps [ns] and the wrenches (n, 6) that came last, at most `TARE.most_recent`."""
    r = ring.places[0]
    most, end = TARE.most_recent, int(r["recent"])
    at = np.arange(max(end - most, 0), end) % most
    return r["recent_ns"][at], r["recent_wrenches"][at]


def unit_of(ring: Ring, unit: int) -> Unit:
    """Return a wrench by its place."""
    r = ring.places[0]
    begin = int(ring.after[unit - 1] if unit > r["first"] else r["joints_first"])
    end = int(ring.before[unit])
    before, after = slice(begin, end), slice(end, int(ring.after[unit]))
    return Unit(
        int(ring.t_ns[unit]),
        ring.wrenches[unit],
        list(zip(ring.joint_ns[before].tolist(), ring.orientations[before])),
        list(zip(ring.joint_ns[after].tolist(), ring.orientations[after])),
    )


@compiled
def waiting_from(ring: Ring, r: RingPlaces) -> int:
    """Return what `begin_of_waiting` does."""
    return ring.after[r.last - 1] if r.last > r.first else r.joints_first


@compiled
def joints_from(ring: Ring, r: RingPlaces, unit: int) -> int:
    """Return where the orientations of a wrench begin."""
    return ring.after[unit - 1] if unit > r.first else r.joints_first


@compiled
def note_measured(r: RingPlaces, t_ns: int, orientation: np.ndarray) -> None:
    """Record an orientation whose time has come, if it is the newest."""
    if r.measured_ns == NO_STAMP or t_ns > r.measured_ns:
        r.measured_ns = t_ns
        for i in range(ORIENTATION_WIDTH):
            r.measured[i] = orientation[i]


@compiled
def note_recent(r: RingPlaces, t_ns: int, wrench: np.ndarray) -> None:
    """Record a wrench that came in order."""
    at = r.recent % TARE.most_recent
    r.recent_ns[at] = t_ns
    for i in range(6):
        r.recent_wrenches[at, i] = wrench[i]
    r.recent += 1


@compiled
def put_waiting(ring: Ring, r: RingPlaces, t_ns: int, orientation: np.ndarray) -> None:
    """Keep an orientation for the wrench of its time."""
    _make_room(ring, r)
    begin = waiting_from(ring, r)
    at = r.joints_last
    while at > begin and ring.joint_ns[at - 1] > t_ns:
        at -= 1
    _insert_orientation(ring, r, at, t_ns, orientation)
    begin = waiting_from(ring, r)
    if r.joints_last - begin > REPROCESSING.most_waiting:
        for k in range(begin, r.joints_last - 1):
            ring.joint_ns[k] = ring.joint_ns[k + 1]
            ring.orientations[k] = ring.orientations[k + 1]
        r.joints_last -= 1
        r.without_wrench += 1


@compiled
def put_behind(ring: Ring, r: RingPlaces, t_ns: int, orientation: np.ndarray) -> None:
    """Keep an orientation of the newest wrench's own stamp, which came behind it."""
    _make_room(ring, r)
    if r.joints_last >= _ORIENTATIONS:
        # Where it is not used at once, it is lost.
        r.without_wrench += r.changed >= 0
    elif r.last > r.first and ring.t_ns[r.last - 1] == t_ns:
        _insert_orientation(ring, r, ring.after[r.last - 1], t_ns, orientation)
        ring.after[r.last - 1] += 1
        r.late_joints += r.changed >= 0


@compiled
def put_late_orientation(ring: Ring, r: RingPlaces, t_ns: int, orientation: np.ndarray) -> None:
    """
    Put an orientation before the first wrench whose stamp it does not exceed.

    Where as many as may wait for a wrench are there already, it is dropped, and counted as they
    are: no wrench between them would say when to forget them.
    """
    _make_room(ring, r)
    unit = _place_of(ring, r, t_ns)
    at, begin = ring.before[unit], joints_from(ring, r, unit)
    if at - begin >= REPROCESSING.most_waiting or r.joints_last >= _ORIENTATIONS:
        r.without_wrench += 1
        return
    while at > begin and ring.joint_ns[at - 1] > t_ns:
        at -= 1
    _insert_orientation(ring, r, at, t_ns, orientation)
    ring.before[unit] += 1
    for k in range(unit, r.last):
        ring.after[k] += 1
    for k in range(unit + 1, r.last):
        ring.before[k] += 1
    _change(ring, r, unit)
    r.late_joints += 1


@compiled
def put_late_wrench(ring: Ring, r: RingPlaces, t_ns: int, wrench: np.ndarray) -> None:
    """Put a wrench where its stamp belongs."""
    _make_room(ring, r)
    unit = _place_of(ring, r, t_ns)
    begin = joints_from(ring, r, unit)
    end = begin
    while end < ring.before[unit] and ring.joint_ns[end] <= t_ns:
        end += 1
    for k in range(r.last, unit, -1):
        ring.t_ns[k], ring.before[k], ring.after[k] = (
            ring.t_ns[k - 1], ring.before[k - 1], ring.after[k - 1],
        )  # fmt: skip
        snapshots.move(ring.snapshots, k - 1, k)
        ring.wrenches[k] = ring.wrenches[k - 1]
    # The snapshot before the later one is that before this one.
    snapshots.clear_snapshot(ring.snapshots, unit + 1)
    ring.t_ns[unit], ring.before[unit], ring.after[unit] = t_ns, end, end
    for i in range(6):
        ring.wrenches[unit, i] = wrench[i]
    r.last += 1
    r.done += 1
    if r.changed >= unit:
        r.changed += 1
    _change(ring, r, unit)
    r.late_wrenches += 1
    snapshots.thin(ring.snapshots, r.first, r.last)


@compiled
def append_wrench(ring: Ring, r: RingPlaces, t_ns: int, wrench: np.ndarray) -> None:
    """Put the newest wrench behind all others, with the orientations that waited for it."""
    _make_room(ring, r)
    unit, end = r.last, due_until(ring, r, t_ns)
    ring.t_ns[unit], ring.before[unit], ring.after[unit] = t_ns, end, end
    snapshots.clear_snapshot(ring.snapshots, unit)
    for i in range(6):
        ring.wrenches[unit, i] = wrench[i]
    r.last += 1


@compiled
def settle(ring: Ring, r: RingPlaces, window_ns: int) -> None:
    """Forget what no late message needs, once the newest wrench has been processed."""
    if not window_ns:
        _drop(ring, r, r.last)
        snapshots.begin_stride(ring.snapshots)
        return
    snapshots.count_wrench(ring.snapshots)
    snapshots.thin(ring.snapshots, r.first, r.last)
    oldest_ns = ring.t_ns[r.last - 1] - window_ns
    if not snapshots.has_snapshot(ring.snapshots, r.last - 1):
        return
    # What is kept begins with a snapshot.
    while True:
        unit = r.first + 1
        while unit < r.last and not snapshots.has_snapshot(ring.snapshots, unit):
            unit += 1
        crowded = r.last - unit >= REPROCESSING.most_wrenches
        if unit == r.last or not (crowded or ring.t_ns[unit - 1] < oldest_ns):
            return
        _drop(ring, r, unit)


@compiled
def rewind(ring: Ring, r: RingPlaces, words: np.ndarray, s: State) -> None:
    """Go back to the last snapshot before the first wrench that a late message has reached."""
    if r.changed < 0:
        return
    r.went_back += 1
    r.reprocessed += r.last - r.changed
    unit = r.changed
    while unit > r.first and not snapshots.has_snapshot(ring.snapshots, unit):
        unit -= 1
    r.changed, r.late_wrenches, r.late_joints = _NONE, 0, 0
    r.done, r.restored = unit, True
    snapshots.restore(ring.snapshots, unit, words, s)


@compiled
def take_back(ring: Ring, r: RingPlaces, words: np.ndarray, s: State) -> None:
    """Undo the newest wrench, which has a snapshot; its orientations wait again."""
    unit = r.last - 1
    snapshots.restore(ring.snapshots, unit, words, s)
    snapshots.release(ring.snapshots, unit)
    r.last = r.done = unit
    r.restored, r.changed, r.late_wrenches, r.late_joints = False, _NONE, 0, 0
    if r.first == r.last:
        # What is kept begins with a snapshot.
        snapshots.begin_stride(ring.snapshots)
    r.recent -= 1
    r.ahead += 1


@compiled
def due_until(ring: Ring, r: RingPlaces, t_ns: int) -> int:
    """Return the end of the orientations that wait and are not after a stamp [ns]."""
    end = waiting_from(ring, r)
    while end < r.joints_last and ring.joint_ns[end] <= t_ns:
        end += 1
    return end


@compiled
def reaches(r: RingPlaces, t_ns: int) -> bool:
    """Return whether what is kept reaches back to before a stamp [ns]."""
    return r.last > r.first and t_ns > r.kept_from_ns


@compiled
def has_wrench(ring: Ring, r: RingPlaces, t_ns: int) -> bool:
    """Return whether there is a wrench of a stamp [ns]."""
    unit = _first_from(ring, r, t_ns)
    return unit < r.last and ring.t_ns[unit] == t_ns


@compiled
def _first_from(ring, r, t_ns):
    """Return the first wrench of a stamp, or of one after it."""
    low, high = r.first, r.last
    while low < high:
        middle = (low + high) // 2
        if ring.t_ns[middle] < t_ns:
            low = middle + 1
        else:
            high = middle
    return low


@compiled
def _place_of(ring, r, t_ns):
    return min(_first_from(ring, r, t_ns), r.last - 1)


@compiled
def _change(ring, r, unit):
    r.changed = unit if r.changed < 0 else min(r.changed, unit)
    snapshots.begin_alert(ring.snapshots)


@compiled
def _insert_orientation(ring, r, at, t_ns, orientation):
    for k in range(r.joints_last, at, -1):
        ring.joint_ns[k] = ring.joint_ns[k - 1]
        ring.orientations[k] = ring.orientations[k - 1]
    ring.joint_ns[at] = t_ns
    for i in range(ORIENTATION_WIDTH):
        ring.orientations[at, i] = orientation[i]
    r.joints_last += 1


@compiled
def _make_room(ring, r):
    """Move all that is kept to the front of the arrays, where they are full."""
    if r.last < _UNITS and r.joints_last < _ORIENTATIONS:
        return
    if r.joints_last - r.joints_first > _ORIENTATIONS // 2:
        _forget_half(ring, r)
    by, joints_by = r.first, r.joints_first
    for k in range(r.first, r.last):
        ring.t_ns[k - by] = ring.t_ns[k]
        snapshots.move(ring.snapshots, k, k - by)
        ring.before[k - by] = ring.before[k] - joints_by
        ring.after[k - by] = ring.after[k] - joints_by
        ring.wrenches[k - by] = ring.wrenches[k]
    for k in range(r.joints_first, r.joints_last):
        ring.joint_ns[k - joints_by] = ring.joint_ns[k]
        ring.orientations[k - joints_by] = ring.orientations[k]
    r.first, r.last, r.done = 0, r.last - by, r.done - by
    r.changed = r.changed - by if r.changed >= 0 else _NONE
    r.joints_first, r.joints_last = 0, r.joints_last - joints_by


@compiled
def _forget_half(ring, r):
    """Forget older wrenches, for the orientations that come with them, as far as none is late."""
    end = r.changed if r.changed >= 0 else r.done
    found = r.first
    for unit in range(r.first + 1, end):
        if (
            snapshots.has_snapshot(ring.snapshots, unit)
            and 4 * (r.joints_last - ring.after[unit - 1]) >= _ORIENTATIONS
        ):
            found = unit
    _drop(ring, r, found)


@compiled
def _drop(ring, r, unit):
    """Forget the wrenches before one."""
    for k in range(r.first, unit):
        snapshots.release(ring.snapshots, k)
    if unit > r.first:
        r.joints_first = ring.after[unit - 1]
        r.kept_from_ns = max(r.kept_from_ns, ring.t_ns[unit - 1])
    r.first = unit
