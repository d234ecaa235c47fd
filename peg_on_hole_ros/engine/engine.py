"""Messages in any order in, rows of outputs out: order, ring, and the `Processor` behind them."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant
from peg_on_hole_ros.engine import arrival_order, ring
from peg_on_hole_ros.engine.arrival_order import COUNTED, Fate
from peg_on_hole_ros.engine.processor import Processor
from peg_on_hole_ros.engine.push import (
    BatchProgress,
    EngineMemory,
    Filled,
    Phase,
    Stop,
    catch_up,
    push,
    room_for,
)
from peg_on_hole_ros.engine.settings_against_data import SettingsAgainstData
from peg_on_hole_ros.engine.snapshots import in_use
from peg_on_hole_ros.engine.tuned import REPROCESSING
from peg_on_hole_ros.estimator.methods.method import Make
from peg_on_hole_ros.measurements.repeats import Runs
from peg_on_hole_ros.measurements.tuned import STANDING_WRENCH
from peg_on_hole_ros.monitor.output_view import OutputView
from peg_on_hole_ros.monitor.states import NO_STAMP, Mode
from peg_on_hole_ros.monitor.while_in_doubt import withhold
from peg_on_hole_ros.records import AngleMeasurement, Arrivals, Rows, WrenchSample
from peg_on_hole_ros.typed_record import dtype_of

# What is given in one go has stamps that rise.
_ENDS = Stop.END, Stop.UNSOUND, Stop.ENOUGH, Stop.RESTART
# What a filter in Python does in the course of a wrench.
_BY_HAND = Stop.START, Stop.CORRECT, Stop.WRENCH
# Modes that show neither a peg in the air nor one on the hole.
_NOT_ON_HOLE = Mode.ELSEWHERE, Mode.UNKNOWN


class Engine:
    """
    Processes messages as they arrive, whatever their order; tests the settings by them.

    Joint states wait until the wrench of their stamp is there, so that every prediction runs
    under a wrench that was measured at its end. A late message is put in its place, and all since
    is processed again when the next wrench comes; what was given out before stays as it is. One
    stamp alone is no clock: one far back is late, a wrench far ahead of the next is taken back.

    Parameters
    ----------
    configuration : Configuration
    make : callable
        Makes the filter, see `Processor`.
    counts : Counter
        Counted up: what looks at the settings, and requests.
    offline : bool
        See `SettingsAgainstData`.

    Attributes
    ----------
    processor : Processor
    settings_against_data : SettingsAgainstData
    latest : OutputView or None
        Of the last wrench, where that gave some.

    """

    def __init__(
        self,
        configuration: Configuration,
        make: Make,
        counts: Counter[str],
        offline: bool = False,
    ) -> None:
        self.configuration, self._make, self._counts = configuration, make, counts
        self.processor = Processor(configuration, make)
        self.settings_against_data = SettingsAgainstData(
            configuration, self.processor.reduction, counts, offline
        )
        self._order = arrival_order.new_order(configuration)
        self._ring = ring.new_ring(self.processor.filter.state)
        self._batch = np.zeros(1, dtype_of(BatchProgress))
        self._runs = Runs()
        self.latest: OutputView | None = None
        self._flag = self._stands_beside = False

    @property
    def _memory(self) -> EngineMemory:
        p = self.processor
        return EngineMemory(p.memory, p.words, p.rules_memory, self._order, self._ring)

    @property
    def counts(self) -> Counter[str]:
        """What became of messages by their order, and how often the estimate went back."""
        found: Counter[str] = Counter()
        fates = self._batch[0]["fates"].tolist()
        for fate, name in COUNTED.items():
            found[name] += fates[fate]
        r = self._ring.places[0]
        # If a wrench has shown that the clock jumped, it is dropped.
        found["wrench_dropped_late"] += fates[Fate.WRENCH_RESTARTS]
        found["went_back"], found["wrench_reprocessed"] = (
            int(r["went_back"]),
            int(r["reprocessed"]),
        )
        found["joints_dropped_without_wrench"] = int(r["without_wrench"])
        found["wrench_dropped_ahead"] = int(r["ahead"])
        return +found

    @property
    def started(self) -> bool:
        """Whether there was an orientation to start from."""
        return int(self._order[0]["now_ns"]) != NO_STAMP

    @property
    def taken(self) -> int:
        """How many wrenches came in order in the last `push`."""
        return int(self._batch[0]["taken"])

    @property
    def kept(self) -> tuple[int, int]:
        """How many wrenches, and how many snapshots before them, are kept for late messages."""
        r = self._ring.places[0]
        return int(r["last"] - r["first"]), in_use(self._ring.snapshots)

    @property
    def measured(self) -> AngleMeasurement | None:
        """The newest orientation whose time has come."""
        r = self._ring.places[0]
        t_ns = int(r["measured_ns"])
        return None if t_ns == NO_STAMP else AngleMeasurement.of_row(t_ns, r["measured"])

    @property
    def recent(self) -> list[WrenchSample]:
        """The latest wrenches."""
        return [WrenchSample.of_row(t_ns, row) for t_ns, row in zip(*ring.recent(self._ring))]

    def push(
        self, arrivals: Arrivals, begin: int = 0, most: int = REPROCESSING.most_messages
    ) -> tuple[int, Rows]:
        """
        Process messages from an index on, so many of them at once.

        What is given has stamps that rise: one of before the newest is taken by itself.

        Parameters
        ----------
        arrivals : Arrivals
        begin : int
        most : int
            How many wrenches are taken that come in order.

        Returns
        -------
        end : int
            Place of the first that is not taken.
        rows : Rows
            What they give.

        """
        batch = self._batch[0]
        end = begin + REPROCESSING.most_messages
        if end < len(arrivals.t_ns):
            arrivals = arrivals._replace(
                of_wrench=arrivals.of_wrench[:end], t_ns=arrivals.t_ns[:end]
            )
        before = np.count_nonzero(arrivals.of_wrench[:begin]) if begin else 0
        given = room_for(int(np.count_nonzero(arrivals.of_wrench)) - int(before))
        batch["begin"] = begin
        batch["place"], batch["wrench"] = begin, before
        batch["rows"] = batch["taken"] = 0
        batch["most"] = most
        seen, arrived, stop = (0, 0), begin, Stop.LOOK
        while stop not in _ENDS:
            batch["by_hand"] = not self.processor.in_one_piece
            batch["due_ns"], batch["due_until_ns"] = self.settings_against_data.due
            stop = Stop(push(self._memory, self._batch, arrivals, given))
            if stop not in _BY_HAND:
                seen = self._note(arrivals, given, *seen)
            arrived = self._arrive(arrivals, arrived)
            self._do(stop, arrivals, given)
        self._arrive(arrivals, arrived)
        some = slice(int(batch["rows"]))
        return int(batch["place"]), Rows(given.t_ns[some], given.rows[some])

    def _arrive(self, arrivals: Arrivals, before: int) -> int:
        """Hand on which messages came since so many; return how many there are now."""
        now = int(self._batch[0]["place"])
        if now > before:
            some = slice(before, now)
            joints = ~arrivals.of_wrench[:now]
            read = arrivals.positions[np.count_nonzero(joints[:before]) : np.count_nonzero(joints)]
            self.settings_against_data.take_arrivals(
                arrivals.of_wrench[some], arrivals.t_ns[some], read
            )
        return now

    def _note(self, arrivals: Arrivals, given: Filled, taken: int, rows: int) -> tuple[int, int]:
        """Hand on what came since so many wrenches and rows; return how many there are now."""
        now = int(self._batch[0]["taken"]), int(self._batch[0]["rows"])
        if now[0] > taken:
            t_ns, which = given.taken_ns[taken : now[0]], given.taken[taken : now[0]]
            wrenches = arrivals.wrenches[which]
            news = self._runs.take(wrenches) <= STANDING_WRENCH.fewest
            self.settings_against_data.take_every_wrench(t_ns[news], wrenches[news])
        if now[1] > rows:
            some = slice(rows, now[1])
            self._note_rows(Rows(given.t_ns[some], given.rows[some]))
        if not self._batch[0]["newest_has_row"]:
            self.latest = None
        return now

    def _note_rows(self, rows):
        """Record rows; while a setting is in doubt, what rests on it is withheld."""
        # Of an upright peg the estimate may be below zero by its noise; a tilt is not.
        tilt = rows.values["state"][:, 0]
        np.maximum(tilt, 0.0, out=tilt)
        if self.settings_against_data.unsure:
            self._counts["contact_doubted"] += len(rows.t_ns)
            withhold(rows.values, self._flag)
        elif self.settings_against_data.withholds:
            self._counts["reactions_withheld"] += len(rows.t_ns)
            rows.values["reactions_determined"] = 0.0
        self.settings_against_data.count(len(rows.t_ns))
        reaction_errors = self.settings_against_data.reaction_errors
        if reaction_errors is not None:
            rests = rows.values["contact_mode"] == Mode.THREE_POINT
            rows.values["doubt"] = np.where(rests[:, None], reaction_errors, np.nan)
        self.latest = OutputView(int(rows.t_ns[-1]), rows.values[-1])
        self._flag = self.latest.transition

    def _do(self, stop: Stop, arrivals: Arrivals, given: Filled) -> None:
        """Do what has to be done before messages are taken any further."""
        batch, processor = self._batch[0], self.processor
        place, wrench = int(batch["place"]), int(batch["wrench"])
        if stop == Stop.LOOK:
            sample = WrenchSample.of_row(arrivals.t_ns[place], arrivals.wrenches[wrench])
            if self._look(sample):
                # What came before cannot be processed again by another setting.
                ring.empty(self._ring, int(batch["from_ns"]))
                self._order[0]["leap_ns"], batch["fate"] = NO_STAMP, Fate.TAKEN
        elif stop == Stop.RESTART:
            self.restart()
            # A wrench that shows a jump is dropped; an orientation is one to start from.
            batch["place"] += arrivals.of_wrench[place]
            batch["wrench"] += arrivals.of_wrench[place]
        elif stop in (Stop.START, Stop.CORRECT):
            t_ns, row = int(arrivals.t_ns[place]), arrivals.orientations[place - wrench]
            if stop == Stop.START:
                processor.start(AngleMeasurement.of_row(t_ns, row))
            else:
                processor.correct(t_ns, row, float(batch["lateness"]))
        elif stop == Stop.WRENCH:
            self._take_by_hand(given)

    def _take_by_hand(self, given):
        batch, unit = self._batch[0], ring.unit_of(self._ring, int(self._batch[0]["unit"]))
        row = given.rows[int(batch["rows"])]
        batch["has_row"] = self.processor.take_wrench(unit, row)

    def _look(self, sample: WrenchSample) -> bool:
        """Test the settings by a wrench; return whether others are used from here on."""
        measured = self.measured
        if measured is None or self.processor.is_saturated:
            return False
        latest = self.latest
        if latest is not None and latest.row["contact_mode"] == Mode.THREE_POINT:
            known = latest.row["reactions_determined"] == 1.0
            self.settings_against_data.take_estimate(sample.t_ns, self.processor.filter, known)
        else:
            self.settings_against_data.leave_three_contacts()
        p, mode = self.processor, None if latest is None else Mode(int(latest.row["contact_mode"]))
        in_air = None if mode is None else mode == Mode.OPEN
        # A peg that slides from the plate to the hole's edge is where it would touch the hole. It
        # still stands beside, until it is lifted or a contact with the hole is published.
        stays = self._stands_beside and p.may_touch and mode in _NOT_ON_HOLE
        self._stands_beside = p.is_beside_hole or stays
        instant = Instant(sample, measured, p.standing, in_air, self._stands_beside, p.is_misfit)
        changed = self.settings_against_data.take(instant)
        self.processor.widen_orientations(self.settings_against_data.joints_variance)
        if changed:
            self._use_found()
            return True
        jump = self.settings_against_data.take_zero_jump()
        if jump is None:
            return False
        self._counts["zero_jumped"] += 1
        self.processor.shift_zero(jump, measured)
        self._look_anew()
        return True

    def _look_anew(self):
        """Look at what comes from here on by the present settings and zero."""
        reduction = self.processor.reduction
        self.settings_against_data.look(self.configuration, reduction, reduction.taken_off)

    def _use_found(self):
        """Begin anew from the newest orientation, by other settings of the wrench."""
        self.configuration = self.settings_against_data.with_findings(self.configuration)
        self._counts.update(self.processor.counts)
        self.processor = Processor(self.configuration, self._make)
        self.processor.widen_orientations(self.settings_against_data.joints_variance)
        self._ring = ring.with_room(self._ring, self.processor.filter.state)
        measured = self.measured
        if measured is not None:
            self.processor.start(measured)
            # It was used before.
            self._counts["joints_used"] -= 1
        self._look_anew()

    def set_sensor_pose(
        self, xyz: tuple[float, float, float], rpy: tuple[float, float, float]
    ) -> None:
        """Use another pose of the sensor, before the first wrench [m], [rad]."""
        self.settings_against_data.set_sensor_pose(xyz, rpy)
        self._use_found()
        ring.empty(self._ring, int(self._ring.places[0]["kept_from_ns"]))

    def restart(self) -> None:
        """Begin anew with the next orientation; what was learnt stays."""
        self.processor.restart()
        # Of a message in which an error ended a step nothing more is taken.
        self._batch[0]["phase"] = Phase.ARRIVES
        # What was put in its place since the last wrench waits for the next one, as what is ahead.
        r = self._ring.places[0]
        waiting = int(r["joints_last"]) - ring.begin_of_waiting(self._ring)
        self._counts["wrench_dropped_restart"] += int(r["late_wrenches"])
        self._counts["joints_dropped_restart"] += int(r["late_joints"]) + waiting
        ring.restart(self._ring)
        arrival_order.restart(self._order[0])
        self.latest = None
        self.settings_against_data.restart()

    def reset(self) -> None:
        """Restart, and forget what was learnt; no stamp is published twice."""
        last_ns = int(self._order[0]["last_wrench_ns"])
        self.restart()
        self._order[0]["last_wrench_ns"] = last_ns
        self.processor.forget()

    def tare(self, samples: Sequence[WrenchSample]) -> np.ndarray:
        """
        Take the mean of wrenches as that of a free-hanging peg; return what is taken off.

        Of a zero that nobody had taken, what was estimated before rests on it: it is forgotten.
        """
        # Wrenches before a tare cannot be processed again after it.
        self._forget_past()
        begins = self.settings_against_data.zero_open_ns > 0
        taken = self.processor.tare(samples)
        if begins:
            self.reset()
        self.settings_against_data.forget_zero()
        self.settings_against_data.look(
            self.configuration, self.processor.reduction, taken, tared=True
        )
        return taken

    def retune(self, configuration: Configuration) -> None:
        """Use other settings from here on, of those that may change while a node is active."""
        self._forget_past()
        restated = self.settings_against_data.restate(configuration.wrench)
        self.configuration = self.settings_against_data.with_findings(configuration)
        self.processor.retune(self.configuration)
        if restated:
            self._look_anew()

    def use_robot_description(self, configuration: Configuration) -> None:
        """Use what the robot's description makes known, before the first message is used."""
        self.configuration = configuration
        self._use_found()

    def _forget_past(self):
        """Process all that has come by the present settings; others cannot go back to it."""
        given = room_for(1)
        self._batch[0]["rows"] = 0
        self._batch[0]["by_hand"] = not self.processor.in_one_piece
        while catch_up(self._memory, self._batch, given) == Stop.WRENCH:
            self._take_by_hand(given)
        order = self._order[0]
        order["leap_ns"] = NO_STAMP
        ring.empty(self._ring, int(order["now_ns"]))
