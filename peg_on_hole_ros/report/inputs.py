"""What a report draws of the messages that came in: wrenches, gaps, orientations."""

from math import pi
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.messages.columns import OutputColumns
from peg_on_hole_ros.messages.stream import orientation_of
from peg_on_hole_ros.records import AngleMeasurement, Arrivals, JointSample, WrenchSample
from peg_on_hole_ros.report.thinning import ThinnedRows
from peg_on_hole_ros.report.tracks import MOST_DRAWN, Tracks, named

WRENCH_COMPONENTS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
# A measurement is held against an estimate no further from it [ns]: rates do not last.
_NEAR_NS = 100_000_000
# Width of what is held of an orientation: angles and their covariance.
_ORIENTATION = 12
_MOST_WAITING = 10_000
# The stamp of a wrench that was before all others [ns].
_BEFORE_ALL = np.iinfo(np.int64).min


class _Waiting(NamedTuple):
    """
    Rows of a table that wait for an output.

    Attributes
    ----------
    name : str
        Of the table.
    t_ns : ndarray of int64, shape (n,)
        Stamps [ns].
    rows : ndarray, shape (n, width)
    behind_ns : ndarray of int64, shape (n,)
        The first output of a later stamp is the first after they came [ns].

    """

    name: str
    t_ns: np.ndarray
    rows: np.ndarray
    behind_ns: np.ndarray


class Inputs:
    """
    Watches what a replay reads, beside the outputs that come of it.

    Messages wait for the next output: its stamp says what time has passed.

    Parameters
    ----------
    configuration : Configuration
    tracks : Tracks
        Of the same outputs; is given each of them before this is.

    """

    def __init__(self, configuration: Configuration, tracks: Tracks) -> None:
        self._tracks = tracks
        self._orientation = orientation_of(configuration)
        self._delay_ns = round(configuration.joints.delay * 1e9)
        self._rows = {
            "wrench": ThinnedRows(len(WRENCH_COMPONENTS)),
            "innovations": ThinnedRows(1),
            "wrench_interval": ThinnedRows(1),
            "joints_interval": ThinnedRows(1),
        }
        self._latest = dict.fromkeys(self._rows, 0)
        self._last_ns: dict[str, int] = {}
        self._waiting: list[_Waiting] = []
        # Orientations that wait for an output that has taken them: stamp, stamp of the wrench
        # before them, and row.
        self._stamps = self._behind = np.empty(0, np.int64)
        self._measured = np.empty((0, _ORIENTATION))
        self._wrench_ns = _BEFORE_ALL

    def read(self, sample: object) -> None:
        """Take a wrench or a joint state; one that cannot be read is left out."""
        if isinstance(sample, WrenchSample):
            row = np.array([[*sample.force, *sample.torque]])
            self._take_wrenches(np.array([sample.t_ns]), row, np.array([_BEFORE_ALL]))
            self._wrench_ns = sample.t_ns
            return
        if not isinstance(sample, JointSample):
            return
        measured = self._orientation(sample)
        if isinstance(measured, AngleMeasurement):
            t_ns = np.array([sample.t_ns - self._delay_ns])
            self._take_orientations(
                t_ns,
                measured.row.reshape(1, -1),
                np.array([self._wrench_ns]),
                np.array([_BEFORE_ALL]),
            )

    def take_inputs(self, arrivals: Arrivals, begin: int, end: int) -> None:
        """Take messages by their places, all of them sound."""
        of_wrench, t_ns = arrivals.of_wrench[begin:end], arrivals.t_ns[begin:end]
        first = int(np.count_nonzero(arrivals.of_wrench[:begin]))
        last = first + int(np.count_nonzero(of_wrench))
        rows = arrivals.orientations[begin - first : end - last]
        # Of those given at once stamps rise; what came before them all is behind any output.
        wrench_ns = np.concatenate([[_BEFORE_ALL], t_ns[of_wrench]])
        behind_ns = wrench_ns[np.cumsum(of_wrench)[~of_wrench]]
        after = np.where(behind_ns == _BEFORE_ALL, self._wrench_ns, behind_ns)
        self._take_wrenches(t_ns[of_wrench], arrivals.wrenches[first:last], wrench_ns[:-1])
        self._take_orientations(t_ns[~of_wrench], rows, after, behind_ns)
        self._wrench_ns = int(wrench_ns[-1]) if last > first else self._wrench_ns

    def _take_wrenches(self, t_ns, rows, behind_ns):
        self._wait(_Waiting("wrench", t_ns, rows, behind_ns))
        self._note_intervals("wrench", t_ns, behind_ns)

    def _take_orientations(self, t_ns, rows, wrench_ns, behind_ns):
        self._note_intervals("joints", t_ns, behind_ns)
        latest = slice(-_MOST_WAITING, None)
        self._stamps = np.concatenate([self._stamps, t_ns])[latest]
        self._behind = np.concatenate([self._behind, wrench_ns])[latest]
        self._measured = np.concatenate([self._measured, rows[:, :_ORIENTATION]])[latest]

    def _note_intervals(self, source, t_ns, behind_ns):
        if len(t_ns):
            before = np.concatenate([[self._last_ns.get(source, t_ns[0])], t_ns[:-1]])
            self._last_ns[source] = int(t_ns[-1])
            rose = t_ns > before
            intervals = (t_ns - before)[rose, np.newaxis] * 1e-6
            self._wait(_Waiting(f"{source}_interval", t_ns[rose], intervals, behind_ns[rose]))

    def _wait(self, waiting):
        self._waiting.append(waiting)
        del self._waiting[:-_MOST_WAITING]

    def take(self, columns: OutputColumns) -> None:
        """Take the outputs of stamps that rise."""
        t_ns, state = columns.t_ns, columns["state"]
        # The first output that has taken it: of its stamp or after, and of a wrench behind it.
        after = np.searchsorted(t_ns, np.maximum(self._stamps, self._behind + 1))
        there = np.flatnonzero(after < len(t_ns))
        there = there[np.argsort(after[there], kind="stable")]
        self._hold_against(t_ns[after[there]], state[after[there]], there)
        left = after == len(t_ns)
        # One that was wrong, or of a time before the clock was set back, waits no longer.
        left &= np.abs(self._stamps - t_ns[-1]) <= _NEAR_NS
        self._stamps, self._behind = self._stamps[left], self._behind[left]
        self._measured = self._measured[left]
        waiting, self._waiting = self._waiting, []
        for name, stamps, rows, behind_ns in waiting:
            first = np.searchsorted(t_ns, behind_ns, side="right")
            k = int(np.count_nonzero(first < len(t_ns)))
            self._draw(name, stamps[:k], rows[:k], t_ns[first[:k]])
            if k < len(stamps):
                self._wait(
                    _Waiting(name, stamps[k:], rows[k:], np.full(len(stamps) - k, _BEFORE_ALL))
                )

    def _draw(self, name, stamps, rows, output_ns):
        """Draw rows at their stamps: what is late where it came, nothing ahead of its output."""
        if len(stamps):
            run = self._tracks.runs[-1]
            passed = run.passed(np.minimum(stamps, output_ns))
            passed = np.maximum.accumulate(np.maximum(passed, self._latest[name]))
            self._latest[name] = int(passed[-1])
            self._rows[name].add_all(passed, rows)

    def _hold_against(self, t_ns, state, which):
        stamps, rows = self._stamps[which], self._measured[which]
        ahead_ns = stamps - t_ns
        near = np.abs(ahead_ns) <= _NEAR_NS
        error = rows[:, :3] - state[:, :3] - state[:, 3:6] * (ahead_ns * 1e-9)[:, np.newaxis]
        error[:, 1:] -= 2 * pi * np.round(error[:, 1:] / (2 * pi))
        error, covariance = error[near, :, np.newaxis], rows[near, 3:].reshape(-1, 3, 3)
        squared = np.swapaxes(error, 1, 2) @ np.linalg.solve(covariance, error)
        self._draw("innovations", stamps[near], squared.reshape(-1, 1), t_ns[near])

    def tables(self, most: int = MOST_DRAWN) -> dict[str, dict[str, np.ndarray]]:
        """Return columns by table and name: the wrench [N], [N m], `squared`, `interval` [ms]."""
        columns = {"wrench": WRENCH_COMPONENTS, "innovations": ("squared",)}
        return {
            name: named(*rows.arrays(most), columns.get(name, ("interval",)))
            for name, rows in self._rows.items()
        }
