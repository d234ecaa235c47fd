"""What one wrench shows and threatens."""

from math import fabs

from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.dangers.registry import assess_dangers
from peg_on_hole_ros.monitor.down_the_hole import follow_depth
from peg_on_hole_ros.monitor.evidence import show
from peg_on_hole_ros.monitor.friction_step import follow_friction
from peg_on_hole_ros.monitor.known_quantities import fill_known
from peg_on_hole_ros.monitor.memory import Memory
from peg_on_hole_ros.monitor.motion_now import Passed
from peg_on_hole_ros.monitor.motion_trend import follow_motion
from peg_on_hole_ros.monitor.one_point import forget_points, weigh_points
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.monitor.way_in import has_no_way
from peg_on_hole_ros.typed_record import Floats


@compiled
def follow_orientation(
    memory: Memory, since: float, q: Floats, R: Floats, settings: MonitorSettings
) -> None:
    """Add an orientation to the motion; see `follow_motion` and `follow_depth`."""
    follow_depth(memory.depth, q[0], R[0, 0], since, settings)
    follow_motion(memory.motion, since, q, R, settings)


@compiled
def judge(
    estimate: Estimate, memory: Memory, settings: MonitorSettings, passed: Passed, nis: float
) -> None:
    """
    Fill in what is shown, the dangers, and what is known.

    Parameters
    ----------
    estimate : Estimate
    memory : Memory
        Changed.
    settings : MonitorSettings
    passed : Passed
    nis : float
        Running mean of the normalised innovation squared; below zero: it is not known.

    """
    evidence, motion, dangers = memory.evidence, memory.motion, memory.dangers
    no_way = has_no_way(memory.way)
    show(estimate, evidence, motion, settings, passed, nis, memory.place, no_way)
    if estimate.contacts == ContactSet.TWO:
        rate, correlation = settings.mode_change_rate, settings.evidence_time
        weigh_points(memory.points, estimate, passed.dt, rate, correlation)
    else:
        forget_points(memory.points)
    assess_dangers(estimate, dangers, motion, memory.depth, evidence.shown, settings, passed)
    determinant = min(dangers.wedging.determinant, fabs(estimate.determinant))
    fill_known(memory.known, estimate, determinant, settings.singular_band)
    follow_friction(memory.friction, memory.known, estimate.contacts, passed.dt)
