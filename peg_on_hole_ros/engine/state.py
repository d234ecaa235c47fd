"""The engine's state and rules: typed records with named fields, and tables of them."""

from collections import namedtuple
from typing import Any

import numpy as np

from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.settings import Gates
from peg_on_hole_ros.measurements.freshness import FRESHNESS
from peg_on_hole_ros.measurements.innovations import INNOVATIONS
from peg_on_hole_ros.measurements.measurement import REDUCTION
from peg_on_hole_ros.measurements.saturation import WIDTH as SATURATION
from peg_on_hole_ros.measurements.wrench_noise import WIDTH as WRENCH_NOISE
from peg_on_hole_ros.monitor.memory import Memory
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.typed_record import dtype_of

# Name, type, unit and meaning of what the engine knows of time and motion.
FIELDS = (
    ("t_ns", "i8", "ns", "stamp that the estimate has come to; NO_STAMP: not started"),
    ("oriented_ns", "i8", "ns", "stamp of the last orientation that was used"),
    ("slid_ns", "i8", "ns", "stamp at which the peg was last known not to rest on its contacts"),
    ("in_contact", "i8", "", "whether the last wrench was weighed with three contacts"),
    ("touching", "i8", "", "whether innovations say something of the settings"),
    ("blind", "i8", "", "whether no orientation has come for long"),
    ("lost", "i8", "", "whether nothing is known of the motion"),
    ("noise", "f8", "", "how much noisier than stated orientations were when they last were"),
)
# What is counted; each has a place in an array of whole numbers.
COUNTS = (
    "joints_used",
    "joints_gated",
    "joints_noisy",
    "joints_dropped_repeated_value",
    "joints_gap",
    "filter_restarted",
    "innovations_too_large",
    "motion_lost",
    "gap",
    "wrench_used",
    "wrench_spike",
    "wrench_noisy",
    "wrench_saturated",
    "wrench_dropped_without_orientation",
)
# Their places.
AT: Any = namedtuple("AT", COUNTS)(*range(len(COUNTS)))

# An orientation as a row: gamma, psi, phi [rad], their covariance; place of the peg's origin [m],
# NaN where it is not measured, and its covariance.
Q, R, PLACE, PLACE_R = slice(0, 3), slice(3, 12), slice(12, 15), slice(15, 24)
ORIENTATION = 24


# Options as numbers; those that a node takes while it is active change all of it at once.
RULES = np.dtype(
    [
        ("gates", dtype_of(Gates)),
        ("monitor", dtype_of(MonitorSettings)),
        ("judged", np.int64),  # whether modes, forecast, risk and alarms are looked at
        ("white", np.int64),  # innovations are white: not where bias or tilt are learnt
        ("max_gap", float),  # [s]
        ("max_joint_gap", float),  # [s]
        ("delay_ns", np.int64),  # of joint states [ns]
        ("lost_ns", np.int64),  # without an orientation for so long the motion is lost [ns]
    ]
)

# All that the next wrench depends on. What changes stands together, and ends with the estimate.
ENGINE = np.dtype(
    [
        ("reduction", REDUCTION),  # from a wrench as received to one on the peg
        ("covariance", float, (6, 6)),  # of that, where each wrench is news
        ("variance", float, (6,)),  # of a wrench as received [N^2], [N^2 m^2]
        ("tared", float, (6,)),  # taken by a tare, as the sensor reports it [N], [N m]; NaN before
        ("q", float, (3,)),  # scratch: an orientation
        ("R", float, (3, 3)),
        ("wrench", float, (6,)),  # scratch: as received, and on the peg
        ("u", float, (6,)),
        ("memory", dtype_of(Memory)),  # what the monitor remembers
        ("innovations", INNOVATIONS),
        ("motion", [field[:2] for field in FIELDS], (1,)),
        ("counts", np.int64, (len(COUNTS),)),
        ("fresh", FRESHNESS),
        ("wrench_noise", float, (WRENCH_NOISE,)),
        ("saturation", float, (SATURATION,)),
        ("filter", dtype_of(FilterRecord), (1,)),  # the estimate
    ]
)


# What the engine remembers beside the estimate, in bytes.
BESIDE = slice(ENGINE.fields["memory"][1], ENGINE.fields["filter"][1])  # type: ignore[index]
