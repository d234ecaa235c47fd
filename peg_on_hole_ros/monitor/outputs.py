"""A row of numbers as the record that programs read: names, texts and views of its arrays."""

from typing import Any

import numpy as np

from peg_on_hole_ros.estimator.description import SIZE as DESCRIBED
from peg_on_hole_ros.estimator.description import described
from peg_on_hole_ros.monitor.alarm_text import alarms_of
from peg_on_hole_ros.monitor.output_row import (
    ALARM_WIDTH,
    ALARMS,
    FLAG,
    MODE,
    MONITOR,
    MONITOR_NAMES,
    SIZE,
)
from peg_on_hole_ros.monitor.states import MODES, Mode
from peg_on_hole_ros.records import Outputs


def are_closed(mode: Any, normal: Any) -> Any:
    """
    Return whether contacts are closed: as the mode says, and by their load where it says nothing.

    A load that is told as none, near zero or before it is told at all, opens no contact.

    Parameters
    ----------
    mode : float or ndarray
        Place in MODES; broadcast.
    normal : float or ndarray
        Reactions [N].

    """
    touches = (mode == Mode.THREE_POINT.value) | (mode == Mode.TWO_POINT.value)
    return touches | ((mode == Mode.UNKNOWN.value) & (normal > 0.0))


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
        are_closed(row[MODE], estimate.normal),
        *estimate[6:],
        {name: value for name, value in told if value == value},
        MODES[int(row[MODE])],
        bool(row[FLAG]),
        alarms_of(row[ALARMS:SIZE].reshape(-1, ALARM_WIDTH)),
    )
