"""What a report draws of the outputs and of the truth: columns over time, modes, peak loads."""

from collections.abc import Sequence
from math import isfinite, nan, pi
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.bags.estimates import Estimate
from peg_on_hole_ros.bags.truth import BOUND_STDDEVS, RecordedTruth
from peg_on_hole_ros.messages.columns import OutputColumns
from peg_on_hole_ros.messages.passed_time import PassedTime, StampRun
from peg_on_hole_ros.monitor.output_row import MONITOR_NAMES
from peg_on_hole_ros.plots.turns import turn_stddev
from peg_on_hole_ros.records import ANGLES, CONTACTS, SIX_QUANTITIES
from peg_on_hole_ros.report.thinning import ThinnedRows, most_loaded, thinned

# Scalars of the monitor that are drawn, where they are there; those with a deviation have a band.
LEARNT = ("friction", "clearance")
_MICRO = {"clearance": 1e6}  # of a metre
SCALARS = (
    *(name for name in MONITOR_NAMES if name.startswith("jamming_")),
    *("transition_probability", "three_point_validity"),
    *("nis_median", "nis_drift"),
)
_MONITORED = (*LEARNT, *(f"{name}_stddev" for name in LEARNT), *SCALARS, "reactions_determined")
_BANDS = (*SIX_QUANTITIES, *LEARNT)
TRACK_COLUMNS = (
    *(name + end for name in _BANDS for end in ("", "_low", "_high")),
    *SCALARS,
)
SNAPSHOT_COLUMNS = (
    "load",
    *ANGLES,
    *("psi_stddev", "phi_stddev"),
    *("x", "y", "z"),
    *(axis + "_" + contact for contact in CONTACTS for axis in ("X", "Y", "Z")),
    *CONTACTS,
    *(f"{contact}_stddev" for contact in CONTACTS),
    *(f"{contact}_closed" for contact in CONTACTS),
    *("friction", "jamming_risk"),
)
MOST_DRAWN = 6_000  # rows of a plot: more than a screen has pixels
MOST_MOMENTS = 2_400  # of the drawing


class PeakReaction(NamedTuple):
    """The greatest reaction at a contact: value and standard deviation [N], passed time [ns]."""

    normal: float
    stddev: float
    t_ns: int


class Tracks:
    """
    Collects outputs; as many as come, thinned so that peaks stay.

    Time is what has passed since the first: where stamps fall it goes on from where it was.

    Attributes
    ----------
    modes : list of (int, str)
        Passed time [ns] and the contact mode from there on.
    flags : list of (int, bool)
        The same of the transition.
    peaks : dict of str to PeakReaction
        Where reactions are determined; a contact without is not there.

    """

    def __init__(self) -> None:
        self.modes: list[tuple[int, str]] = []
        self.flags: list[tuple[int, bool]] = []
        self.peaks: dict[str, PeakReaction] = {}
        self._time = PassedTime()
        self._rows = ThinnedRows(len(TRACK_COLUMNS))
        self._moments = ThinnedRows(len(SNAPSHOT_COLUMNS), most_loaded)
        self._turned = [0.0, 0.0]
        self._before: tuple[float, float] | None = None
        self._resting = self._unknown = 0

    @property
    def undetermined(self) -> float | None:
        """Share of three-point contact in which reactions are not determined; None: had none."""
        return self._unknown / self._resting if self._resting else None

    @property
    def runs(self) -> list[StampRun]:
        """Stamps from one fall to the next."""
        return self._time.runs

    @property
    def passed_ns(self) -> int:
        """Time that has passed up to the latest estimate [ns]."""
        return self._time.ns

    def take(self, columns: OutputColumns) -> None:
        """Take the outputs of stamps that rise."""
        values = np.hstack([columns["state"][:, :3], columns.normal]).tolist()
        stddev = np.hstack([columns["state_stddev"][:, :3], columns["normal_stddev"]]).tolist()
        forces = columns.force.reshape(len(columns), -1).tolist()
        monitor = np.column_stack([columns[name] for name in _MONITORED]).tolist()
        rows = zip(
            columns.t_ns.tolist(),
            values,
            stddev,
            (dict(zip(_MONITORED, numbers)) for numbers in monitor),
            columns["position"].tolist(),
            forces,
            columns["closed"].tolist(),
        )
        for row, mode, flag in zip(rows, columns.modes, columns["transition"].tolist()):
            known = self._take(*row)
            self._declare(mode, flag)
            self._count(known)

    def add_recorded(self, estimate: Estimate) -> None:
        """Take an estimate that was read with all its messages."""
        messages = {name: message for name, (_, message) in estimate.messages.items()}
        pose = messages.get("pose")
        place = pose.pose.pose.position if pose else None
        forces = [messages.get(f"contact/{name.lower()}") for name in CONTACTS]
        known = self._take(
            estimate.t_ns,
            (*estimate.values[:3], *estimate.values[6:9]),
            (*estimate.stddev[:3], *estimate.stddev[6:9]),
            estimate.monitor,
            (place.x, place.y, place.z) if place else (nan,) * 3,
            [
                getattr(force.wrench.force, axis) if force else nan
                for force in forces
                for axis in "xyz"
            ],
            messages["contacts"].position,
        )
        self._declare(estimate.mode, estimate.transition)
        self._count(known)

    def _count(self, known):
        if self.modes and self.modes[-1][1] == "three_point":
            self._resting += 1
            self._unknown += not known

    def _declare(self, mode, flag):
        passed = self.passed_ns
        for changes in (self.modes, self.flags):
            # A stamp that was wrong had leapt ahead.
            while len(changes) > 1 and changes[-1][0] > passed:
                changes.pop()
        if mode and (not self.modes or self.modes[-1][1] != mode):
            self.modes.append((passed, mode))
        if flag is not None and (not self.flags or self.flags[-1][1] != flag):
            self.flags.append((passed, flag))

    def _take(self, t_ns, values, stddev, monitor, place, forces, closed):
        self._time.take(t_ns)
        passed = self.passed_ns
        gamma, psi, phi, *normal = values
        # In free air no contact carries anything, and that is known.
        known = monitor.get("reactions_determined", 1.0) != 0.0 or not any(stddev[3:])
        known = known and all(map(isfinite, normal))
        normal = [n if known else nan for n in normal]
        values = (gamma, *self._unwrapped(psi, phi), *normal)
        row = []
        for i, (value, deviation) in enumerate(zip(values, stddev)):
            if 0 < i < len(ANGLES) and not isfinite(turn_stddev(deviation)):
                value = nan
            row += (value, value - BOUND_STDDEVS * deviation, value + BOUND_STDDEVS * deviation)
        for name in LEARNT:
            unit = _MICRO.get(name, 1.0)
            # What is stated to be known is not learnt.
            spread = BOUND_STDDEVS * unit * (monitor.get(name + "_stddev", nan) or nan)
            value = unit * monitor.get(name, nan) + 0.0 * spread
            row += (value, value - spread, value + spread)
        self._rows.add(passed, (*row, *(monitor.get(name, nan) for name in SCALARS)))
        self._note_peaks(passed, normal, stddev[3:])
        load = sum(n for n in normal if isfinite(n))
        forces = forces if known else [nan] * 9
        turns = map(turn_stddev, stddev[1:3])
        moment = (load, gamma, psi, phi, *turns, *place, *forces, *normal, *stddev[3:], *closed)
        told = monitor.get("friction", nan), monitor.get("jamming_risk", nan)
        self._moments.add(passed, (*moment, *told))
        return known

    def _unwrapped(self, psi, phi):
        if self._before is not None:
            for i, (angle, before) in enumerate(zip((psi, phi), self._before)):
                self._turned[i] -= 2 * pi * round((angle - before) / (2 * pi))
        self._before = psi, phi
        return psi + self._turned[0], phi + self._turned[1]

    def _note_peaks(self, passed, normal, stddev):
        for name, value, deviation in zip(CONTACTS, normal, stddev):
            if value > self.peaks.get(name, (0.0,))[0]:
                self.peaks[name] = PeakReaction(value, deviation, passed)

    def columns(self, most: int = MOST_DRAWN) -> dict[str, np.ndarray]:
        """Return `t` [s] and TRACK_COLUMNS, those alone that have a number anywhere."""
        return named(*self._rows.arrays(most), TRACK_COLUMNS)

    def moments(self) -> dict[str, np.ndarray]:
        """Return `t` [s] and SNAPSHOT_COLUMNS of whole rows: of near ones the most loaded."""
        t_ns, values = self._moments.arrays(MOST_MOMENTS)
        return {"t": t_ns * 1e-9, **dict(zip(SNAPSHOT_COLUMNS, values.astype(float).T))}


def named(t_ns: np.ndarray, values: np.ndarray, names: Sequence[str]) -> dict[str, np.ndarray]:
    """Return times as `t` [s] and the columns by name; one without any number is left out."""
    found = {"t": t_ns * 1e-9}
    for name, column in zip(names, values.astype(float).T):
        if np.isfinite(column).any():
            found[name] = column
    return found


def true_columns(
    truth: RecordedTruth, runs: list[StampRun], estimate: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """
    Return `t` [s] and SIX_QUANTITIES as they truly were.

    Parameters
    ----------
    truth : RecordedTruth
    runs : list of StampRun
        Of the outputs.
    estimate : dict of str to ndarray
        Columns of the outputs: the turns of the truth are drawn beside theirs.

    """
    times, rows = [], []
    for run in runs:
        inside = (run.first_ns <= truth.t_ns) & (truth.t_ns <= run.last_ns)
        if not inside.any():
            continue
        t_ns, values = run.passed(truth.t_ns[inside]), truth.values[inside].copy()
        for i, name in ((1, "psi"), (2, "phi")):
            if name in estimate:
                known = np.isfinite(estimate[name])
                beside = np.interp(t_ns[0] * 1e-9, estimate["t"][known], estimate[name][known])
                values[:, i] += 2 * np.pi * np.round((beside - values[0, i]) / (2 * np.pi))
        times.append(t_ns)
        rows.append(values)
    if not times:
        return {"t": np.empty(0)}
    return named(*thinned(np.concatenate(times), np.concatenate(rows), MOST_DRAWN), SIX_QUANTITIES)
