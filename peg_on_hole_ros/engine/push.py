"""
Messages in their order of arrival, one or thousands: what becomes of each, and what it gives.

One compiled call processes them until something has to be done in Python: a wrench is due to be
looked at, the clock has jumped, or a filter that is written in Python makes a step.
A Stop names what to do then, and the next call goes on where the last one stopped.
"""

from enum import IntEnum
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from peg_on_hole_ros.engine import arrival_order, ring, snapshots, steps
from peg_on_hole_ros.engine.arrival_order import Fate
from peg_on_hole_ros.engine.ring import Ring
from peg_on_hole_ros.engine.tuned import REPROCESSING
from peg_on_hole_ros.estimator import filter_steps
from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.monitor.output_row import NOTHING, ROW
from peg_on_hole_ros.typed_record import Record


class Stop(IntEnum):
    """Why a call ended; the values of what Python has to do before it goes on."""

    END = 0  # all messages are taken
    UNSOUND = 1  # a message that is not given here
    ENOUGH = 2  # as many as were asked for, or stamps would fall within what is given
    LOOK = 3  # the wrench `place` is due to be looked at
    RESTART = 4  # the clock has jumped back: begin anew, then process the message again
    START = 5  # a filter in Python starts from the orientation `place`
    CORRECT = 6  # it corrects by the orientation `place`, which was late by `lateness`
    WRENCH = 7  # it processes the wrench `unit` of the ring


class Phase(IntEnum):
    """Where the processing of a message goes on."""

    ARRIVES = 0
    CATCHES_UP = 1
    LOOKED = 2
    WORKS = 3


class BatchProgress(Record):
    """
    How far a batch of messages is processed.

    Attributes
    ----------
    place
        Of the message that is processed.
    begin
        Of the first that is processed.
    apart : bool
        Whether the message is processed by itself.
    wrench
        Wrenches before it.
    rows
        Rows that are given.
    taken, most
        Wrenches that came in order, and how many of these are asked for.
    phase : Phase
    fate : Fate
        Of the message.
    from_ns
        Stamp that the estimate had come to before the wrench [ns].
    due_ns, due_until_ns
        Stamps from which on a wrench is due to be looked at, and before which one is, too [ns].
    by_hand : bool
        Whether the filter is written in Python.
    unit
        Wrench of the ring that it is to process.
    has_row, newest_has_row : bool
        Whether a wrench that was processed gave a row, and whether the newest did.
    lateness
        Of the orientation [s].
    fates : shape (fates,)
        How many messages there were of each fate.

    """

    place: int
    begin: int
    apart: bool
    wrench: int
    rows: int
    taken: int
    most: int
    phase: Phase
    fate: Fate
    from_ns: int
    due_ns: int
    due_until_ns: int
    by_hand: bool
    unit: int
    has_row: bool
    newest_has_row: bool
    lateness: float
    fates: Annotated[NDArray[np.int64], (len(Fate),)]


class EngineMemory(NamedTuple):
    """
    All that a call works on.

    Attributes
    ----------
    engine : ndarray of EngineState, shape (1,)
        An array, as Python hands over a record in sixteen microseconds.
    words : ndarray of int64
        The same memory.
    rules : ndarray of Rules, shape (1,)
    order : ndarray of Order, shape (1,)
    ring : Ring

    """

    engine: np.ndarray
    words: np.ndarray
    rules: np.ndarray
    order: np.ndarray
    ring: Ring


class Filled(NamedTuple):
    """
    What a call of `push` puts out.

    Attributes
    ----------
    t_ns : ndarray of int64, shape (n,)
        Stamps of the rows [ns].
    rows : ndarray of ROW, shape (n,)
    taken : ndarray of int64, shape (n,)
        Which of the wrenches came in order.
    taken_ns : ndarray of int64, shape (n,)
        Their stamps [ns].

    """

    t_ns: np.ndarray
    rows: np.ndarray
    taken: np.ndarray
    taken_ns: np.ndarray


def room_for(wrenches: int) -> Filled:
    """Return room for what so many wrenches give, and at least for one."""
    n = max(wrenches, 1)
    return Filled(
        np.empty(n, np.int64), np.empty(n, ROW), np.empty(n, np.int64), np.empty(n, np.int64)
    )


@compiled
def push(memory: EngineMemory, batch: np.ndarray, arrivals: Any, given: Filled) -> int:
    """
    Process messages in their order of arrival.

    Parameters
    ----------
    memory : EngineMemory
        Changed.
    batch : ndarray of BatchProgress, shape (1,)
        Where to begin; changed.
    arrivals : Arrivals
    given : Filled
        Filled in.

    Returns
    -------
    int
        A Stop.

    """
    p = batch[0]
    while p.place < len(arrivals.t_ns):
        if p.phase == Phase.ARRIVES:
            if not arrivals.sound[p.place]:
                return Stop.UNSOUND
            p.apart = _falls_back(memory.order[0], arrivals, p.place)
            if p.apart and p.place > p.begin:
                return Stop.ENOUGH
        if arrivals.of_wrench[p.place]:
            stop = _push_wrench(memory, p, arrivals, given)
        else:
            stop = _push_orientation(memory, p, arrivals)
        if stop != Stop.END:
            return stop
        p.wrench += arrivals.of_wrench[p.place]
        p.place += 1
        p.phase = Phase.ARRIVES
        if p.taken >= p.most or p.apart:
            return Stop.ENOUGH
    return Stop.END


@compiled
def _falls_back(order, arrivals, place):
    """Return whether a message is of before the newest of its kind: it is taken by itself."""
    newest_ns = order.now_ns if arrivals.of_wrench[place] else order.newest_ns
    return arrivals.t_ns[place] < newest_ns


@compiled
def catch_up(memory: EngineMemory, batch: np.ndarray, given: Filled) -> int:
    """Process again what late messages have reached, without a row; return a Stop."""
    ring.rewind(memory.ring, memory.ring.places[0], memory.words, memory.engine[0].filter[0].state)
    return _work(memory, batch[0], given)


@compiled
def _push_wrench(memory, p, arrivals, given):
    """Process the wrench at `place`, from its phase on."""
    order, kept = memory.order[0], memory.ring
    r, s = kept.places[0], memory.engine[0].filter[0].state
    t_ns, wrench = arrivals.t_ns[p.place], arrivals.wrenches[p.wrench]
    if p.phase == Phase.ARRIVES:
        p.from_ns = order.now_ns
        p.fate = arrival_order.fate_of_wrench(order, kept, t_ns)
        if p.fate == Fate.TAKES_BACK:
            p.fates[p.fate] += 1
            ring.take_back(kept, r, memory.words, s)
            arrival_order.take_back(order)
            p.from_ns = order.now_ns
            p.fate = arrival_order.fate_of_wrench(order, kept, t_ns)
        p.fates[p.fate] += 1
        if p.fate == Fate.WRENCH_RESTARTS:
            return Stop.RESTART
        if p.fate == Fate.WRENCH_LATE:
            ring.put_late_wrench(kept, r, t_ns, wrench)
        if p.fate != Fate.TAKEN and p.fate != Fate.LEAPS:
            return Stop.END
        given.taken[p.taken], given.taken_ns[p.taken] = p.wrench, t_ns
        p.taken += 1
        ring.note_recent(r, t_ns, wrench)
        ring.rewind(kept, r, memory.words, s)
        p.phase = Phase.CATCHES_UP
    if p.phase == Phase.CATCHES_UP:
        stop = _work(memory, p, given)
        if stop != Stop.END:
            return stop
        end = ring.due_until(kept, r, t_ns)
        if end > ring.waiting_from(kept, r):
            ring.note_measured(r, kept.joint_ns[end - 1], kept.orientations[end - 1])
        p.phase = Phase.LOOKED
        if t_ns >= p.due_ns or t_ns < p.due_until_ns:
            return Stop.LOOK
    if p.phase == Phase.LOOKED:
        ring.append_wrench(kept, r, t_ns, wrench)
        p.phase = Phase.WORKS
    stop = _work(memory, p, given)
    if stop == Stop.END:
        p.newest_has_row = p.has_row
        if p.has_row:
            given.t_ns[p.rows] = t_ns
            p.rows += 1
        ring.settle(kept, r, order.window_ns)
    return stop


@compiled
def _push_orientation(memory, p, arrivals):
    """Process the orientation at `place`; if it is to be processed again, begin anew."""
    e, rules, order = memory.engine[0], memory.rules[0], memory.order[0]
    kept = memory.ring
    r = kept.places[0]
    if p.phase != Phase.ARRIVES:
        return Stop.END
    t_ns, row = arrivals.t_ns[p.place], arrivals.orientations[p.place - p.wrench]
    now_ns = order.now_ns
    fate = arrival_order.fate_of_joints(order, kept, t_ns)
    p.fates[fate] += 1
    p.fate, p.phase = fate, Phase.WORKS
    if fate == Fate.JOINTS_RESTART:
        p.phase = Phase.ARRIVES
        return Stop.RESTART
    if fate == Fate.STARTS:
        ring.note_measured(r, t_ns, row)
        if p.by_hand:
            return Stop.START
        steps.start_estimate(e, rules, t_ns, row)
    elif fate == Fate.WAITS or fate == Fate.WAITS_BEFORE:
        ring.put_waiting(kept, r, t_ns, row)
    elif fate == Fate.JOINTS_LATE:
        ring.note_measured(r, t_ns, row)
        ring.put_late_orientation(kept, r, t_ns, row)
    elif fate == Fate.SAME or fate == Fate.JOINTS_MOVED:
        ring.note_measured(r, t_ns, row)
        p.lateness = (now_ns - t_ns) * 1e-9
        if fate == Fate.SAME:
            ring.put_behind(kept, r, t_ns, row)
        if r.changed < 0 or fate == Fate.JOINTS_MOVED:
            if p.by_hand:
                return Stop.CORRECT
            steps.correct(e, rules, t_ns, row, p.lateness)
    return Stop.END


@compiled
def _work(memory, p, given):
    """Process the wrenches of the ring that have not been, the newest of them with a row."""
    e, rules, kept = memory.engine[0], memory.rules[0], memory.ring
    r = kept.places[0]
    while r.done < r.last:
        unit = r.done
        newest = p.phase == Phase.WORKS and unit == r.last - 1
        if r.restored:
            r.restored = False
        elif memory.order[0].window_ns and _is_saved(kept, r, p, unit, newest):
            snapshots.save(kept.snapshots, unit, memory.words, e.filter[0].state)
        r.done += 1
        given.rows[p.rows] = NOTHING[0]
        if p.by_hand:
            p.unit = unit
            return Stop.WRENCH
        p.has_row = _take_wrench(e, rules, kept, r, unit, given.rows[p.rows])
    return Stop.END


@compiled
def _is_saved(kept, r, p, unit, newest):
    """Return whether there is to be a snapshot before a wrench."""
    if newest:
        return p.fate == Fate.LEAPS or snapshots.is_due(kept.snapshots)
    recent = r.last - unit <= REPROCESSING.recent_snapshots
    return recent or snapshots.has_snapshot(kept.snapshots, unit)


@compiled
def _take_wrench(e, rules, kept, r, unit, row):
    """Process a wrench of the ring with its orientations; return whether it gives a row."""
    t_ns, begin = kept.t_ns[unit], ring.joints_from(kept, r, unit)
    silent = steps.is_after_silence(e, rules, t_ns)
    for k in range(begin, kept.before[unit]):
        steps.advance(e, rules, kept.joint_ns[k])
        steps.correct(e, rules, kept.joint_ns[k], kept.orientations[k], 0.0)
    steps.advance(e, rules, t_ns)
    admit_wrench = steps.admit_wrench(e, rules)
    if admit_wrench:
        contacts = steps.reduce(e, t_ns, kept.wrenches[unit], silent)
        filter_steps.correct_by_wrench(e.filter, e.u, contacts.value)
        steps.fill_row(e, rules, t_ns, contacts, row)
    for k in range(kept.before[unit], kept.after[unit]):
        steps.correct(e, rules, kept.joint_ns[k], kept.orientations[k], 0.0)
    return admit_wrench
