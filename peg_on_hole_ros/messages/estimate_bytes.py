"""The serialised messages of one estimate after the other, laid out once."""

import numpy as np

from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.cdr_layout import joined
from peg_on_hole_ros.messages.published import LAYOUTS


class EstimateEncoder:
    """Writes the messages of an estimate, which differ from others in stamp and numbers alone."""

    def __init__(self) -> None:
        layouts = [
            Encoder(each.ros_type).layout(each.message(0, np.zeros(each.at.stop - each.at.start)))
            for each in LAYOUTS.values()
        ]
        self._template, places = joined(layouts)
        self._places = list(zip(LAYOUTS, places))

    def __call__(self, t_ns: int, numbers: np.ndarray) -> list[tuple[str, bytes]]:
        """
        Return (topic under the node's name, payload) of each message.

        Parameters
        ----------
        t_ns : int
            Stamp [ns].
        numbers : ndarray, shape (published.SIZE,)

        """
        written = self._template.write_one(t_ns, numbers)
        return [(suffix, written[place]) for suffix, place in self._places]
