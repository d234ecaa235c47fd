"""Puts wrenches and orientations where they belong, and goes back over what came before."""

from collections import Counter, deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from peg_on_hole_ros.config.options import Configuration, JointInput
from peg_on_hole_ros.engine import arrival_order
from peg_on_hole_ros.engine.findings import Findings
from peg_on_hole_ros.engine.history import History, Unit
from peg_on_hole_ros.engine.kept import Kept
from peg_on_hole_ros.engine.processor import Processor
from peg_on_hole_ros.estimator.held_peg import HeldPeg
from peg_on_hole_ros.monitor.memory import IN_AIR, NO_STAMP, THREE_POINT
from peg_on_hole_ros.monitor.output_row import AT, DOUBTS, FLAG, MODE
from peg_on_hole_ros.monitor.while_in_doubt import doubt
from peg_on_hole_ros.records import AngleMeasurement, Rows, WrenchSample

# A tare takes wrenches of this time at least, and so many of them where they are to be had.
LEAST_NS = 100_000_000
FEWEST = 100
# Kept for it: this time at 40 kHz.
RECENT = 4096


class Placing:
    """
    The estimate, what waits for it, and what can be gone back over.

    Parameters
    ----------
    configuration : Configuration
    make : callable
        Makes the filter, see `Processor`.
    counts : Counter
        Counted up: fates that arrival decides. Those that going back decides anew are the
        processor's.
    offline : bool
        See `Findings`.

    Attributes
    ----------
    processor : Processor
    findings : Findings
    history : History
    order : record of arrival_order.ORDER
    waiting : deque of AngleMeasurement
        Orientations ahead of the wrench of their time, in order.
    measured : AngleMeasurement or None
        The latest orientation that was taken.
    recent : deque of WrenchSample
        The latest wrenches.
    told : tuple of int and ndarray, or None
        Stamp [ns] and row of the last wrench, where that gave one.
    room : Kept or None
        Where states are kept to go back to, once orientations have been late in a run.

    """

    def __init__(
        self,
        configuration: Configuration,
        make: Callable[..., HeldPeg],
        counts: Counter[str],
        offline: bool = False,
    ) -> None:
        self.configuration, self._make, self._counts = configuration, make, counts
        self.processor = Processor(configuration, make)
        self.findings = Findings(configuration, self.processor.reduction, counts, offline)
        self.room: Kept | None = None
        self._orders = [arrival_order.new_order(configuration) for _ in range(2)]
        self._now_ns = [order["now_ns"] for order in self._orders]
        self.history = History(int(self.order["window_ns"]))
        self.waiting: deque[AngleMeasurement] = deque()
        self.recent: deque[WrenchSample] = deque(maxlen=RECENT)
        self.measured: AngleMeasurement | None = None
        self.told: tuple[int, np.ndarray] | None = None
        self._flag = False
        # A wrench that came after a silence.
        self._leap: Unit | None = None

    @property
    def order(self) -> Any:
        """Where the stamps of messages stand, a record of ORDER."""
        return self._orders[0][0]

    @property
    def orders(self) -> np.ndarray:
        """The same as an array of ORDER, shape (1,)."""
        return self._orders[0]

    def ahead(self) -> np.ndarray:
        """Return a copy of it, for messages that are looked at and not yet taken."""
        self._orders[1][:] = self._orders[0]
        return self._orders[1]

    def come_to(self) -> None:
        """Take the copy for the order."""
        self._orders.reverse()
        self._now_ns.reverse()

    def restart(self) -> None:
        """Begin anew with the next orientation; what was learnt stays."""
        self.processor.restart()
        # What was put in its place since the last wrench waits for the next one, as what is ahead.
        self._counts["wrench_dropped_restart"] += self.history.wrenches
        self._counts["joints_dropped_restart"] += self.history.joints + len(self.waiting)
        self.history.clear()
        arrival_order.restart(self.order)
        self.told = self.measured = None
        self.waiting.clear()
        self.recent.clear()
        self.findings.restart()

    def start(self, measurement: AngleMeasurement) -> None:
        """Start from an orientation."""
        self.processor.start(measurement)
        self.measured = measurement

    def wait(self, measurement: AngleMeasurement) -> None:
        """Let an orientation wait for the wrench of its time."""
        waiting = self.waiting
        if waiting and measurement.t_ns < waiting[-1].t_ns:
            self.waiting = deque(sorted([*waiting, measurement], key=lambda each: each.t_ns))
        else:
            waiting.append(measurement)
        if len(self.waiting) > arrival_order.MAX_WAITING:
            self.waiting.popleft()
            self._counts["joints_dropped_without_wrench"] += 1

    def correct(self, measurement: AngleMeasurement, lateness: float) -> None:
        """Correct by an orientation that was so late [s], where nothing is gone back to for it."""
        self._note(measurement)
        if not lateness:
            self.history.add_after(measurement)
        if lateness or not self.history.changed:
            self.processor.correct(measurement, lateness)

    def put_joints(self, measurement: AngleMeasurement) -> None:
        """Put a late orientation in its place."""
        self._note(measurement)
        self.history.put_joints(measurement)

    def _note(self, measurement):
        if self.measured is None or measurement.t_ns > self.measured.t_ns:
            self.measured = measurement

    def take_wrench(self, sample: WrenchSample, now_ns: int, leaps: bool) -> np.ndarray | None:
        """
        Take a wrench that comes in order; return its row, or None where nothing is told.

        Parameters
        ----------
        sample : WrenchSample
        now_ns : int
            Stamp that the estimate had come to [ns].
        leaps : bool
            Whether it may have to be taken back.

        """
        self.recent.append(sample)
        self.findings.pass_by(sample)
        self.catch_up()
        joints = []
        while self.waiting and self.waiting[0].t_ns <= sample.t_ns:
            joints.append(self.waiting.popleft())
        if joints:
            self.measured = joints[-1]
        if self.findings.due(sample.t_ns) and self.diagnose(sample):
            arrival_order.forget(self.order, now_ns, sample.t_ns)
            leaps = False
        wanted = leaps or self.history.wants_snapshot
        unit = Unit(sample, joints, self.processor.snapshot() if wanted else None, now_ns)
        self._leap = unit if leaps else None
        self.history.append(unit)
        row = self.processor.process(unit)
        if row is None:
            self.told = None
        else:
            self._tell_one(sample.t_ns, row)
        return row

    def take_back(self) -> None:
        """
        Undo the wrench that had leapt ahead: the next one goes on from before it.

        It was no silence then, but a stamp that was wrong. What was given out of it stays.
        """
        assert self._leap is not None
        self.processor.restore(self._leap.before)
        self.waiting.extendleft(reversed(self.history.take_back()))
        self.recent.pop()
        arrival_order.take_back(self.order, [each.t_ns for each in self.waiting])
        self._counts["wrench_dropped_ahead"] += 1

    def catch_up(self) -> None:
        """Process again from where the first late message was put; its outputs are not given."""
        changed, units = self.history.take_changed()
        if not units:
            return
        self.went_back(1, changed)
        processor, begin_ns = self.processor, units[0][0].begin_ns
        processor.restore(units[0][0].before)
        for unit, with_snapshot in units:
            unit.before = processor.snapshot() if with_snapshot else None
            unit.begin_ns, begin_ns = begin_ns, unit.wrench.t_ns
            processor.process(unit)

    def went_back(self, times: int, wrenches: int) -> None:
        """Count how often the estimate went back, and the wrenches that it took again."""
        self._counts["went_back"] += times
        self._counts["wrench_reprocessed"] += wrenches

    def forget_past(self) -> None:
        """Take all that has come by the present settings; it cannot be gone back to by others."""
        self.catch_up()
        self.history.clear()
        arrival_order.forget(self.order, self.now_ns)

    def tell(self, rows: Rows) -> None:
        """Take note of rows that are told, of which nothing sure may be left."""
        if self.findings.unsure:
            self._counts["contact_doubted"] += len(rows.t_ns)
            doubt(rows.values, self._flag)
        self.findings.count(len(rows.t_ns))
        rests = rows.values[:, MODE, None] == THREE_POINT
        rows.values[:, DOUBTS] = np.where(rests, self.findings.costs, np.nan)
        self.told = int(rows.t_ns[-1]), rows.values[-1]
        self._flag = bool(rows.values[-1, FLAG])

    def _tell_one(self, t_ns, row):
        """Do what `tell` does with one row, in a fifth of the time."""
        if self.findings.unsure:
            return self.tell(Rows(np.array([t_ns]), row.reshape(1, -1)))
        self.findings.count(1)
        row[DOUBTS] = self.findings.costs if row[MODE] == THREE_POINT else np.nan
        self.told = t_ns, row
        self._flag = bool(row[FLAG])

    def diagnose(self, sample: WrenchSample) -> bool:
        """Hold a wrench against the settings; return whether others are used from here on."""
        if self.measured is None or self.processor.is_saturated:
            return False
        in_air = None if self.told is None else bool(self.told[1][MODE] == IN_AIR)
        still = self.processor.wrench_stands_still
        row = None if self.told is None else self.told[1]
        if row is not None and row[MODE] == THREE_POINT:
            known = row[AT.reactions_determined] == 1.0
            self.findings.take_estimate(sample.t_ns, self.processor.filter, known)
        else:
            self.findings.lift()
        other = self.findings.take(sample, self.measured, still, in_air)
        if other:
            self.rebuild()
        return other

    def rebuild(self) -> None:
        """Begin anew from the latest orientation, by other settings of the wrench."""
        self.configuration = self.findings.as_found(self.configuration)
        self._counts.update(self.processor.counts)
        self.processor, self.room = Processor(self.configuration, self._make), None
        if self.measured is not None:
            self.processor.start(self.measured)
            # It was used before.
            self._counts["joints_used"] -= 1
        reduction = self.processor.reduction
        self.findings.look(self.configuration, reduction, reduction.taken_off)
        # What came before cannot be processed again by another setting.
        self.history.clear()

    def retune(self, configuration: Configuration) -> None:
        """Take other settings from here on, of those that a node takes while it is active."""
        self.forget_past()
        restated = self.findings.restate(configuration.wrench)
        self.configuration = self.findings.as_found(configuration)
        self.processor.retune(self.configuration)
        if restated:
            reduction = self.processor.reduction
            self.findings.look(self.configuration, reduction, reduction.taken_off)

    def describe(self, joints: JointInput) -> None:
        """Take what the robot's description makes known."""
        self.configuration = replace(self.configuration, joints=joints)

    def tare(self, samples: Sequence[WrenchSample]) -> np.ndarray:
        """Take the mean of wrenches as that of a free-hanging peg; return what is taken off."""
        # Wrenches before a tare cannot be processed again after it.
        self.forget_past()
        taken = self.processor.tare(samples)
        self.findings.forget_zero()
        self.findings.look(self.configuration, self.processor.reduction, taken)
        return taken

    @property
    def started(self) -> bool:
        """Whether there was an orientation to start from."""
        return self.now_ns != NO_STAMP

    @property
    def now_ns(self) -> int:
        """Stamp that the estimate has come to, once started [ns]."""
        return self._now_ns[0].item()
