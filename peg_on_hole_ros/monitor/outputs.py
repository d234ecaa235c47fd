"""A row of numbers as the record that programs read: names, texts and views of its arrays."""

import numpy as np

from peg_on_hole_ros.estimator.description import SIZE as DESCRIBED
from peg_on_hole_ros.estimator.description import described
from peg_on_hole_ros.monitor.alarm_text import alarms_of
from peg_on_hole_ros.monitor.memory import MODES
from peg_on_hole_ros.monitor.output_row import (
    ALARM_WIDTH,
    ALARMS,
    FLAG,
    MODE,
    MONITOR,
    MONITOR_NAMES,
    SIZE,
)
from peg_on_hole_ros.records import Outputs


def outputs_of(t_ns: int, row: np.ndarray) -> Outputs:
    """
    Return the outputs of a stamp.

    Parameters
    ----------
    t_ns : int
        [ns].
    row : ndarray, shape (SIZE,)
        As laid out in `row`; the outputs look at it.

    """
    estimate = described(row[:DESCRIBED])
    told = zip(MONITOR_NAMES, row[MONITOR:MODE].tolist())
    return Outputs(
        t_ns,
        *estimate[:6],
        estimate.normal > 0,
        *estimate[6:],
        {name: value for name, value in told if value == value},
        MODES[int(row[MODE])],
        bool(row[FLAG]),
        alarms_of(row[ALARMS:SIZE].reshape(-1, ALARM_WIDTH)),
    )
