"""The engine's state and rules, as typed records."""

from typing import Annotated

from peg_on_hole_ros.estimator.filter_record import FilterMemory, FilterRecord
from peg_on_hole_ros.estimator.settings import Gates
from peg_on_hole_ros.measurements.freshness import Freshness
from peg_on_hole_ros.measurements.innovations import Innovations
from peg_on_hole_ros.measurements.wrench_noise.registry import WrenchNoise
from peg_on_hole_ros.measurements.wrench_reduction import ReductionSteps
from peg_on_hole_ros.monitor.memory import Memory
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.typed_record import Matrix3, Matrix6, Record, Vector3, Vector6, dtype_of

# An orientation as a row: gamma, psi, phi [rad], their covariance; place of the peg's origin [m],
# NaN where it is not measured, and its covariance.
Q, R, PLACE, PLACE_R = slice(0, 3), slice(3, 12), slice(12, 15), slice(15, 24)
ORIENTATION_WIDTH = 24


class Progress(Record):
    """
    Stamps that the engine has processed, and what is known of the motion.

    Attributes
    ----------
    t_ns
        Stamp that the estimate has come to; NO_STAMP: not started [ns].
    oriented_ns
        Stamp of the last orientation that was used [ns].
    slid_ns
        Stamp at which the peg was last known not to rest on its contacts [ns].
    in_contact : bool
        Whether the last wrench was weighed with three contacts.
    touching : bool
        Whether innovations count for or against the settings.
    blind : bool
        Whether no orientation has come for long.
    lost : bool
        Whether nothing is known of the motion.
    noise
        How much noisier than stated orientations were when they last were.

    """

    t_ns: int
    oriented_ns: int
    slid_ns: int
    in_contact: bool
    touching: bool
    blind: bool
    lost: bool
    noise: float


class Counts(Record):
    """How many messages there were of a kind, and how often something happened, by name."""

    joints_used: int
    joints_gated: int
    joints_noisy: int
    joints_dropped_repeated_value: int
    joints_gap: int
    filter_restarted: int
    contact_may_be_plate: int
    innovations_too_large: int
    motion_lost: int
    gap: int
    wrench_used: int
    wrench_spike: int
    wrench_noisy: int
    wrench_saturated: int
    wrench_stands_still: int
    wrench_dropped_without_orientation: int


COUNTS = tuple(Counts.__annotations__)


class Rules(Record):
    """
    Options as numbers; those that may change while a node is active change all at once.

    Attributes
    ----------
    gates : Gates
    monitor : MonitorSettings
    judged : bool
        Whether modes, forecast, risk and alarms are looked at.
    white : bool
        Whether innovations are white: not where bias or tilt are learnt.
    max_gap, max_joint_gap : float
        [s]
    delay_ns : int
        Of joint states [ns].
    lost_ns : int
        Without an orientation for so long the motion is lost [ns].
    joints_variance : float
        Times which the variance of an orientation is that of the stated noise [-].

    """

    gates: Gates
    monitor: MonitorSettings
    judged: bool
    white: bool
    max_gap: float
    max_joint_gap: float
    delay_ns: int
    lost_ns: int
    joints_variance: float


class EngineState(Record):
    """
    All that the next wrench depends on. What changes stands together, and ends with the estimate.

    Attributes
    ----------
    reduction : ReductionSteps
        From a wrench as received to one on the peg.
    covariance : shape (6, 6)
        Of that, where each wrench is news.
    variance : shape (6,)
        Of a wrench as received [N^2], [N^2 m^2].
    tared : shape (6,)
        Taken by a tare, as the sensor reports it [N], [N m]; NaN before.
    q, R : shape (3,), (3, 3)
        Scratch: an orientation [rad] and its covariance.
    wrench, u : shape (6,)
        Scratch: a wrench as received, and on the peg.
    memory : Memory
        What the monitor remembers.
    innovations : Innovations
    progress : Progress
    counts : Counts
    fresh : Freshness
    wrench_noise : WrenchNoise
    filter : FilterRecord, shape (1,)
        The estimate. An array, as Python hands over a record of so many fields in 0.1 ms.

    """

    reduction: ReductionSteps
    covariance: Matrix6
    variance: Vector6
    tared: Vector6
    q: Vector3
    R: Matrix3
    wrench: Vector6
    u: Vector6
    memory: Memory
    innovations: Innovations
    progress: Progress
    counts: Counts
    fresh: Freshness
    wrench_noise: WrenchNoise
    filter: Annotated[FilterMemory, FilterRecord, (1,)]


def _place(field: str) -> int:
    """Return the place of a field in bytes."""
    fields = dtype_of(EngineState).fields
    assert fields is not None
    return fields[field][1]


# What the engine remembers beside the estimate, and where that begins, in bytes.
ENGINE_MEMORY_BYTES = slice(_place("memory"), _place("filter"))
