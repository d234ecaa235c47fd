"""What is published while a setting of the wrench is in doubt: nothing that rests on it."""

import numpy as np

from peg_on_hole_ros.monitor.closed_contacts import are_closed
from peg_on_hole_ros.monitor.dangers import registry
from peg_on_hole_ros.monitor.output_row import NOT_JUDGED
from peg_on_hole_ros.monitor.states import Mode

_RESTS_ON_WRENCH = (
    *registry.OUTPUTS,
    "mode_probability_K_alone",
    "mode_probability_B_alone",
    "insertion_depth",
    "insertion_depth_stddev",
    "insertion_speed",
    "insertion_speed_stddev",
    "time_to_transition",
    "time_to_transition_stddev",
)


def withhold(rows: np.ndarray, transition: bool) -> None:
    """
    Remove from rows what rests on the wrench.

    Parameters
    ----------
    rows : ndarray of ROW, shape (n,)
        Changed.
    transition : bool
        The flag as it was published last: it stays.

    """
    for name in _RESTS_ON_WRENCH:
        rows[name] = np.nan
    rows["reactions_determined"] = 0.0
    mode = rows["contact_mode"]
    rows["contact_mode"] = np.where(mode == Mode.OPEN, Mode.OPEN, Mode.UNKNOWN)
    rows["closed"] = are_closed(rows["contact_mode"][:, None], rows["normal"])
    rows["transition"] = transition
    level, held = rows["alarms"]["level"], rows["alarms"]["held"]
    looked_at = level >= 0
    held[looked_at], level[looked_at] = NOT_JUDGED, 0
