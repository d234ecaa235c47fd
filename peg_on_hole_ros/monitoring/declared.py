"""What a judge remembers from one wrench to the next: named fields in a few arrays."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitoring.row import ALARM_WIDTH
from peg_on_hole_ros.options import MonitorOptions

MODES = ("three_point", "two_point", "open", "unknown")
THREE_POINT, TWO_POINT, IN_AIR, UNKNOWN = range(len(MODES))
OK, WARN, ERROR = 0, 1, 2
# A stamp that there is not.
NO_STAMP = np.iinfo(np.int64).min

# Name, type, unit and meaning of what is declared; a time of NaN is none, and -1 neither 0 nor 1.
FIELDS = (
    ("t_ns", "i8", "ns", "stamp of the last wrench, NO_STAMP before"),
    ("oriented_ns", "i8", "ns", "stamp of the last orientation, NO_STAMP before"),
    ("mode", "i8", "", "contact mode: place in MODES"),
    ("candidate", "i8", "", "mode that waits for its dwell"),
    ("since", "f8", "s", "since when it does"),
    ("touching", "i8", "", "whether contact is there"),
    ("last_free", "f8", "s", "when the evidence for air was strong last"),
    ("last_touch", "f8", "s", "when that for contact was"),
    ("onset", "i8", "", "whether contact came last, or went"),
    ("turned", "f8", "s", "when it did"),
    ("latency", "f8", "s", "from there until it was declared"),
    ("on_trial", "i8", "", "whether three contacts are tried beside the mode"),
    ("offset", "f8", "m", "of the last place that was measured from three contacts'"),
    ("deviations", "f8", "", "the same in standard deviations"),
    ("displaced", "f8", "", "what it says against three contacts; 0 where none was measured"),
    ("flag", "i8", "", "transition flag"),
    ("armed", "i8", "", "whether it may rise"),
    ("fallen", "f8", "s", "since when the tilt has been above gamma0 again"),
    ("left", "f8", "s", "since when the peg has been in the air above gamma0"),
    ("rested", "i8", "", "whether three contacts are there to lose"),
    ("resting", "f8", "s", "since when the mode has been three_point"),
    ("aloft", "f8", "s", "since when it has been open"),
)
LEVEL_FIELDS = (
    ("level", "i8", "", "OK, WARN or ERROR"),
    ("warns", "f8", "s", "since when the value has been at the threshold of WARN"),
    ("errs", "f8", "s", "since when at that of ERROR"),
    ("below", "f8", "s", "since when the level has had no cause"),
)


class Memory(NamedTuple):
    """
    All that the next judgement depends on beside the estimate.

    Attributes
    ----------
    numbers : ndarray
        Of `judgement.judge`.
    declared : ndarray of FIELDS, shape (1,)
    levels : ndarray of LEVEL_FIELDS, shape (3,)
        Of each alarm.
    said, kept : ndarray, shape (3, ALARM_WIDTH)
        The alarms as they were told last, and of what caused them last; see `row`.

    """

    numbers: np.ndarray
    declared: np.ndarray
    levels: np.ndarray
    said: np.ndarray
    kept: np.ndarray


class Thresholds(NamedTuple):
    """The thresholds and times of mode, flag and alarms as floats; see `MonitorOptions`."""

    mode_dwell: float
    mode_probability_on: float
    mode_probability_off: float
    transition_probability_on: float
    transition_probability_off: float
    transition_hold: float
    jamming_warn: float
    jamming_error: float
    alarm_hysteresis: float
    alarm_dwell: float
    alarm_hold: float
    max_normal: tuple[float, float, float]


def thresholds(options: MonitorOptions) -> Thresholds:
    """Return the thresholds for compiled code."""
    *floats, most = (getattr(options, name) for name in Thresholds._fields)
    return Thresholds(*map(float, floats), tuple(map(float, most)))


def new_memory(numbers: np.ndarray) -> Memory:
    """Return a memory about those of `judgement.new_judgement`; forget it before use."""
    return Memory(
        numbers,
        np.zeros(1, [field[:2] for field in FIELDS]),
        np.zeros(3, [field[:2] for field in LEVEL_FIELDS]),
        np.zeros((3, ALARM_WIDTH)),
        np.zeros((3, ALARM_WIDTH)),
    )


@compiled
def since_when(begun, holds, t):
    """Return since when something holds, NaN if it does not."""
    if not holds:
        return np.nan
    return begun if begun == begun else t
