"""The serialised messages of one estimate after the other, laid out once."""

import numpy as np

from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.cdr_layout import joined
from peg_on_hole_ros.messages.output import Message
from peg_on_hole_ros.messages.plain import header, xyz
from peg_on_hole_ros.messages.published import POSE, SIZE, publish_row


class EstimateEncoder:
    """
    Writes the messages that come with every estimate; they differ in stamp and numbers alone.

    Parameters
    ----------
    messages : list of Message
        Those of any estimate, in the order in which they are published.

    """

    def __init__(self, messages: list[Message]) -> None:
        layouts = [Encoder(ros_type).layout(fields) for _, ros_type, fields in messages]
        self._template, places = joined(layouts)
        self._places = list(zip((suffix for suffix, _, _ in messages), places))
        self._numbers = np.empty(SIZE)

    def pose(self, t_ns: int) -> dict:
        """Return header and pose of what was last written, as PoseWithCovarianceStamped."""
        x, y, z, *turn = self._numbers[POSE : POSE + 7].tolist()
        there = {"position": xyz((x, y, z)), "orientation": dict(zip("xyzw", turn))}
        return {"header": header(t_ns), "pose": {"pose": there}}

    def __call__(self, t_ns: int, row: np.ndarray) -> list[tuple[str, bytes]]:
        """
        Return (topic under the node's name, payload) of each message.

        Parameters
        ----------
        t_ns : int
            Stamp [ns].
        row : ndarray, shape (output_row.SIZE,)

        """
        publish_row(row, self._numbers)
        written = self._template.write_one(t_ns, self._numbers)
        return [(suffix, written[place]) for suffix, place in self._places]
