"""What becomes of a message by its stamp and by what came before it; compiled."""

from enum import IntEnum
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.engine import ring as kept
from peg_on_hole_ros.engine.ring import Ring
from peg_on_hole_ros.engine.tuned import STAMP_ORDER
from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.monitor.states import NO_STAMP
from peg_on_hole_ros.typed_record import Record, dtype_of


class Fate(IntEnum):
    """What becomes of a message by its place in the order."""

    TAKEN = 0
    LEAPS = 1  # a wrench after a silence, or one whose stamp is wrong
    TAKES_BACK = 2  # a wrench from before the one that leapt: that had a wrong stamp
    WRENCH_LATE = 3
    WRENCH_REPEATED = 4
    WRENCH_TOO_LATE = 5
    WRENCH_TOO_EARLY = 6
    WRENCH_RESTARTS = 7
    STARTS = 8
    WAITS = 9  # an orientation ahead of the wrench of its time
    WAITS_BEFORE = 10  # the same, before one that waits already
    SAME = 11  # an orientation of the last wrench's own stamp
    JOINTS_LATE = 12
    JOINTS_MOVED = 13  # where nothing is gone back to
    JOINTS_REPEATED = 14
    JOINTS_TOO_LATE = 15
    JOINTS_RESTART = 16


# What is counted of a message; of other fates nothing is.
COUNTED = {
    Fate.WRENCH_LATE: "wrench_late",
    Fate.WRENCH_REPEATED: "wrench_dropped_repeated_stamp",
    Fate.WRENCH_TOO_LATE: "wrench_dropped_late",
    Fate.WRENCH_TOO_EARLY: "wrench_dropped_before_joints",
    Fate.WRENCH_RESTARTS: "clock_jumped_back",
    Fate.WAITS_BEFORE: "joints_reordered",
    Fate.JOINTS_LATE: "joints_late",
    Fate.JOINTS_MOVED: "joints_late",
    Fate.JOINTS_REPEATED: "joints_dropped_repeated_stamp",
    Fate.JOINTS_TOO_LATE: "joints_dropped_late",
    Fate.JOINTS_RESTART: "clock_jumped_back",
}


class Order(Record):
    """
    Where the stamps of messages stand, and what of them came.

    Attributes
    ----------
    window_ns
        How late a message may be that is put in its place; 0: none is [ns].
    expected_ns
        How late orientations always are [ns].
    tolerance_ns
        How late one may be where none is put in its place [ns].
    now_ns
        Stamp that the estimate has come to; NO_STAMP: not started [ns].
    last_wrench_ns
        Of the last wrench that was taken [ns].
    newest_ns
        Of the newest orientation [ns].
    leap_ns
        Of a wrench that leapt and may be taken back [ns].
    leap_from_ns
        Stamp that the estimate had come to before that [ns].
    leap_last_ns
        Of the wrench before that [ns].
    far_wrench_ns, far_joints_ns
        Of the last message of a kind, where it was far behind [ns].
    joints, joints_first, joint_stamps
        How many recent stamps of orientations there are, the place of the first, and these in
        their order of arrival, a ring [ns].

    """

    window_ns: int
    expected_ns: int
    tolerance_ns: int
    now_ns: int
    last_wrench_ns: int
    newest_ns: int
    leap_ns: int
    leap_from_ns: int
    leap_last_ns: int
    far_wrench_ns: int
    far_joints_ns: int
    joints: int
    joints_first: int
    joint_stamps: Annotated[NDArray[np.int64], (STAMP_ORDER.most_joint_stamps,)]


def new_order(configuration: Configuration) -> np.ndarray:
    """Return the order before the first message, an array of one `Order`, shape (1,)."""
    memory = np.zeros(1, dtype_of(Order))
    order, kalman = memory[0], configuration.filter
    order["expected_ns"] = max(round(configuration.joints.delay * 1e9), 0)
    window_ns = round(kalman.late_window * 1e9)
    order["window_ns"] = window_ns and window_ns + order["expected_ns"]
    order["tolerance_ns"] = round(kalman.late_tolerance * 1e9)
    restart(order)
    return memory


def restart(order: np.void) -> None:
    """Forget every stamp."""
    for name in ("now", "last_wrench", "newest", "far_wrench", "far_joints"):
        order[f"{name}_ns"] = NO_STAMP
    order["leap_ns"] = NO_STAMP
    order["joints"] = 0


@compiled
def take_back(order: Order) -> None:
    """Undo a wrench that leapt."""
    order.now_ns, order.last_wrench_ns = order.leap_from_ns, order.leap_last_ns
    order.leap_ns = NO_STAMP


@compiled
def fate_of_wrench(o: Order, ring: Ring, t_ns: int) -> Fate:
    """Decide what becomes of a wrench of a stamp [ns], and record it."""
    fate = _of_wrench(o, ring, ring.places[0], t_ns)
    _note_wrench(o, fate, t_ns)
    return fate


@compiled
def fate_of_joints(o: Order, ring: Ring, t_ns: int) -> Fate:
    """Decide what becomes of an orientation of a stamp [ns], and record it."""
    fate = _of_joints(o, ring, ring.places[0], t_ns)
    _note_joints(o, ring.places[0], fate, t_ns)
    return fate


@compiled
def _far(o, t_ns):
    return o.now_ns - t_ns > STAMP_ORDER.clock_jump_ns


@compiled
def _of_wrench(o, ring, r, t_ns):
    if o.now_ns == NO_STAMP:
        return Fate.WRENCH_TOO_EARLY
    if t_ns == o.last_wrench_ns:
        return Fate.WRENCH_REPEATED
    leapt = o.leap_ns != NO_STAMP and t_ns < o.now_ns
    if leapt and o.leap_from_ns < t_ns < (o.leap_from_ns + o.leap_ns) // 2:
        return Fate.TAKES_BACK
    if _far(o, t_ns):
        # One alone is a message whose stamp was not set, or of another clock.
        again = o.far_wrench_ns != NO_STAMP and t_ns > o.far_wrench_ns
        return Fate.WRENCH_RESTARTS if again else Fate.WRENCH_TOO_LATE
    if t_ns < o.now_ns:
        if o.now_ns - t_ns > o.window_ns:
            return Fate.WRENCH_TOO_LATE
        if kept.has_wrench(ring, r, t_ns):
            return Fate.WRENCH_REPEATED
        return Fate.WRENCH_LATE if kept.reaches(r, t_ns) else Fate.WRENCH_TOO_LATE
    return Fate.LEAPS if 0 < o.window_ns < t_ns - o.now_ns else Fate.TAKEN


@compiled
def _note_wrench(o, fate, t_ns):
    if fate == Fate.WRENCH_TOO_EARLY or fate == Fate.TAKES_BACK or t_ns == o.last_wrench_ns:
        return
    o.far_wrench_ns = t_ns if _far(o, t_ns) else NO_STAMP
    if fate == Fate.WRENCH_LATE:
        o.leap_ns = NO_STAMP
    elif fate == Fate.TAKEN or fate == Fate.LEAPS:
        o.leap_ns = t_ns if fate == Fate.LEAPS else NO_STAMP
        o.leap_from_ns, o.leap_last_ns = o.now_ns, o.last_wrench_ns
        o.now_ns = o.last_wrench_ns = t_ns


@compiled
def _of_joints(o, ring, r, t_ns):
    if o.now_ns == NO_STAMP:
        return Fate.STARTS
    if o.now_ns - t_ns - o.expected_ns > STAMP_ORDER.clock_jump_ns:
        again = o.far_joints_ns != NO_STAMP and t_ns > o.far_joints_ns
        return Fate.JOINTS_RESTART if again else Fate.JOINTS_TOO_LATE
    if _came(o, t_ns):
        return Fate.JOINTS_REPEATED
    if t_ns > o.now_ns:
        begin = kept.waiting_from(ring, r)
        before = r.joints_last > begin and t_ns < ring.joint_ns[r.joints_last - 1]
        return Fate.WAITS_BEFORE if before else Fate.WAITS
    late_ns = o.now_ns - t_ns
    if not late_ns:
        return Fate.SAME
    if o.window_ns:
        placed = late_ns <= o.window_ns and kept.reaches(r, t_ns)
        return Fate.JOINTS_LATE if placed else Fate.JOINTS_TOO_LATE
    near = late_ns - o.expected_ns <= o.tolerance_ns
    return Fate.JOINTS_MOVED if near else Fate.JOINTS_TOO_LATE


@compiled
def _came(o, t_ns):
    """Return whether an orientation of a stamp came already; forget what is too old to matter."""
    reach_ns = max(o.window_ns, o.tolerance_ns + o.expected_ns)
    oldest_ns = o.now_ns - reach_ns
    most = STAMP_ORDER.most_joint_stamps
    while o.joints and (o.joint_stamps[o.joints_first] < oldest_ns or o.joints >= most):
        o.joints_first = (o.joints_first + 1) % most
        o.joints -= 1
    return t_ns <= o.newest_ns and _among(o.joint_stamps, o.joints_first, o.joints, t_ns)


@compiled
def _among(stamps, first, count, t_ns):
    found = False
    for i in range(count):
        found |= stamps[(first + i) % STAMP_ORDER.most_joint_stamps] == t_ns
    return found


@compiled
def _note_joints(o, r, fate, t_ns):
    if fate == Fate.JOINTS_RESTART:
        return
    if fate == Fate.STARTS:
        o.now_ns = r.kept_from_ns = t_ns
    elif o.now_ns - t_ns - o.expected_ns > STAMP_ORDER.clock_jump_ns:
        o.far_joints_ns = t_ns
        return
    o.far_joints_ns = NO_STAMP
    if fate == Fate.JOINTS_REPEATED:
        return
    o.joint_stamps[(o.joints_first + o.joints) % STAMP_ORDER.most_joint_stamps] = t_ns
    o.joints += 1
    o.newest_ns = max(o.newest_ns, t_ns)
    if fate == Fate.JOINTS_LATE and t_ns <= o.leap_from_ns:
        o.leap_ns = NO_STAMP
