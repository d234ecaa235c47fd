"""Mode, transition, risk and alarms of an estimate, as one row of numbers."""

from math import fabs

from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.estimator.fill_outputs import fill_outputs
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.alarms import follow_alarms
from peg_on_hole_ros.monitor.closed_contacts import is_closed
from peg_on_hole_ros.monitor.dangers.registry import assess_dangers, fill_dangers, restart_trends
from peg_on_hole_ros.monitor.evidence import weigh_wrench
from peg_on_hole_ros.monitor.friction_step import follow_friction
from peg_on_hole_ros.monitor.inserted import follow_insertion, published_mode
from peg_on_hole_ros.monitor.insertion_depth import insertion_depth, insertion_speed
from peg_on_hole_ros.monitor.known_quantities import Known, fill_known
from peg_on_hole_ros.monitor.memory import Memory, restart_mode
from peg_on_hole_ros.monitor.mode import declare_mode
from peg_on_hole_ros.monitor.motion_now import Passed
from peg_on_hole_ros.monitor.motion_trend import follow_motion
from peg_on_hole_ros.monitor.one_point import B_ALONE, K_ALONE, forget_points, weigh_points
from peg_on_hole_ros.monitor.rest_in_hole import follow_depth
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.monitor.states import NO_STAMP, Mode, Touch
from peg_on_hole_ros.monitor.transition import update_flag
from peg_on_hole_ros.monitor.way_in import follow_way, has_no_way
from peg_on_hole_ros.outputs import Row
from peg_on_hole_ros.typed_record import Floats


@compiled
def take_orientation(
    memory: Memory, settings: MonitorSettings, t_ns: int, q: Floats, R: Floats, foreseen: bool
) -> None:
    """
    Process an orientation that the filter has used.

    Parameters
    ----------
    memory : Memory
        Changed.
    settings : MonitorSettings
    t_ns : int
        [ns].
    q : ndarray, shape (3,)
        gamma, psi, phi [rad].
    R : ndarray, shape (3, 3)
        Covariance [rad^2].
    foreseen : bool
        Whether the peg has moved as the filter predicted, without any widening.

    """
    never = memory.oriented_ns == NO_STAMP
    since = -1.0 if never else (t_ns - memory.oriented_ns) * 1e-9
    memory.oriented_ns = t_ns
    follow_orientation(memory, since, q, R, settings)
    if not foreseen:
        restart_trends(memory.dangers)


@compiled
def follow_orientation(
    memory: Memory, since: float, q: Floats, R: Floats, settings: MonitorSettings
) -> None:
    """Add an orientation to the motion; see `follow_motion` and `follow_depth`."""
    follow_depth(memory.depth, q[0], R[0, 0], since, settings)
    follow_motion(memory.motion, since, q, R, settings)


@compiled
def contacts_of(memory: Memory) -> ContactSet:
    """
    Return which contacts the next wrench is weighed with.

    B1 and B2 become one at gamma0, and no mode has to be declared for it. Three beside the mode
    too: where an uncertain clearance alone leaves it open whether the peg is already in the hole,
    only the equations of three contacts show, by learning it. What has been refuted is weighed
    as what it may become: a mode that is wrong is refuted again before it is declared.
    """
    declared = memory.declared
    if declared.three_point_tried:
        return ContactSet.THREE
    if declared.weighed == Mode.THREE_POINT or declared.weighed == Mode.TWO_POINT:
        inside = memory.evidence.shown.below > 0.5
        return ContactSet.TWO if inside else ContactSet.THREE
    return ContactSet.NONE if declared.weighed == Mode.OPEN else ContactSet.UNKNOWN


@compiled
def follow_wrench(
    estimate: Estimate, memory: Memory, settings: MonitorSettings, passed: Passed, nis: float
) -> None:
    """
    Process the estimate after a wrench: which contacts it shows, the dangers, and what is known.

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
    weigh_wrench(estimate, evidence, motion, settings, passed, nis, memory.place, no_way)
    if estimate.contacts == ContactSet.TWO:
        rate, correlation = settings.mode_change_rate, settings.evidence_time
        weigh_points(memory.points, estimate, passed.dt, rate, correlation)
    else:
        forget_points(memory.points)
    assess_dangers(estimate, dangers, motion, memory.depth, evidence.shown, settings, passed)
    determinant = min(dangers.wedging.determinant, fabs(estimate.determinant))
    fill_known(memory.known, estimate, determinant, settings.singular_band)
    follow_friction(memory.friction, memory.known, estimate.contacts, passed.dt)


@compiled
def assess(
    estimate: Estimate,
    memory: Memory,
    settings: MonitorSettings,
    t_ns: int,
    nis: float,
    blind: bool,
    row: Row,
) -> None:
    """
    Fill in what is published at a stamp, with the memory that mode, flag and alarms need.

    Parameters
    ----------
    estimate : Estimate
        Which has taken the wrench of the stamp.
    memory : Memory
        Changed.
    settings : MonitorSettings
    t_ns : int
    nis : float
        Running mean of the normalised innovation squared (3 degrees of freedom).
    blind : bool
        Whether no orientation has come for long: where the peg is is a guess, so that no risk is
        published, and flag and alarms stay as they are.
    row : Row
        Filled, but for what is learnt of bias and tilt; given with no number in it.

    """
    if blind:
        restart_mode(memory)
    declared, transition, shown = memory.declared, memory.transition, memory.evidence.shown
    t = t_ns * 1e-9
    dt = 0.0 if memory.t_ns == NO_STAMP else (t_ns - memory.t_ns) * 1e-9
    memory.t_ns = t_ns
    since = 0.0 if memory.oriented_ns == NO_STAMP else (t_ns - memory.oriented_ns) * 1e-9
    # Constant rates count neither for nor against three contacts.
    on_three = declared.weighed == Mode.THREE_POINT or declared.three_point_tried
    follow_wrench(estimate, memory, settings, Passed(dt, since), nis if on_three else -1.0)
    declare_mode(declared, settings, t, shown)
    if not blind:
        update_flag(transition, settings, t, shown.below, shown.on_hole)
    follow_way(memory.way, declared.mode, memory.evidence, memory.place, transition.flag, t)
    follow_insertion(memory.insertion, declared.mode, shown, memory.place, settings, t)
    declared.three_point_tried = (
        memory.known.clearance_stddev > 0.0
        and not transition.flag
        and shown.three_point >= 1.0 - settings.transition_probability_on
        and shown.three_point + shown.two_point >= settings.mode_probability_on
    )
    three_point = declared.mode == Mode.THREE_POINT and shown.usable
    on_contacts = 3 if three_point else 0
    in_contact = declared.mode == Mode.THREE_POINT or declared.mode == Mode.TWO_POINT
    if estimate.contacts == ContactSet.TWO and in_contact:
        on_contacts = 2
    fill_known_outputs(row, shown.below, memory.known, on_contacts > 0)
    row.friction_before = memory.friction.before
    _fill_modes(row, memory, t)
    if declared.mode != Mode.OPEN and not blind:
        fill_dangers(memory.dangers, row)
    if on_contacts == 2 and not blind:
        _fill_insertion(row, estimate, memory)
    # Nothing is known of the reactions elsewhere, but how large they can be: none in the air,
    # and otherwise what a rim of this tilt may wedge against what it carries.
    wide = settings.force_stddev
    if three_point:
        if shown.time >= 0.0:
            row.time_to_transition = shown.time
            row.time_to_transition_stddev = shown.time_stddev
    elif declared.mode != Mode.OPEN:
        wide = shown.wedged
    fill_outputs(estimate, settings.peg_height, on_contacts, wide, row)
    if not blind:
        dangers = memory.dangers
        follow_alarms(memory.alarms, declared.mode, settings, t, dangers, shown, row.normal)
    fill_declared(row, memory)


@compiled
def fill_known_outputs(row: Row, below: float, known: Known, on_contacts: bool) -> None:
    """Fill in what is known of transition, scene and reactions."""
    row.transition_probability = below
    row.friction, row.friction_stddev = known.friction, known.friction_stddev
    row.clearance, row.clearance_stddev = known.clearance, known.clearance_stddev
    determined = known.reactions_determined and on_contacts
    row.reactions_determined = 1.0 if determined else 0.0


@compiled
def fill_declared(row: Row, memory: Memory) -> None:
    """Fill in mode, with the contacts that it implies, flag and alarms as they stand."""
    mode = memory.declared.mode
    row.contact_mode = published_mode(memory.insertion, mode)
    row.transition = memory.transition.flag
    for i in range(3):
        row.closed[i] = is_closed(mode, row.normal[i])
        alarm, published = row.alarms[i], memory.alarms.published[i]
        alarm.level, alarm.which = published.level, published.which
        alarm.held, alarm.kind = published.held, published.kind
        alarm.numbers[:] = published.numbers


@compiled
def _fill_modes(row: Row, memory: Memory, t: float) -> None:
    declared, place, shown = memory.declared, memory.place, memory.evidence.shown
    row.three_point_validity = shown.three_point + shown.stuck
    row.mode_probability_three_point = shown.three_point
    row.mode_probability_two_point = shown.two_point
    row.mode_probability_opened = shown.opened
    row.mode_probability_stuck = shown.stuck
    row.mode_probability_free = shown.free
    row.mode_probability_unknown = shown.other
    row.mode_probability_elsewhere = shown.elsewhere
    row.position_offset, row.position_misfit = place.offset, place.deviations
    age, latency = t - declared.touch_changed, declared.touch_latency
    if declared.touch_change == Touch.TOUCHING:
        row.contact_age, row.contact_latency = age, latency
    elif declared.touch_change == Touch.APART:
        row.free_age, row.free_latency = age, latency


@compiled
def _fill_insertion(row: Row, estimate: Estimate, memory: Memory) -> None:
    points, two_point = memory.points, memory.evidence.shown.two_point
    row.mode_probability_K_alone = two_point * points[K_ALONE]
    row.mode_probability_B_alone = two_point * points[B_ALONE]
    row.insertion_depth, row.insertion_depth_stddev = insertion_depth(estimate)
    if row.insertion_depth == row.insertion_depth:
        row.insertion_speed, row.insertion_speed_stddev = insertion_speed(estimate)
