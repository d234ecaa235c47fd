"""What a report draws of the messages that came in: wrenches, gaps, orientations."""

from math import pi
from typing import Any

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.messages.output import Message
from peg_on_hole_ros.messages.stream import orientation_of
from peg_on_hole_ros.records import AngleMeasurement, JointSample, WrenchSample
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
        self._waiting: list[tuple[str, int, tuple]] = []
        self._orientations: list[AngleMeasurement] = []

    def read(self, sample: Any) -> None:
        """Take a wrench or a joint state; one that cannot be read is left out."""
        if isinstance(sample, WrenchSample):
            self._wait("wrench", sample.t_ns, (*sample.force, *sample.torque))
            self._note_interval("wrench", sample.t_ns)
            return
        measured = self._orientation(sample) if isinstance(sample, JointSample) else None
        if isinstance(measured, AngleMeasurement):
            self._note_interval("joints", sample.t_ns)
            self._orientations.append(measured)
            del self._orientations[:-_MOST_WAITING]

    def _note_interval(self, source, t_ns):
        before = self._last_ns.get(source, t_ns)
        self._last_ns[source] = t_ns
        if t_ns > before:
            self._wait(f"{source}_interval", t_ns, ((t_ns - before) * 1e-6,))

    def _wait(self, name, t_ns, row):
        self._waiting.append((name, t_ns, row))
        del self._waiting[:-_MOST_WAITING]

    def add(self, t_ns: int, messages: list[Message]) -> None:
        """Take the outputs of one stamp [ns]."""
        state = next(fields for topic, _, fields in messages if topic == "state")
        now, rate = np.array(state["position"]), np.array(state["velocity"])
        for measured in self._orientations:
            ahead_ns = measured.t_ns - self._delay_ns - t_ns
            if abs(ahead_ns) <= _NEAR_NS:
                error = measured.q - now - rate * (ahead_ns * 1e-9)
                error[1:] -= 2 * pi * np.round(error[1:] / (2 * pi))
                squared = float(error @ np.linalg.solve(measured.covariance, error))
                self._wait("innovations", measured.t_ns - self._delay_ns, (squared,))
        self._orientations.clear()
        run, now_ns = self._tracks.runs[-1], self._tracks.passed_ns
        for name, stamp_ns, row in self._waiting:
            # What is late is drawn where it came; nothing is ahead of the estimate.
            passed = min(max(run.passed(stamp_ns), self._latest[name]), now_ns)
            self._latest[name] = passed
            self._rows[name].add(passed, row)
        self._waiting.clear()

    def tables(self, most: int = MOST_DRAWN) -> dict[str, dict[str, np.ndarray]]:
        """Return columns by table and name: WRENCH [N], [N m], `squared`, `interval` [ms]."""
        columns = {"wrench": WRENCH, "innovations": ("squared",)}
        return {
            name: named(*rows.arrays(most), columns.get(name, ("interval",)))
            for name, rows in self._rows.items()
        }
