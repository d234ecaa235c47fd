"""The numbers of many stamps' messages at once: a column for each field, a row for each stamp."""

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimator.description import described_rows
from peg_on_hole_ros.messages.output import Message, estimate_messages
from peg_on_hole_ros.messages.published import WIDTHS, published
from peg_on_hole_ros.monitor.output_row import AT, DOUBTS, FLAG, MODE, MONITOR
from peg_on_hole_ros.monitor.outputs import are_closed, outputs_of
from peg_on_hole_ros.monitor.states import MODES, Mode
from peg_on_hole_ros.records import Outputs, Rows


class Topic(NamedTuple):
    """
    One topic of an estimate.

    Attributes
    ----------
    name : str
        Under the node's name.
    ros_type : str
    message : dict
        That of the first stamp; all others differ in stamp and numbers alone.
    numbers : ndarray, shape (n, k)
        In the order of the message.

    """

    name: str
    ros_type: str
    message: dict
    numbers: np.ndarray


class OutputColumns:
    """
    Outputs of stamps that rise, as `OutputStream` publishes them one by one.

    Parameters
    ----------
    rows : Rows
    said : list of (int, list of Message)
        What is published on change or from time to time beside the estimate, by place of stamp.

    """

    def __init__(self, rows: Rows, said: list[tuple[int, list[Message]]]) -> None:
        self.t_ns, self._rows, self.said = rows.t_ns, rows.values, said
        self._fields = described_rows(rows.values)

    def __len__(self) -> int:
        """Return the number of stamps."""
        return len(self.t_ns)

    def row(self, i: int) -> np.ndarray:
        """Return the numbers of one stamp, see `output_row`."""
        return self._rows[i]

    def outputs(self, i: int) -> Outputs:
        """Return all of one stamp."""
        return outputs_of(int(self.t_ns[i]), self._rows[i])

    def messages(self, i: int, said: Sequence[Message] = ()) -> list[Message]:
        """Return the messages of one stamp, with those said beside."""
        return [*estimate_messages(self.outputs(i)), *said]

    @property
    def state(self) -> np.ndarray:
        """Angles [rad] and rates [rad/s], shape (n, 6)."""
        return self._fields.state

    @cached_property
    def state_stddev(self) -> np.ndarray:
        """Their standard deviations, shape (n, 6)."""
        variance = np.diagonal(self._fields.state_covariance, axis1=1, axis2=2)
        return np.sqrt(np.maximum(variance, 0.0))

    @property
    def monitor(self) -> np.ndarray:
        """A value for each of MONITOR_NAMES, NaN for what does not exist, shape (n, k)."""
        return self._rows[:, MONITOR:MODE]

    @property
    def doubts(self) -> np.ndarray:
        """What each of UNTOLD would cost [N], NaN where that does not exist, shape (n, 8)."""
        return self._rows[:, DOUBTS]

    @property
    def determined(self) -> np.ndarray:
        """Whether the wrench determines the reactions, shape (n,)."""
        return self._rows[:, AT.reactions_determined] == 1.0

    @cached_property
    def known(self) -> np.ndarray:
        """Whether the reactions are numbers: determined, or none as nothing touches, (n,)."""
        return self.determined | (self._rows[:, MODE] == Mode.OPEN)

    @cached_property
    def normal(self) -> np.ndarray:
        """Reactions at K, B1, B2 [N], NaN where not known, shape (n, 3)."""
        return np.where(self.known[:, None], self._fields.normal, np.nan)

    @property
    def normal_stddev(self) -> np.ndarray:
        """Their standard deviations [N], shape (n, 3)."""
        return self._fields.normal_stddev

    @property
    def closed(self) -> np.ndarray:
        """Whether each contact is closed, shape (n, 3)."""
        return are_closed(self._rows[:, MODE, None], self._fields.normal)

    @cached_property
    def force(self) -> np.ndarray:
        """Force on the peg at K, B1, B2 [N], NaN where not known, shape (n, 3, 3)."""
        return np.where(self.known[:, None, None], self._fields.contact_force, np.nan)

    @property
    def position(self) -> np.ndarray:
        """Origin of the peg in the hole frame [m], shape (n, 3)."""
        return self._fields.position

    @cached_property
    def modes(self) -> list[str]:
        """The contact mode of each stamp."""
        return [MODES[code] for code in self._rows[:, MODE].astype(int).tolist()]

    @property
    def flags(self) -> np.ndarray:
        """The transition flag of each stamp, shape (n,)."""
        return self._rows[:, FLAG] != 0.0

    def topics(self) -> list[Topic]:
        """Return the topics of the estimate in the order in which they are published."""
        ends = np.cumsum(list(WIDTHS.values()))
        numbers = np.split(published(self._rows), ends[:-1], axis=1)
        first = self.messages(0)
        return [Topic(*message, columns) for message, columns in zip(first, numbers, strict=True)]
