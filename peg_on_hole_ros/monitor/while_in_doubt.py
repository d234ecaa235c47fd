"""What may still be told while a setting of the wrench is in doubt: nothing sure of contacts."""

import numpy as np

from peg_on_hole_ros.monitor.output_row import (
    ALARM_WIDTH,
    ALARMS,
    AT,
    FLAG,
    HELD,
    LEVEL,
    MODE,
    NOT_JUDGED,
    SIZE,
)
from peg_on_hole_ros.monitor.states import Mode

_RISKS = (
    AT.jamming_risk,
    AT.jamming_wedging,
    AT.jamming_stall,
    AT.jamming_load,
    AT.insertion_ratio,
    AT.whitney_margin,
    AT.mode_probability_K_alone,
    AT.mode_probability_B_alone,
    AT.insertion_depth,
    AT.insertion_depth_stddev,
    AT.insertion_speed,
    AT.insertion_speed_stddev,
    AT.determinant,
    AT.time_to_transition,
    AT.time_to_transition_stddev,
)


def doubt(rows: np.ndarray, transition: bool) -> None:
    """
    Take out of rows what rests on the wrench.

    Parameters
    ----------
    rows : ndarray, shape (n, SIZE)
        See `monitoring.row`; changed.
    transition : bool
        The flag as it was told last: it stays.

    """
    rows[:, _RISKS] = np.nan
    rows[:, AT.reactions_determined] = 0.0
    rows[:, MODE] = np.where(rows[:, MODE] == Mode.OPEN, Mode.OPEN, Mode.UNKNOWN)
    rows[:, FLAG] = transition
    alarms = rows[:, ALARMS:SIZE].reshape(len(rows), -1, ALARM_WIDTH)
    looked_at = alarms[:, :, LEVEL] >= 0.0
    alarms[:, :, LEVEL] = np.where(looked_at, 0.0, alarms[:, :, LEVEL])
    alarms[:, :, HELD] = np.where(looked_at, NOT_JUDGED, alarms[:, :, HELD])
    rows[:, ALARMS:SIZE] = alarms.reshape(len(rows), -1)
