"""What becomes of a message by its stamp and by what came before it; compiled."""

from collections import namedtuple
from typing import Any

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.engine import ring as kept
from peg_on_hole_ros.engine.ring import Ring
from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.monitor.states import NO_STAMP
from peg_on_hole_ros.record_types import OrderRecord

# A stamp this far behind is a clock that was set back or a bag played again, not a late message.
CLOCK_JUMP_NS = 1_000_000_000
# Stamps of joint states that are kept at most: of 1.5 s, the longest reach, at 5 kHz.
MAX_STAMPS = 8192

# Name and what is counted of a message where its place in the order decides that.
FATES = (
    ("taken", ""),
    ("leaps", ""),  # a wrench after a silence, or one whose stamp is wrong
    ("takes_back", ""),  # a wrench from before the one that leapt: that had a wrong stamp
    ("wrench_late", "wrench_late"),
    ("wrench_repeated", "wrench_dropped_repeated_stamp"),
    ("wrench_too_late", "wrench_dropped_late"),
    ("wrench_too_early", "wrench_dropped_before_joints"),
    ("wrench_restarts", "clock_jumped_back"),
    ("starts", ""),
    ("waits", ""),  # an orientation ahead of the wrench of its time
    ("waits_before", "joints_reordered"),  # the same, before one that waits already
    ("same", ""),  # an orientation of the last wrench's own stamp
    ("joints_late", "joints_late"),
    ("joints_moved", "joints_late"),  # where nothing is gone back to
    ("joints_repeated", "joints_dropped_repeated_stamp"),
    ("joints_too_late", "joints_dropped_late"),
    ("joints_restart", "clock_jumped_back"),
)
FATE: Any = namedtuple("FATE", [name for name, _ in FATES])(*range(len(FATES)))
COUNTED = tuple(counted for _, counted in FATES)

# Where the stamps of messages stand, and what of them came.
ORDER = np.dtype(
    [
        ("window_ns", "i8"),  # how late a message may be that is put in its place; 0: none is [ns]
        ("expected_ns", "i8"),  # how late orientations always are [ns]
        ("tolerance_ns", "i8"),  # how late one may be where none is put in its place [ns]
        ("now_ns", "i8"),  # stamp that the estimate has come to; NO_STAMP: not started [ns]
        ("last_wrench_ns", "i8"),  # of the last wrench that was taken [ns]
        ("newest_ns", "i8"),  # of the newest orientation [ns]
        ("leap_ns", "i8"),  # of a wrench that leapt and may be taken back [ns]
        ("leap_from_ns", "i8"),  # stamp that the estimate had come to before that [ns]
        ("leap_last_ns", "i8"),  # of the wrench before that [ns]
        ("far_wrench_ns", "i8"),  # of the last message of a kind, where it was far behind [ns]
        ("far_joints_ns", "i8"),
        ("joints", "i8"),  # recent stamps, in their order of arrival
        ("joints_first", "i8"),
        ("joint_stamps", "i8", (MAX_STAMPS,)),
    ]
)


def new_order(configuration: Configuration) -> np.ndarray:
    """Return the order before the first message, an array of ORDER, shape (1,)."""
    memory = np.zeros(1, ORDER)
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
def take_back(order: OrderRecord) -> None:
    """Undo a wrench that leapt."""
    order.now_ns, order.last_wrench_ns = order.leap_from_ns, order.leap_last_ns
    order.leap_ns = NO_STAMP


@compiled
def fate_of_wrench(o: OrderRecord, ring: Ring, t_ns: int) -> int:
    """Decide what becomes of a wrench of a stamp [ns], a place in FATES, and take note of it."""
    fate = _of_wrench(o, ring, ring.places[0], t_ns)
    _note_wrench(o, fate, t_ns)
    return fate


@compiled
def fate_of_joints(o: OrderRecord, ring: Ring, t_ns: int) -> int:
    """Decide what becomes of an orientation of a stamp [ns], and take note of it."""
    fate = _of_joints(o, ring, ring.places[0], t_ns)
    _note_joints(o, ring.places[0], fate, t_ns)
    return fate


@compiled
def _far(o, t_ns):
    return o.now_ns - t_ns > CLOCK_JUMP_NS


@compiled
def _of_wrench(o, ring, r, t_ns):
    if o.now_ns == NO_STAMP:
        return FATE.wrench_too_early
    if t_ns == o.last_wrench_ns:
        return FATE.wrench_repeated
    leapt = o.leap_ns != NO_STAMP and t_ns < o.now_ns
    if leapt and o.leap_from_ns < t_ns < (o.leap_from_ns + o.leap_ns) // 2:
        return FATE.takes_back
    if _far(o, t_ns):
        # One alone is a message whose stamp was not set, or of another clock.
        again = o.far_wrench_ns != NO_STAMP and t_ns > o.far_wrench_ns
        return FATE.wrench_restarts if again else FATE.wrench_too_late
    if t_ns < o.now_ns:
        if o.now_ns - t_ns > o.window_ns:
            return FATE.wrench_too_late
        if kept.has_wrench(ring, r, t_ns):
            return FATE.wrench_repeated
        return FATE.wrench_late if kept.reaches(r, t_ns) else FATE.wrench_too_late
    return FATE.leaps if 0 < o.window_ns < t_ns - o.now_ns else FATE.taken


@compiled
def _note_wrench(o, fate, t_ns):
    if fate == FATE.wrench_too_early or fate == FATE.takes_back or t_ns == o.last_wrench_ns:
        return
    o.far_wrench_ns = t_ns if _far(o, t_ns) else NO_STAMP
    if fate == FATE.wrench_late:
        o.leap_ns = NO_STAMP
    elif fate == FATE.taken or fate == FATE.leaps:
        o.leap_ns = t_ns if fate == FATE.leaps else NO_STAMP
        o.leap_from_ns, o.leap_last_ns = o.now_ns, o.last_wrench_ns
        o.now_ns = o.last_wrench_ns = t_ns


@compiled
def _of_joints(o, ring, r, t_ns):
    if o.now_ns == NO_STAMP:
        return FATE.starts
    if o.now_ns - t_ns - o.expected_ns > CLOCK_JUMP_NS:
        again = o.far_joints_ns != NO_STAMP and t_ns > o.far_joints_ns
        return FATE.joints_restart if again else FATE.joints_too_late
    if _came(o, t_ns):
        return FATE.joints_repeated
    if t_ns > o.now_ns:
        begin = kept.waiting_from(ring, r)
        before = r.joints_last > begin and t_ns < ring.joint_ns[r.joints_last - 1]
        return FATE.waits_before if before else FATE.waits
    late_ns = o.now_ns - t_ns
    if not late_ns:
        return FATE.same
    if o.window_ns:
        placed = late_ns <= o.window_ns and kept.reaches(r, t_ns)
        return FATE.joints_late if placed else FATE.joints_too_late
    near = late_ns - o.expected_ns <= o.tolerance_ns
    return FATE.joints_moved if near else FATE.joints_too_late


@compiled
def _came(o, t_ns):
    """Return whether an orientation of a stamp came already; forget what is too old to matter."""
    reach_ns = max(o.window_ns, o.tolerance_ns + o.expected_ns)
    oldest_ns = o.now_ns - reach_ns
    while o.joints and (o.joint_stamps[o.joints_first] < oldest_ns or o.joints >= MAX_STAMPS):
        o.joints_first = (o.joints_first + 1) % MAX_STAMPS
        o.joints -= 1
    return t_ns <= o.newest_ns and _among(o.joint_stamps, o.joints_first, o.joints, t_ns)


@compiled
def _among(stamps, first, count, t_ns):
    found = False
    for i in range(count):
        found |= stamps[(first + i) % len(stamps)] == t_ns
    return found


@compiled
def _note_joints(o, r, fate, t_ns):
    if fate == FATE.joints_restart:
        return
    if fate == FATE.starts:
        o.now_ns = r.kept_from_ns = t_ns
    elif o.now_ns - t_ns - o.expected_ns > CLOCK_JUMP_NS:
        o.far_joints_ns = t_ns
        return
    o.far_joints_ns = NO_STAMP
    if fate == FATE.joints_repeated:
        return
    o.joint_stamps[(o.joints_first + o.joints) % MAX_STAMPS] = t_ns
    o.joints += 1
    o.newest_ns = max(o.newest_ns, t_ns)
    if fate == FATE.joints_late and t_ns <= o.leap_from_ns:
        o.leap_ns = NO_STAMP
