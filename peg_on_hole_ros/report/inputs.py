"""What a report draws of the messages that came in: wrenches, gaps, orientations."""

from math import pi

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.messages.columns import OutputColumns
from peg_on_hole_ros.messages.output import Message
from peg_on_hole_ros.messages.stream import orientation_of
from peg_on_hole_ros.records import AngleMeasurement, Arrivals, JointSample, WrenchSample
from peg_on_hole_ros.report.thinning import Rows
from peg_on_hole_ros.report.tracks import MOST_DRAWN, Tracks, named

WRENCH = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
# A measurement is held against an estimate no further from it [ns]: rates do not last.
_NEAR_NS = 100_000_000
_MOST_WAITING = 10_000


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
        self._orientation = orientation_of(configuration.joints)
        self._delay_ns = round(configuration.joints.delay * 1e9)
        self._rows = {
            "wrench": Rows(len(WRENCH)),
            "innovations": Rows(1),
            "wrench_interval": Rows(1),
            "joints_interval": Rows(1),
        }
        self._latest = dict.fromkeys(self._rows, 0)
        self._last_ns: dict[str, int] = {}
        # Stamps and rows by table; orientations with their covariances likewise.
        self._waiting: list[tuple[str, np.ndarray, np.ndarray]] = []
        self._orientations: list[tuple[np.ndarray, np.ndarray]] = []

    def read(self, sample: object) -> None:
        """Take a wrench or a joint state; one that cannot be read is left out."""
        if isinstance(sample, WrenchSample):
            row = np.array([[*sample.force, *sample.torque]])
            self._take_wrenches(np.array([sample.t_ns]), row)
            return
        if not isinstance(sample, JointSample):
            return
        measured = self._orientation(sample)
        if isinstance(measured, AngleMeasurement):
            t_ns = np.array([sample.t_ns - self._delay_ns])
            self._take_orientations(t_ns, measured.row.reshape(1, -1))

    def take_inputs(self, arrivals: Arrivals, begin: int, end: int) -> None:
        """Take messages by their places, all of them sound."""
        of_wrench, t_ns = arrivals.of_wrench[begin:end], arrivals.t_ns[begin:end]
        first = int(np.count_nonzero(arrivals.of_wrench[:begin]))
        last = first + int(np.count_nonzero(of_wrench))
        self._take_wrenches(t_ns[of_wrench], arrivals.wrenches[first:last])
        rows = arrivals.orientations[begin - first : end - last]
        self._take_orientations(t_ns[~of_wrench], rows)

    def _take_wrenches(self, t_ns, rows):
        self._wait("wrench", t_ns, rows)
        self._note_intervals("wrench", t_ns)

    def _take_orientations(self, t_ns, rows):
        self._note_intervals("joints", t_ns)
        self._orientations.append((t_ns, rows[:, :12]))
        del self._orientations[:-_MOST_WAITING]

    def _note_intervals(self, source, t_ns):
        if len(t_ns):
            before = np.concatenate([[self._last_ns.get(source, t_ns[0])], t_ns[:-1]])
            self._last_ns[source] = int(t_ns[-1])
            rose = t_ns > before
            intervals = (t_ns - before)[rose, np.newaxis] * 1e-6
            self._wait(f"{source}_interval", t_ns[rose], intervals)

    def _wait(self, name, t_ns, rows):
        self._waiting.append((name, t_ns, rows))
        del self._waiting[:-_MOST_WAITING]

    def add(self, t_ns: int, messages: list[Message]) -> None:
        """Take the outputs of one stamp [ns]."""
        state = next(fields for topic, _, fields in messages if topic == "state")
        state = np.array([[*state["position"], *state["velocity"]]])
        self._take_outputs(np.array([t_ns]), state)

    def take(self, columns: OutputColumns) -> None:
        """Take the outputs of many stamps."""
        self._take_outputs(columns.t_ns, columns.state[:, :6])

    def _take_outputs(self, t_ns, state):
        for stamps, rows in self._orientations:
            # The output that came after it, as those that were in order had it.
            after = np.minimum(np.searchsorted(t_ns, stamps), len(t_ns) - 1)
            ahead_ns = stamps - t_ns[after]
            near = np.abs(ahead_ns) <= _NEAR_NS
            now, rates = state[after, :3], state[after, 3:6]
            error = rows[:, :3] - now - rates * (ahead_ns * 1e-9)[:, np.newaxis]
            error[:, 1:] -= 2 * pi * np.round(error[:, 1:] / (2 * pi))
            error, covariance = error[near, :, np.newaxis], rows[near, 3:].reshape(-1, 3, 3)
            squared = np.swapaxes(error, 1, 2) @ np.linalg.solve(covariance, error)
            self._wait("innovations", stamps[near], squared.reshape(-1, 1))
        self._orientations.clear()
        run, now_ns = self._tracks.runs[-1], self._tracks.passed_ns
        for name, stamps, rows in self._waiting:
            if len(stamps):
                # What is late is drawn where it came; nothing is ahead of the estimate.
                passed = np.maximum.accumulate(np.maximum(run.passed(stamps), self._latest[name]))
                passed = np.minimum(passed, now_ns)
                self._latest[name] = int(passed[-1])
                self._rows[name].add_all(passed, rows)
        self._waiting.clear()

    def tables(self, most: int = MOST_DRAWN) -> dict[str, dict[str, np.ndarray]]:
        """Return columns by table and name: WRENCH [N], [N m], `squared`, `interval` [ms]."""
        columns = {"wrench": WRENCH, "innovations": ("squared",)}
        return {
            name: named(*rows.arrays(most), columns.get(name, ("interval",)))
            for name, rows in self._rows.items()
        }
