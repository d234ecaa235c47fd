"""Serialised joint states of a moment, many at once; of many values the peaks stay."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.bags.storage.fixed_layouts import NO_LAYOUT, Layouts
from peg_on_hole_ros.bags.storage.message_rows import MessageRows
from peg_on_hole_ros.messages.decode import JOINTS_TYPE


class Table(NamedTuple):
    """
    Joint states of one topic, with the names of the last.

    Attributes
    ----------
    t_ns : ndarray of int64, shape (n,)
        Stamps [ns].
    positions, efforts : dict of str to ndarray, shape (n,)
        By name; without efforts empty.

    """

    t_ns: np.ndarray
    positions: dict[str, np.ndarray]
    efforts: dict[str, np.ndarray]


class Reader:
    """Reads the joint states of one topic."""

    def __init__(self) -> None:
        self._layouts = Layouts(efforts=True)

    def table(self, payloads: list[bytes]) -> Table | None:
        """Return messages of the last one's layout as columns; None where it has none."""
        if not payloads:
            return None
        ends = np.cumsum([len(payload) for payload in payloads])
        starts = ends - [len(payload) for payload in payloads]
        none = np.zeros(len(payloads), np.int64)
        rows = MessageRows(b"".join(payloads), none, none, starts, ends)
        found = self._layouts.columns(JOINTS_TYPE, rows)
        which = found.layout == found.layout[-1]
        if found.layout[-1] == NO_LAYOUT:
            return None
        layout = self._layouts.all[int(found.layout[-1])]
        values = found.values[which]
        effort = values[:, layout.width :] if layout.efforts else values[:, :0]
        return Table(
            found.t_ns[which],
            dict(zip(layout.names, values.T)),
            dict(zip(layout.names, effort.T)),
        )


def peaks(t: np.ndarray, values: np.ndarray) -> list[list[float | None]]:
    """
    Return the points of a line that are worth drawing: least, greatest and last, in order.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Times [s].
    values : ndarray, shape (n,)
        NaN where there is none: a last one stays, as a gap, with None in its place.

    """
    kept = {len(values) - 1}
    known = np.flatnonzero(np.isfinite(values))
    if len(known):
        kept |= {int(known[values[known].argmin()]), int(known[values[known].argmax()])}
    return [
        [round(float(t[i]), 4), float(f"{values[i]:.6g}") if np.isfinite(values[i]) else None]
        for i in sorted(kept)
    ]
