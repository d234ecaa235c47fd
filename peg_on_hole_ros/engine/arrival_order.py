"""What becomes of a message by its stamp and by what came before it: one compiled decision."""

from collections import namedtuple
from typing import Any

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.engine.history import MAX_KEPT
from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.monitor.memory import NO_STAMP

# A stamp this far behind is a clock that was set back or a bag played again, not a late message.
CLOCK_JUMP_NS = 1_000_000_000
# Joint states that wait for the wrench of their time; at 8 kHz these are 60 ms.
MAX_WAITING = 512
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
        ("kept_from_ns", "i8"),  # what is not after it has no place [ns]
        ("leap_ns", "i8"),  # of a wrench that leapt and may be taken back [ns]
        ("leap_from_ns", "i8"),  # stamp that the estimate had come to before that [ns]
        ("leap_last_ns", "i8"),  # of the wrench before that [ns]
        ("far_wrench_ns", "i8"),  # of the last message of a kind, where it was far behind [ns]
        ("far_joints_ns", "i8"),
        ("waiting", "i8"),  # orientations that wait, with their stamps in order
        ("waits", "i8", (MAX_WAITING + 1,)),
        ("joints", "i8"),  # recent stamps, in their order of arrival
        ("joints_first", "i8"),
        ("joint_stamps", "i8", (MAX_STAMPS,)),
        ("wrenches", "i8"),
        ("wrenches_first", "i8"),
        ("wrench_stamps", "i8", (MAX_KEPT,)),
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
    order["waiting"] = order["joints"] = 0
    forget(order, NO_STAMP)


def forget(order: np.void, from_ns: int, *kept_ns: int) -> None:
    """Take note that nothing up to a stamp is kept to be gone back to, and which wrenches [ns]."""
    order["kept_from_ns"], order["leap_ns"], order["wrenches_first"] = from_ns, NO_STAMP, 0
    order["wrenches"] = len(kept_ns)
    order["wrench_stamps"][: len(kept_ns)] = kept_ns


def take_back(order: np.void, waits: list[int]) -> None:
    """Undo a wrench that leapt; orientations of these stamps wait again [ns]."""
    order["now_ns"], order["last_wrench_ns"] = order["leap_from_ns"], order["leap_last_ns"]
    order["leap_ns"], order["wrenches"] = NO_STAMP, max(order["wrenches"] - 1, 0)
    order["waiting"] = len(waits)
    order["waits"][: len(waits)] = waits


@compiled
def arrive(
    order: np.ndarray,
    of_wrench: np.ndarray,
    t_ns: np.ndarray,
    sound: np.ndarray,
    alone: bool,
    fates: np.ndarray,
) -> int:
    """
    Decide what becomes of messages, in their order of arrival.

    Parameters
    ----------
    order : ndarray of ORDER, shape (1,)
        Changed.
    of_wrench, t_ns, sound : ndarray, shape (n,)
        See `Arrivals`.
    alone : bool
        False: end before one that cannot be taken in one run with those before it. Such a run has
        wrenches in order and orientations whose stamps rise, and may have late ones of these.
    fates : ndarray of int64, shape (n,)
        Filled in, places in FATES.

    Returns
    -------
    int
        Of how many that is decided.

    """
    o = order[0]
    for i in range(len(t_ns)):
        if not sound[i]:
            return i
        newest_ns = o.newest_ns
        fate = _of_wrench(o, t_ns[i]) if of_wrench[i] else _of_joints(o, t_ns[i])
        if not alone and not _runs_on(o, fate, t_ns[i], newest_ns):
            return i
        fates[i] = fate
        if of_wrench[i]:
            _note_wrench(o, fate, t_ns[i])
        else:
            _note_joints(o, fate, t_ns[i])
    return len(t_ns)


@compiled
def _runs_on(o, fate, t_ns, newest_ns):
    if fate == FATE.waits:
        return o.waiting < MAX_WAITING
    if fate == FATE.same or fate == FATE.joints_late:
        return t_ns > newest_ns
    return (
        fate == FATE.taken
        or fate == FATE.wrench_repeated
        or fate == FATE.wrench_too_late
        or fate == FATE.joints_repeated
        or fate == FATE.joints_too_late
    )


@compiled
def _far(o, t_ns):
    return o.now_ns - t_ns > CLOCK_JUMP_NS


@compiled
def _of_wrench(o, t_ns):
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
        if _among(o.wrench_stamps, o.wrenches_first, o.wrenches, t_ns):
            return FATE.wrench_repeated
        return FATE.wrench_late if t_ns > o.kept_from_ns else FATE.wrench_too_late
    return FATE.leaps if 0 < o.window_ns < t_ns - o.now_ns else FATE.taken


@compiled
def _note_wrench(o, fate, t_ns):
    if fate == FATE.wrench_too_early or fate == FATE.takes_back or t_ns == o.last_wrench_ns:
        return
    o.far_wrench_ns = t_ns if _far(o, t_ns) else NO_STAMP
    if fate == FATE.wrench_late:
        o.leap_ns = NO_STAMP
        _keep_wrench(o, t_ns)
    elif fate == FATE.taken or fate == FATE.leaps:
        o.leap_ns = t_ns if fate == FATE.leaps else NO_STAMP
        o.leap_from_ns, o.leap_last_ns = o.now_ns, o.last_wrench_ns
        o.now_ns = o.last_wrench_ns = t_ns
        taken = 0
        while taken < o.waiting and o.waits[taken] <= t_ns:
            taken += 1
        for i in range(taken, o.waiting):
            o.waits[i - taken] = o.waits[i]
        o.waiting -= taken
        _keep_wrench(o, t_ns)


@compiled
def _keep_wrench(o, t_ns):
    if not o.window_ns:
        return
    oldest_ns = o.now_ns - o.window_ns
    while o.wrenches:
        first_ns = o.wrench_stamps[o.wrenches_first]
        if first_ns >= oldest_ns and o.wrenches < MAX_KEPT:
            break
        o.wrenches_first = (o.wrenches_first + 1) % MAX_KEPT
        o.wrenches -= 1
        o.kept_from_ns = max(o.kept_from_ns, first_ns)
    o.wrench_stamps[(o.wrenches_first + o.wrenches) % MAX_KEPT] = t_ns
    o.wrenches += 1


@compiled
def _of_joints(o, t_ns):
    if o.now_ns == NO_STAMP:
        return FATE.starts
    if o.now_ns - t_ns - o.expected_ns > CLOCK_JUMP_NS:
        again = o.far_joints_ns != NO_STAMP and t_ns > o.far_joints_ns
        return FATE.joints_restart if again else FATE.joints_too_late
    if _came(o, t_ns):
        return FATE.joints_repeated
    if t_ns > o.now_ns:
        before = o.waiting > 0 and t_ns < o.waits[o.waiting - 1]
        return FATE.waits_before if before else FATE.waits
    late_ns = o.now_ns - t_ns
    if not late_ns:
        return FATE.same
    if o.window_ns:
        placed = late_ns <= o.window_ns and t_ns > o.kept_from_ns
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
def _note_joints(o, fate, t_ns):
    if fate == FATE.joints_restart:
        return
    if fate == FATE.starts:
        o.now_ns = o.kept_from_ns = t_ns
    elif o.now_ns - t_ns - o.expected_ns > CLOCK_JUMP_NS:
        o.far_joints_ns = t_ns
        return
    o.far_joints_ns = NO_STAMP
    if fate == FATE.joints_repeated:
        return
    o.joint_stamps[(o.joints_first + o.joints) % MAX_STAMPS] = t_ns
    o.joints += 1
    o.newest_ns = max(o.newest_ns, t_ns)
    if fate == FATE.waits or fate == FATE.waits_before:
        at = o.waiting
        while at and o.waits[at - 1] > t_ns:
            o.waits[at] = o.waits[at - 1]
            at -= 1
        o.waits[at] = t_ns
        o.waiting += 1
        if o.waiting > MAX_WAITING:
            for i in range(MAX_WAITING):
                o.waits[i] = o.waits[i + 1]
            o.waiting = MAX_WAITING
    elif fate == FATE.joints_late and t_ns <= o.leap_from_ns:
        o.leap_ns = NO_STAMP
