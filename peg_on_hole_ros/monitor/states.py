"""What is declared: contact modes, alarm levels, and whether anything touches."""

from enum import IntEnum

import numpy as np

from peg_on_hole_ros.mechanics.kernel import compiled


class Mode(IntEnum):
    """Contact modes, in the order in which they are compared."""

    THREE_POINT = 0
    TWO_POINT = 1
    OPEN = 2
    UNKNOWN = 3
    ELSEWHERE = 4
    INSERTED = 5


# Their names in messages.
MODES = tuple(mode.name.lower() for mode in Mode)


class AlarmLevel(IntEnum):
    """Levels of an alarm, as in diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


class Touch(IntEnum):
    """Whether anything touches the peg."""

    UNKNOWN = -1
    APART = 0
    TOUCHING = 1


# A stamp that there is not.
NO_STAMP = np.iinfo(np.int64).min


@compiled
def since_when(begun: float, holds: bool, t: float) -> float:
    """Return since when something holds, NaN if it does not."""
    if not holds:
        return np.nan
    return begun if begun == begun else t
