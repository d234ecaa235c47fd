"""What the monitor remembers from one wrench to the next, as one typed record."""

from typing import Annotated

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor import one_point
from peg_on_hole_ros.monitor.alarms import Alarms, clear_alarms
from peg_on_hole_ros.monitor.dangers.registry import Dangers, forget_dangers
from peg_on_hole_ros.monitor.evidence import Evidence, forget_evidence
from peg_on_hole_ros.monitor.friction_step import FrictionStep, forget_friction
from peg_on_hole_ros.monitor.inserted import Insertion, forget_insertion
from peg_on_hole_ros.monitor.known_quantities import Known
from peg_on_hole_ros.monitor.mode import DeclaredMode, forget_mode
from peg_on_hole_ros.monitor.motion_trend import MotionTrend, forget_motion
from peg_on_hole_ros.monitor.one_point import forget_points
from peg_on_hole_ros.monitor.place_check import PlaceMisfit, forget_place
from peg_on_hole_ros.monitor.rest_in_hole import DepthTrend, forget_depth
from peg_on_hole_ros.monitor.states import NO_STAMP
from peg_on_hole_ros.monitor.transition import Transition, lower_flag
from peg_on_hole_ros.monitor.way_in import WayIn, forget_way
from peg_on_hole_ros.typed_record import Floats, Record, new


class Memory(Record):
    """
    All that the next output depends on beside the estimate.

    Attributes
    ----------
    t_ns, oriented_ns : int
        Stamps of the last wrench and of the last orientation, NO_STAMP before [ns].
    declared : DeclaredMode
    transition : Transition
    place : PlaceMisfit
        As it was measured last.
    way : WayIn
    insertion : Insertion
    evidence : Evidence
        What wrenches have shown of the contacts.
    points : ndarray, shape (3,)
        Probabilities of the contacts of two points, see `one_point`.
    motion : MotionTrend
    depth : DepthTrend
    dangers : Dangers
    known : Known
    friction : FrictionStep
    alarms : Alarms

    """

    t_ns: int
    oriented_ns: int
    declared: DeclaredMode
    transition: Transition
    place: PlaceMisfit
    way: WayIn
    insertion: Insertion
    evidence: Evidence
    points: Annotated[Floats, (one_point.COUNT,)]
    motion: MotionTrend
    depth: DepthTrend
    dangers: Dangers
    known: Known
    friction: FrictionStep
    alarms: Alarms


def begin_memory(memory: Memory) -> None:
    """Forget motion, contacts, loads and what is known; mode, flag and alarms stay."""
    nothing = new(Memory)
    forget_contacts_and_loads(nothing)
    memory.evidence, memory.points = nothing.evidence, nothing.points
    memory.motion, memory.depth = nothing.motion, nothing.depth
    memory.dangers, memory.known = nothing.dangers, nothing.known
    memory.friction = nothing.friction
    forget_way(memory.way)


@compiled
def forget_contacts_and_loads(memory: Memory) -> None:
    """Forget what was seen of contacts and loads, but for the motion."""
    forget_evidence(memory.evidence)
    forget_points(memory.points)
    forget_dangers(memory.dangers)
    forget_friction(memory.friction)


@compiled
def restart_mode(memory: Memory) -> None:
    """Forget the mode: the estimate has begun anew."""
    forget_mode(memory.declared)
    forget_contacts_and_loads(memory)
    memory.t_ns = memory.oriented_ns = NO_STAMP
    forget_place(memory.place)
    forget_insertion(memory.insertion)


@compiled
def begin_mode_anew(memory: Memory) -> None:
    """Forget mode and alarms; where the peg is, and its flag, stay."""
    restart_mode(memory)
    clear_alarms(memory.alarms)


@compiled
def restart(memory: Memory) -> None:
    """Forget mode, flag, alarms and the motion."""
    restart_mode(memory)
    forget_way(memory.way)
    forget_motion(memory.motion)
    forget_depth(memory.depth)
    lower_flag(memory.transition)
    clear_alarms(memory.alarms)
