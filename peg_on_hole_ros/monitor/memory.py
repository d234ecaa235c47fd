"""What a judge remembers from one wrench to the next: named fields in a few arrays."""

import numpy as np

from peg_on_hole_ros.config.options import MonitorOptions
from peg_on_hole_ros.mechanics.kernel import compiled

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
    ("weighed", "i8", "", "mode that wrenches are weighed with: that, or what it may become"),
    ("refuted", "i8", "", "whether orientations have refuted the motion since the mode"),
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
    ("sliding", "f8", "s", "since when it has been so of a peg that slides"),
    ("aloft", "f8", "s", "since when it has been open"),
)
LEVEL_FIELDS = (
    ("level", "i8", "", "OK, WARN or ERROR"),
    ("warns", "f8", "s", "since when the value has been at the threshold of WARN"),
    ("errs", "f8", "s", "since when at that of ERROR"),
    ("below", "f8", "s", "since when the level has had no cause"),
)


# The thresholds and times of mode, flag and alarms; see `MonitorOptions`.
THRESHOLDS = np.dtype(
    [
        ("mode_dwell", float),
        ("mode_probability_on", float),
        ("mode_probability_off", float),
        ("transition_probability_on", float),
        ("transition_probability_off", float),
        ("transition_hold", float),
        ("jamming_warn", float),
        ("jamming_error", float),
        ("alarm_hysteresis", float),
        ("alarm_dwell", float),
        ("alarm_hold", float),
        ("max_normal", float, (3,)),
    ]
)


def thresholds(options: MonitorOptions) -> np.void:
    """Return the thresholds for compiled code, a record of THRESHOLDS."""
    found = np.zeros(1, THRESHOLDS)[0]
    for name in THRESHOLDS.names:  # type: ignore[union-attr]
        found[name] = getattr(options, name)
    return found


@compiled
def since_when(begun: float, holds: bool, t: float) -> float:
    """Return since when something holds, NaN if it does not."""
    if not holds:
        return np.nan
    return begun if begun == begun else t
