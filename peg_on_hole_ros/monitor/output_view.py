"""A row as programs read it: its fields as attributes, and mode, monitor and alarms in words."""

from typing import Any

import numpy as np

from peg_on_hole_ros.monitor.alarm_text import alarms_of
from peg_on_hole_ros.monitor.output_row import MONITOR_AT, MONITOR_NAMES
from peg_on_hole_ros.monitor.states import MODES
from peg_on_hole_ros.records import Alarm


class OutputView:
    """
    Everything that one wrench message gives.

    Beside the attributes below it has those of `outputs.Row`, as views of the row.

    Parameters
    ----------
    t_ns : int
        Stamp of the wrench message [ns].
    row : numpy.void
        A row of ROW.
    alarms : tuple of Alarm, optional
        In place of those of the row.

    Attributes
    ----------
    t_ns : int
    row : numpy.void

    """

    def __init__(self, t_ns: int, row: Any, alarms: tuple[Alarm, ...] | None = None) -> None:
        self.t_ns, self.row, self._alarms = t_ns, row, alarms

    def __getattr__(self, name: str) -> Any:
        """Return a field of the row."""
        if "row" not in self.__dict__ or name not in self.row.dtype.names:
            raise AttributeError(f"outputs have no {name}")
        return self.row[name]

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """The alarms in words; empty: nobody looks after them."""
        if self._alarms is None:
            self._alarms = alarms_of(self.row["alarms"], self.friction_before, self.friction)
        return self._alarms

    @property
    def closed(self) -> np.ndarray:
        """Whether each contact is closed, shape (3,)."""
        closed: np.ndarray = self.row["closed"] == 1.0
        return closed

    @property
    def contact_force(self) -> np.ndarray:
        """Force on the peg at K, B1, B2 (rows), normal and friction, hole axes [N], (3, 3)."""
        force: np.ndarray = self.row["contact_wrench"][:, :3]
        return force

    @property
    def contact_mode(self) -> str:
        """`three_point`, `two_point`, `open` or `unknown`."""
        return MODES[int(self.row["contact_mode"])]

    @property
    def transition(self) -> bool:
        """Whether three-point contact has become two-point contact."""
        return bool(self.row["transition"])

    @property
    def monitor(self) -> dict[str, float]:
        """Numbers by their names in `~/monitor`; one that does not exist is not in it."""
        values = np.frombuffer(self.row.tobytes(), float, len(MONITOR_NAMES), MONITOR_AT).tolist()
        return {name: value for name, value in zip(MONITOR_NAMES, values) if value == value}
