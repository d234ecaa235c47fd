"""Estimates over time for a plot, thinned so that a bag of any length fits."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from peg_on_hole_ros.messages.passed_time import PassedTime, StampRun

MOST_ROWS = 40_000  # more than a plot has pixels
MONITORED = (
    "transition_probability",
    "jamming_risk",
    "three_point_validity",
    "reactions_determined",
)


class Series:
    """
    Collects a replay's output; beyond MOST_ROWS every second row is let go, again and again.

    Changes of mode and flag are all kept. Time is what has passed since the first estimate: where
    stamps fall it goes on from where it was. An estimate of a stamp that was wrong is let go.

    Attributes
    ----------
    modes, flags : list of (int, str), list of (int, bool)
        Passed time [ns] and what holds from there on.

    """

    def __init__(self) -> None:
        self._rows: list[tuple] = []
        self._every = 1
        self._seen = 0
        self.modes: list[tuple[int, Any]] = []
        self.flags: list[tuple[int, Any]] = []
        self._time = PassedTime()

    @property
    def runs(self) -> list[StampRun]:
        """Stamps from one fall to the next."""
        return self._time.runs

    @property
    def passed_ns(self) -> int:
        """Time that has passed up to the latest estimate [ns]."""
        return self._time.ns

    def declared(self, t_ns: int, mode: str | None, flag: bool | None) -> None:
        """Take contact mode and transition flag; None or an empty text: as before."""
        passed = self._passed(t_ns)
        if mode and (not self.modes or self.modes[-1][1] != mode):
            self.modes.append((passed, mode))
        if flag is not None and (not self.flags or self.flags[-1][1] != flag):
            self.flags.append((passed, flag))

    def row(
        self,
        t_ns: int,
        values: Sequence[float] | np.ndarray,
        stddev: Sequence[float] | np.ndarray,
        monitor: dict[str, float],
    ) -> None:
        """Take gamma, psi, phi [rad], N_K, N_B1, N_B2 [N], their stddev and the monitor."""
        passed = self._passed(t_ns)
        if self._seen % self._every == 0:
            scalars = [monitor.get(name, np.nan) for name in MONITORED]
            self._rows.append((passed, *values, *stddev, *scalars))
            if len(self._rows) > MOST_ROWS:
                del self._rows[1::2]
                self._every *= 2
        self._seen += 1

    def _passed(self, t_ns):
        before = self.passed_ns
        self._time.take(t_ns)
        passed = self.passed_ns
        if passed < before:
            while self._rows and self._rows[-1][0] > passed:
                self._rows.pop()
            for changes in (self.modes, self.flags):
                changes[:] = [(min(at, passed), what) for at, what in changes]
        return passed

    def arrays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """
        Return times, values, standard deviations, monitor.

        Returns
        -------
        passed_ns : ndarray of int64, shape (n,)
            Never less than the one before.
        values, stddev : ndarray, shape (n, 6)
            In the order of `records.SIX_QUANTITIES`.
        monitor : ndarray, shape (n, 4)
            In the order of MONITORED; NaN where a value does not exist, which a plot leaves out.

        """
        passed = np.array([row[0] for row in self._rows], dtype=np.int64)
        rest = np.array([row[1:] for row in self._rows], dtype=float).reshape(len(passed), -1)
        return passed, rest[:, :6], rest[:, 6:12], rest[:, 12:]
