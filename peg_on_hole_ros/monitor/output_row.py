"""One wrench's outputs as one row of numbers: where each stands, by its name."""

from collections import namedtuple
from typing import Any

from peg_on_hole_ros.estimator.description import SIZE as DESCRIBED
from peg_on_hole_ros.records import UNTOLD

_BIAS = tuple(f"bias_{kind}_{axis}" for kind in ("force", "torque") for axis in "xyz")
LEARNT = (*_BIAS, "hole_tilt_x", "hole_tilt_y")

# The names in `~/monitor`: one list in one order for the life of a node, whatever is known.
MONITOR_NAMES = (
    "transition_probability",
    "time_to_transition",
    "time_to_transition_stddev",
    "jamming_risk",
    "jamming_wedging",
    "jamming_stall",
    "jamming_load",
    "determinant",
    "insertion_ratio",
    "whitney_margin",
    "insertion_depth",
    "insertion_depth_stddev",
    "insertion_speed",
    "insertion_speed_stddev",
    "three_point_validity",
    "mode_probability_three_point",
    "mode_probability_two_point",
    "mode_probability_K_alone",
    "mode_probability_B_alone",
    "mode_probability_opened",
    "mode_probability_stuck",
    "mode_probability_free",
    "mode_probability_unknown",
    "contact_age",
    "contact_latency",
    "free_age",
    "free_latency",
    "reactions_determined",
    "friction",
    "friction_stddev",
    "clearance",
    "clearance_stddev",
    "position_offset",
    "position_misfit",
    "nis_median",
    "nis_drift",
    "joints_noise",
    *LEARNT,
    *(f"{name}_stddev" for name in LEARNT),
    *(f"doubt_{name}" for name in UNTOLD),
)

# Of an alarm: its level (below zero: it has never been looked at), which of its texts, whether it
# is held without a cause or NOT_JUDGED, which names its numbers have (0: none), and up to 7
# numbers.
LEVEL, WHICH, HELD, KIND, NUMBERS = range(5)
NOT_JUDGED = 2
ALARM_WIDTH = NUMBERS + 7
JAMMING, CONTACT_LOSS, OVERLOAD = range(3)

# The row: the description (`estimator.description`), each of MONITOR_NAMES (NaN: it does not
# exist at present), contact mode, flag, and three alarms.
MONITOR = DESCRIBED
MODE = MONITOR + len(MONITOR_NAMES)
FLAG = MODE + 1
ALARMS = FLAG + 1
SIZE = ALARMS + 3 * ALARM_WIDTH
AT: Any = namedtuple("AT", MONITOR_NAMES)(*range(MONITOR, MODE))
# Of the row: what each of UNTOLD would cost.
DOUBTS = slice(AT.doubt_friction, AT.doubt_friction + len(UNTOLD))
