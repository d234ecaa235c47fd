"""What was processed last, kept so that a late message can be put where it belongs."""

from collections import deque
from collections.abc import Iterator
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from peg_on_hole_ros.records import AngleMeasurement, WrenchSample

# Wrenches that are kept at most: 1.5 s, the longest `filter.late_window` and the longest
# `joints.delay` together, at 8 kHz.
MAX_KEPT = 12_000
# A snapshot takes some 50 kB, and a fifth of the time that a wrench does. It is due with every
# eighth wrench while all comes in order: going back then begins up to seven wrenches earlier than
# it would have to. After a late message it is due with each wrench for a while, and kept for the
# latest DENSE: who goes back farther is not held up by seven more. So MAX_KEPT take some 90 MB.
STRIDE = 8
ALERT = 1000
DENSE = 256


class Unit:
    """
    One wrench, and the orientations since the wrench before it.

    Attributes
    ----------
    wrench : WrenchSample
    joints : list of AngleMeasurement
        In order of their stamps, none above that of the wrench.
    after : list of AngleMeasurement
        Of the wrench's own stamp, that arrived after it.
    before : object or None
        Snapshot of everything that the estimate depends on, before this unit.
    begin_ns : int
        Stamp that the estimate had come to before it [ns].

    """

    __slots__ = ("wrench", "joints", "after", "before", "begin_ns")

    def __init__(
        self, wrench: WrenchSample, joints: list[AngleMeasurement], before: Any, begin_ns: int
    ) -> None:
        self.wrench, self.joints = wrench, joints
        self.after: list[AngleMeasurement] = []
        self.before, self.begin_ns = before, begin_ns


class Run(NamedTuple):
    """
    Wrenches and orientations that came in order.

    Attributes
    ----------
    t_ns, wrenches, ends, stamps, orientations : ndarray
        See `engine.advance.advance`.
    before : object or None
        As of a `Unit`, of the first wrench.
    begin_ns : int
        As of a `Unit`, of the first wrench [ns].

    """

    t_ns: np.ndarray
    wrenches: np.ndarray
    ends: np.ndarray
    stamps: np.ndarray
    orientations: np.ndarray
    before: object
    begin_ns: int

    def units(self) -> Iterator[Unit]:
        """Yield the same as units."""
        first, begin_ns, before = 0, self.begin_ns, self.before
        for t_ns, wrench, last in zip(self.t_ns.tolist(), self.wrenches, self.ends.tolist()):
            joints = map(
                AngleMeasurement.of_row, self.stamps[first:last], self.orientations[first:last]
            )
            yield Unit(WrenchSample.of_row(t_ns, wrench), list(joints), before, begin_ns)
            first, begin_ns, before = last, t_ns, None


class History:
    """
    The units of the last `window_ns`, oldest first.

    Parameters
    ----------
    window_ns : int
        How far back a message may be put [ns]; 0 keeps nothing.

    Attributes
    ----------
    wrenches, joints : int
        Messages that were put in and have not been processed.

    """

    def __init__(self, window_ns: int) -> None:
        self.window_ns = window_ns
        self._units: deque[Unit] = deque()
        # Behind the units: runs, until they are needed one by one.
        self._runs: deque[Run] = deque()
        self._first: int | None = None
        self._appended = self._alert = self._bare = 0
        self.wrenches = self.joints = 0

    def clear(self) -> None:
        """Forget everything: nothing that happened so far can be gone back to."""
        self._units.clear()
        self._runs.clear()
        self._first = None
        self._appended = self._alert = self._bare = 0
        self.wrenches = self.joints = 0

    @property
    def changed(self) -> bool:
        """Whether a message was put in that has not been processed."""
        return self._first is not None

    @property
    def wants_snapshot(self) -> bool:
        """Whether the next unit is to come with a snapshot."""
        return self.window_ns > 0 and (self._alert > 0 or not self._appended % STRIDE)

    def append_run(self, run: Run) -> None:
        """Keep the newest run, with a snapshot; forget what no late message needs."""
        if not self.window_ns:
            return
        runs, oldest = self._runs, int(run.t_ns[-1]) - self.window_ns
        runs.append(run)
        self._appended += len(run.t_ns)
        if self._units and self._units[-1].wrench.t_ns < oldest:
            self._units.clear()
        count = sum(len(each.t_ns) for each in runs)
        while runs[0].t_ns[-1] < oldest or count - len(runs[0].t_ns) >= MAX_KEPT:
            count -= len(runs.popleft().t_ns)

    def last_units(self, now_ns: int) -> list[Unit]:
        """Return the units of the window before a stamp [ns], the first one with a snapshot."""
        self._spread()
        units, oldest = list(self._units), now_ns - self.window_ns
        begin = 0
        for i, unit in enumerate(units):
            if unit.begin_ns >= oldest:
                break
            if unit.before is not None:
                begin = i
        return units[begin:]

    def hold(self, run: Run) -> None:
        """Keep a run alone, which holds all that a late message of the window needs."""
        self._units.clear()
        self._runs.clear()
        self._runs.append(run)
        self._appended += len(run.t_ns)

    def _spread(self):
        """Take runs apart into units."""
        for run in self._runs:
            self._units.extend(run.units())
        self._runs.clear()

    def append(self, unit: Unit) -> None:
        """Keep the newest unit, forget those that no late message within the window needs."""
        if not self.window_ns:
            return
        self._spread()
        units, oldest = self._units, unit.wrench.t_ns - self.window_ns
        units.append(unit)
        self._appended += 1
        self._alert -= self._alert > 0
        self._thin()
        if unit.before is None:
            return
        # What is kept begins with a snapshot.
        count = self._until_snapshot()
        while count and (len(units) - count >= MAX_KEPT or units[count - 1].wrench.t_ns < oldest):
            for _ in range(count):
                units.popleft()
            count = self._until_snapshot()

    def take_back(self) -> list[AngleMeasurement]:
        """Forget the newest unit; return its orientations, in order."""
        unit = self._units.pop()
        self._first, self.wrenches, self.joints = None, 0, 0
        if not self._units:
            # What is kept begins with a snapshot.
            self._appended = 0
        return [*unit.joints, *unit.after]

    def _thin(self):
        """Leave every eighth snapshot before the latest DENSE, and the first that is kept."""
        if len(self._units) <= DENSE + 1:
            self._bare = 0
            return
        unit = self._units[-DENSE - 1]
        if unit.before is None or self._bare < STRIDE - 1:
            unit.before = None
            self._bare += 1
        else:
            self._bare = 0

    def _until_snapshot(self):
        for i in range(1, len(self._units)):
            if self._units[i].before is not None:
                return i
        return 0

    def add_after(self, measurement: AngleMeasurement) -> None:
        """Keep an orientation of the newest wrench's stamp, that came after it."""
        self._spread()
        if self._units and self._units[-1].wrench.t_ns == measurement.t_ns:
            self._units[-1].after.append(measurement)
            self.joints += self.changed

    def put_joints(self, measurement: AngleMeasurement) -> None:
        """Put a late orientation in its place."""
        i = self._place(measurement.t_ns)
        joints = self._units[i].joints
        at = len(joints)
        while at and joints[at - 1].t_ns > measurement.t_ns:
            at -= 1
        joints.insert(at, measurement)
        self._change(i)
        self.joints += 1

    def put_wrench(self, sample: WrenchSample) -> None:
        """Put a late wrench in its place."""
        i = self._place(sample.t_ns)
        later = self._units[i]
        joints = [joint for joint in later.joints if joint.t_ns <= sample.t_ns]
        later.joints = later.joints[len(joints) :]
        self._units.insert(i, Unit(sample, joints, later.before, later.begin_ns))
        self._change(i)
        self.wrenches += 1

    def _change(self, i):
        self._first = i if self._first is None else min(i, self._first)
        self._alert = ALERT

    def _place(self, t_ns):
        self._spread()
        units = self._units
        i = len(units) - 1
        while i and units[i - 1].wrench.t_ns >= t_ns:
            i -= 1
        return i

    def take_changed(self) -> tuple[int, list[tuple[Unit, bool]]]:
        """
        Return how many units a change reaches, and all from the last snapshot before it on.

        They count as processed. With each stands whether it is to come with a new snapshot; what
        it had says no more.
        """
        if self._first is None:
            return 0, []
        changed = len(self._units) - self._first
        first, self._first = self._first, None
        self.wrenches = self.joints = 0
        while self._units[first].before is None:
            first -= 1
        units = list(islice(self._units, first, None))
        dense = len(units) - DENSE
        return changed, [(unit, i >= dense or not i % STRIDE) for i, unit in enumerate(units)]
