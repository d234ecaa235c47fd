"""Outputs of one or many stamps: a column for each, a row for each stamp."""

from collections.abc import Iterable
from functools import cached_property
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.messages.beside_estimates import Message
from peg_on_hole_ros.messages.plain import HOLE_FRAME
from peg_on_hole_ros.messages.published import LAYOUTS, published
from peg_on_hole_ros.monitor.publishable_reactions import are_publishable
from peg_on_hole_ros.monitor.states import MODES
from peg_on_hole_ros.records import Rows


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
    Outputs of stamps that rise, as they are published.

    Parameters
    ----------
    rows : Rows
    beside : list of (int, list of Message)
        What is published on change or from time to time beside the estimate, by place of stamp.
    frame : str
        The hole's, which messages are in.

    """

    def __init__(
        self, rows: Rows, beside: list[tuple[int, list[Message]]], frame: str = HOLE_FRAME
    ) -> None:
        self.t_ns, self.rows, self.beside = rows.t_ns, rows.values, beside
        self._frame = frame

    def __len__(self) -> int:
        """Return the number of stamps."""
        return len(self.t_ns)

    def __getitem__(self, name: str) -> np.ndarray:
        """Return an output of the row by its name, see `outputs.Row`; its shape begins with n."""
        column: np.ndarray = self.rows[name]
        return column

    def add(self, beside: Iterable[tuple[int, list[Message]]]) -> None:
        """Add messages that are published beside the estimate, by place of stamp."""
        found = dict(self.beside)
        for place, messages in beside:
            found[place] = [*found.get(place, ()), *messages]
        self.beside = sorted(found.items())

    def messages(self, i: int) -> list[Message]:
        """Return all messages of one stamp."""
        t_ns, numbers = int(self.t_ns[i]), self.numbers[i]
        estimate = [
            (each.name, each.ros_type, each.message(t_ns, numbers[each.at], self._frame))
            for each in LAYOUTS.values()
        ]
        return [*estimate, *dict(self.beside).get(i, ())]

    def topics(self) -> list[Topic]:
        """Return the topics of the estimate in the order in which they are published."""
        t_ns, numbers = int(self.t_ns[0]), self.numbers
        return [
            Topic(
                each.name,
                each.ros_type,
                each.message(t_ns, numbers[0, each.at], self._frame),
                numbers[:, each.at],
            )
            for each in LAYOUTS.values()
        ]

    @cached_property
    def numbers(self) -> np.ndarray:
        """The numbers of the messages of the estimate, see `published`, shape (n, SIZE)."""
        return published(self.rows)

    @property
    def determined(self) -> np.ndarray:
        """Whether the wrench determines the reactions, shape (n,)."""
        determined: np.ndarray = self.rows["reactions_determined"] == 1.0
        return determined

    @cached_property
    def normal(self) -> np.ndarray:
        """Reactions at K, B1, B2 [N], NaN where not known, shape (n, 3)."""
        return self._where_known(self.rows["normal"])

    @cached_property
    def force(self) -> np.ndarray:
        """Force on the peg at K, B1, B2 [N], NaN where not known, shape (n, 3, 3)."""
        return self._where_known(self.rows["contact_wrench"][:, :, :3])

    def _where_known(self, values):
        known = are_publishable(self.rows).reshape(-1, *[1] * (values.ndim - 1))
        return np.where(known, values, np.nan)

    @cached_property
    def modes(self) -> list[str]:
        """The contact mode of each stamp."""
        return [MODES[code] for code in self.rows["contact_mode"].tolist()]
