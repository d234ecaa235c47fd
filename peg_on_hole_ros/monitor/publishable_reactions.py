"""Whether the reactions of rows are numbers that may be published."""

from typing import Any

from peg_on_hole_ros.monitor.states import Mode


def are_publishable(rows: Any) -> Any:
    """
    Return whether the reactions are known, shape (n,).

    They are known where they are determined, and in the mode `open`, where they are zero.

    Parameters
    ----------
    rows : ndarray of ROW, shape (n,), or one row

    """
    return (rows["reactions_determined"] == 1.0) | (rows["contact_mode"] == Mode.OPEN.value)
