"""The engine's state and rules: typed records with named fields, and tables of them."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimation import freshness, innovations
from peg_on_hole_ros.estimation.freshness import Freshness
from peg_on_hole_ros.estimation.innovations import Innovations
from peg_on_hole_ros.estimation.measurement import Reduction
from peg_on_hole_ros.estimator.held import Gates, Held
from peg_on_hole_ros.monitoring import declared, judgement
from peg_on_hole_ros.monitoring.declared import Memory, Thresholds
from peg_on_hole_ros.monitoring.row import ALARM_WIDTH

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
    "wrench_dropped_without_orientation",
)


class Counted(NamedTuple):
    """The places of COUNTS."""

    joints_used: int
    joints_gated: int
    joints_noisy: int
    joints_dropped_repeated_value: int
    joints_gap: int
    filter_restarted: int
    innovations_too_large: int
    motion_lost: int
    gap: int
    wrench_used: int
    wrench_spike: int
    wrench_dropped_without_orientation: int


AT = Counted(*range(len(COUNTS)))

# An orientation as a row: gamma, psi, phi [rad], their covariance; place of the peg's origin [m],
# NaN where it is not measured, and its covariance.
Q, R, PLACE, PLACE_R = slice(0, 3), slice(3, 12), slice(12, 15), slice(15, 24)
ORIENTATION = 24


class Rules(NamedTuple):
    """
    Options as numbers; those that a node takes while it is active change all of it at once.

    Attributes
    ----------
    gates : Gates
    thresholds : Thresholds
    judged : bool
        Whether modes, forecast, risk and alarms are looked at.
    white : bool
        Whether innovations are white: where bias or tilt are learnt they are not.
    max_gap, max_joint_gap : float
        [s].
    delay_ns, lost_ns : int
        Of joint states; without an orientation for so long the motion is lost [ns].
    force_stddev : float
        Of a force that the rim carries [N].
    peg_height : float
        H [m].

    """

    gates: Gates
    thresholds: Thresholds
    judged: bool
    white: bool
    max_gap: float
    max_joint_gap: float
    delay_ns: int
    lost_ns: int
    force_stddev: float
    peg_height: float


class Engine(NamedTuple):
    """
    All that the next wrench depends on.

    Attributes
    ----------
    held : Held
        The estimate.
    memory : Memory
        What a judge remembers.
    innovations : Innovations
    motion : ndarray of FIELDS, shape (1,)
    counts : ndarray of int, shape (len(COUNTS),)
    fresh : Freshness
    reduction : Reduction
        From a wrench as received to one on the peg.
    covariance : ndarray, shape (6, 6)
        Of that, where each wrench is news.
    tared : ndarray, shape (6,)
        What a tare has taken, as the sensor reports it [N], [N m]; NaN before.
    q, R, wrench, u : ndarray
        Scratch: an orientation, a wrench as received, and on the peg.

    """

    held: Held
    memory: Memory
    innovations: Innovations
    motion: np.ndarray
    counts: np.ndarray
    fresh: Freshness
    reduction: Reduction
    covariance: np.ndarray
    tared: np.ndarray
    q: np.ndarray
    R: np.ndarray
    wrench: np.ndarray
    u: np.ndarray


def new_engine(held: Held, reduction: Reduction, numbers: np.ndarray) -> tuple[np.ndarray, Engine]:
    """
    Return the bytes that hold all but the estimate, and the engine whose parts look at them.

    Parameters
    ----------
    held : Held
    reduction : Reduction
    numbers : ndarray
        Of `judgement.new_judgement`, copied.

    """
    kept = (
        (float, (judgement.SIZE,)),
        (_dtype(declared.FIELDS), (1,)),
        (_dtype(declared.LEVEL_FIELDS), (3,)),
        *((float, (3, ALARM_WIDTH)) for _ in range(2)),
        *zip(innovations.TYPES, innovations.SHAPES),
        (_dtype(FIELDS), (1,)),
        (np.int64, (len(COUNTS),)),
        *((float, shape) for shape in freshness.SHAPES),
    )
    memory, parts = views(kept)
    parts[0][:] = numbers
    engine = Engine(
        held,
        Memory(*parts[:5]),
        Innovations(*parts[5:9]),
        *parts[9:11],
        Freshness(*parts[11:]),
        reduction,
        held.noise.copy(),
        np.full(6, np.nan),
        np.zeros(3),
        np.zeros((3, 3)),
        np.zeros(6),
        np.zeros(6),
    )
    return memory, engine


def _dtype(fields):
    return np.dtype([field[:2] for field in fields])


def views(kinds) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return bytes, all zero, and arrays of (type, shape) that look at them one after another."""
    sizes = [np.dtype(kind).itemsize * int(np.prod(shape)) for kind, shape in kinds]
    memory, ends = np.zeros(sum(sizes), np.uint8), np.cumsum(sizes)
    found = [
        memory[end - size : end].view(kind).reshape(shape)
        for (kind, shape), size, end in zip(kinds, sizes, ends)
    ]
    return memory, found
