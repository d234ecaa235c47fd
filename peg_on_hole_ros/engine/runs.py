"""Wrenches in order, with orientations that may come late, taken in one go."""

import numpy as np

from peg_on_hole_ros.engine.arrival_order import FATE, arrive, forget
from peg_on_hole_ros.engine.kept import Kept
from peg_on_hole_ros.engine.late_orientations import Stretch, stretch_of
from peg_on_hole_ros.engine.placing import FEWEST, LEAST_NS, Placing
from peg_on_hole_ros.records import AngleMeasurement, Arrivals, Rows, WrenchSample

# Wrenches that going back may reach over; beyond, messages are taken one by one.
MOST_BACK = 1024


def run_of(arrivals: Arrivals, begin: int, fates: np.ndarray) -> Arrivals:
    """Return messages from a place on, with their fates, without those that are dropped."""
    some = slice(begin, begin + len(fates))
    of_wrench, before = arrivals.of_wrench[some], int(np.count_nonzero(arrivals.of_wrench[:begin]))
    used = np.isin(fates, (FATE.taken, FATE.waits, FATE.same, FATE.joints_late))
    behind = before + int(np.count_nonzero(of_wrench))
    orientations = arrivals.orientations[begin - before : some.stop - behind]
    return Arrivals(
        of_wrench[used],
        arrivals.t_ns[some][used],
        arrivals.sound[some][used],
        arrivals.wrenches[before:behind][used[of_wrench]],
        orientations[used[~of_wrench]],
    )


def orientation_at(arrivals: Arrivals, place: int) -> AngleMeasurement:
    """Return the orientation at a place among messages."""
    row = place - int(np.count_nonzero(arrivals.of_wrench[:place]))
    return AngleMeasurement.of_row(arrivals.t_ns[place], arrivals.orientations[row])


def take_run(p: Placing, run: Arrivals, late: bool) -> tuple[list[Rows], int, bool] | None:
    """
    Take a run that ends with a wrench, in the least of calls.

    Parameters
    ----------
    p : Placing
    run : Arrivals
        Stamps of its wrenches rise, and those of its orientations.
    late : bool
        Whether some of the orientations are late.

    Returns
    -------
    given : list of Rows
        What the wrenches give.
    wrenches : int
        How many of them are taken.
    other : bool
        Whether another setting is used from the last of these on; what follows is not taken.

    None where it reaches back too far.

    """
    now_ns, history, kept = p.now_ns, p.history, None
    units = history.last_units(now_ns) if late else []
    s = stretch_of(units, p.waiting, run.of_wrench, run.t_ns, run.wrenches, run.orientations)
    if late:
        places = 1 + max(s.back, s.since(int(s.t_ns[-1]) - history.window_ns))
        if places > MOST_BACK:
            return None
        if p.room is None or len(p.room.beside) < places:
            p.room = p.processor.room(places)
        kept = p.room
    begin_ns = units[0].begin_ns if units else now_ns
    if units and kept is not None:
        p.processor.fill(kept, s, units[0].before)
    given, taken, wrenches, other = _process(p, s, kept, now_ns)
    if kept is not None and not other:
        first = max(0, wrenches - len(kept.beside))
        history.hold(s.run(first, wrenches, taken, kept.of(first % len(kept.beside)), begin_ns))
    p.waiting = s.measurements(taken, s.ends[wrenches - 1])
    new = slice(max(s.begin, _recent(s.t_ns[:wrenches])), wrenches)
    p.recent.extend(map(WrenchSample.of_row, s.t_ns[new], s.wrenches[new]))
    return given, wrenches - s.begin, other


def _recent(t_ns):
    """Return the first of those wrenches of which a tare may be taken."""
    before = int(np.searchsorted(t_ns, t_ns[-1] - LEAST_NS, "right")) - 1
    return max(min(before, len(t_ns) - FEWEST), 0)


def _process(
    p: Placing, s: Stretch, kept: Kept | None, begin_ns: int
) -> tuple[list[Rows], int, int, bool]:
    """Process wrenches up to each that is due; return rows, and how many of both are taken."""
    given: list[Rows] = []
    first, taken, other = s.begin, s.taken, False
    while first < len(s.t_ns) and not other:
        processor = p.processor
        sample = WrenchSample.of_row(s.t_ns[first], s.wrenches[first])
        p.findings.pass_by(sample)
        due = p.findings.due(sample.t_ns)
        if due and kept is not None and first:
            p.went_back(*processor.go_on(s, first, first, taken, kept)[1].tolist())
            taken = max(taken, s.had(first, first - 1))
        _note_newest(p, s, s.had(first, first))
        other = due and p.diagnose(sample)
        last = first + 1
        if not other:
            last = max(last, int(np.searchsorted(s.t_ns, p.findings.due_ns)))
        p.findings.pass_all_by(s.t_ns[first + 1 : last], s.wrenches[first + 1 : last])
        in_order = kept is None or other
        before = None
        if in_order and p.history.window_ns:
            before = p.processor.snapshot()
        rows, went = p.processor.go_on(s, first, last, taken, None if in_order else kept)
        p.went_back(*went.tolist())
        had = s.had(last - 1, last - 1)
        if in_order:
            p.history.append_run(s.run(first, last, had, before, begin_ns, taken))
        if len(rows.t_ns):
            p.tell(rows)
            given.append(rows)
        if not len(rows.t_ns) or rows.t_ns[-1] != s.t_ns[last - 1]:
            p.told = None
        first, taken, begin_ns = last, had, int(s.t_ns[last - 1])
    _note_newest(p, s, taken)
    return given, taken, first, other


def _note_newest(p, s, count):
    """Take note of the newest of so many orientations that have been taken."""
    if count:
        p.measured = AngleMeasurement.of_row(s.stamps[count - 1], s.orientations[count - 1])


def look_again(p: Placing, of_wrench: np.ndarray, t_ns: np.ndarray, fates: np.ndarray) -> None:
    """Let the copy of the order end with a wrench from which another setting is used."""
    ahead, from_ns, sound = p.ahead(), p.now_ns, np.ones(len(t_ns), bool)
    for part in (slice(-1), slice(-1, None)):
        from_ns = int(ahead["now_ns"][0])
        arrive(ahead, of_wrench[part], t_ns[part], sound[part], False, fates[part])
    forget(ahead[0], from_ns, int(t_ns[-1]))
