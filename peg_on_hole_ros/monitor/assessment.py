"""What an estimate says of the contact: mode, transition, risk, alarms, as one row of numbers."""

from math import nan

import numpy as np
from numba.np.unsafe.ndarray import to_fixed_tuple

from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.description import SIZE as DESCRIBED
from peg_on_hole_ros.estimator.description import describe
from peg_on_hole_ros.estimator.record import Estimate
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor import evidence
from peg_on_hole_ros.monitor.alarms import clear_alarms, follow_alarms
from peg_on_hole_ros.monitor.evidence import Shown
from peg_on_hole_ros.monitor.insertion_depth import insertion_depth, insertion_speed
from peg_on_hole_ros.monitor.jamming import Risk
from peg_on_hole_ros.monitor.judgement import (
    KNOWN,
    POINTS,
    RISK,
    SHOWN,
    break_course,
    follow_orientation,
    forget,
    forget_motion,
    judge,
)
from peg_on_hole_ros.monitor.known_quantities import Known
from peg_on_hole_ros.monitor.memory import IN_AIR, NO_STAMP, THREE_POINT, TWO_POINT
from peg_on_hole_ros.monitor.mode import declare_mode, forget_mode
from peg_on_hole_ros.monitor.one_point import B_ALONE, K_ALONE
from peg_on_hole_ros.monitor.output_row import ALARM_WIDTH, ALARMS, AT, FLAG, MODE, MONITOR
from peg_on_hole_ros.monitor.transition import lower_flag, raise_flag
from peg_on_hole_ros.record_types import MemoryRecord, ThresholdsRecord

# Where the reactions stand in a description.
_NORMAL = slice(42, 45)
BELOW = SHOWN + Shown._fields.index("below")
_SHOWN, _RISKS, _KNOWN = evidence.WIDTH, len(Risk._fields), len(Known._fields)


@compiled
def restart_mode(memory: MemoryRecord) -> None:
    """Forget the mode: the estimate has begun anew."""
    d = memory.declared[0]
    forget_mode(d)
    forget(memory.numbers)
    d.t_ns = d.oriented_ns = NO_STAMP
    d.on_trial = 0
    d.offset = d.deviations = nan
    d.displaced = 0.0


@compiled
def restart(memory: MemoryRecord) -> None:
    """Forget mode, flag, alarms and the motion."""
    restart_mode(memory)
    forget_motion(memory.numbers)
    lower_flag(memory.declared[0])
    clear_alarms(memory)


@compiled
def take_orientation(
    memory: MemoryRecord, t_ns: int, q: np.ndarray, R: np.ndarray, foreseen: bool
) -> None:
    """
    Take an orientation that the filter has used.

    Parameters
    ----------
    memory : record of MEMORY
        Changed.
    t_ns : int
        [ns].
    q : ndarray, shape (3,)
        gamma, psi, phi [rad].
    R : ndarray, shape (3, 3)
        Covariance [rad^2].
    foreseen : bool
        Whether the peg has moved as the filter predicted, without any widening.

    """
    d = memory.declared[0]
    since = -1.0 if d.oriented_ns == NO_STAMP else (t_ns - d.oriented_ns) * 1e-9
    d.oriented_ns = t_ns
    follow_orientation(memory.numbers, since, q, R)
    if not foreseen:
        break_course(memory.numbers)


@compiled
def contacts_of(memory: MemoryRecord) -> ContactSet:
    """
    Return which contacts the next wrench is weighed with.

    B1 and B2 become one at gamma0, and no mode has to be declared for it. Three beside the mode
    too: where an uncertain clearance alone leaves it open whether the peg is already in the hole,
    only the equations of three contacts can tell, by learning it. What has been refuted is weighed
    as what it may become: a mode that is wrong is refuted again before it is declared.
    """
    d = memory.declared[0]
    if d.on_trial:
        return ContactSet.THREE
    if d.weighed == THREE_POINT or d.weighed == TWO_POINT:
        return ContactSet.TWO if memory.numbers[BELOW] > 0.5 else ContactSet.THREE
    return ContactSet.NONE if d.weighed == IN_AIR else ContactSet.UNKNOWN


@compiled
def assess(
    estimate: Estimate,
    memory: MemoryRecord,
    o: ThresholdsRecord,
    force_stddev: float,
    peg_height: float,
    t_ns: int,
    nis: float,
    blind: bool,
    row: np.ndarray,
) -> None:
    """
    Fill in what is published at a stamp, with the memory that mode, flag and alarms need.

    Parameters
    ----------
    estimate : Estimate
        Which has taken the wrench of the stamp.
    memory : record of MEMORY
        Changed.
    o : record of THRESHOLDS
    force_stddev : float
        Of a force that the rim carries [N].
    peg_height : float
        H [m].
    t_ns : int
    nis : float
        Running mean of the normalised innovation squared (3 degrees of freedom).
    blind : bool
        Whether no orientation has come for long: where the peg is is a guess, so that no risk is
        told, and flag and alarms stay as they are.
    row : ndarray, shape (SIZE,)
        Filled, but for what is learnt of bias and tilt; see `row`.

    """
    if blind:
        restart_mode(memory)
    d, m = memory.declared[0], memory.numbers
    t = t_ns * 1e-9
    dt = 0.0 if d.t_ns == NO_STAMP else (t_ns - d.t_ns) * 1e-9
    d.t_ns = t_ns
    since = 0.0 if d.oriented_ns == NO_STAMP else (t_ns - d.oriented_ns) * 1e-9
    # Constant rates say nothing for or against three contacts.
    told = nis if d.weighed == THREE_POINT or d.on_trial else -1.0
    judge(estimate, m, dt, since, told, estimate.determinant, d.displaced)
    shown = Shown(*to_fixed_tuple(m[SHOWN:RISK], _SHOWN))  # type: ignore[call-arg]
    risk = Risk(*to_fixed_tuple(m[RISK:KNOWN], _RISKS))
    known = Known(*to_fixed_tuple(m[KNOWN:], _KNOWN))
    declare_mode(d, o, t, shown)
    if not blind:
        raise_flag(d, o, t, shown.below, 1.0 - shown.free)
    d.on_trial = (
        known.clearance_stddev > 0.0
        and not d.flag
        and shown.three_point >= 1.0 - o.transition_probability_on
        and shown.three_point + shown.two_point >= o.mode_probability_on
    )
    three_point = d.mode == THREE_POINT and shown.usable > 0.0
    on_contacts = 3 if three_point else 0
    if estimate.contacts == ContactSet.TWO and (d.mode == THREE_POINT or d.mode == TWO_POINT):
        on_contacts = 2
    row[MONITOR:MODE] = nan
    fill_known(row, shown.below, known, on_contacts > 0)
    _fill_modes(row, d, t, shown)
    if d.mode != IN_AIR and not blind:
        _fill_risk(row, risk)
    if on_contacts == 2 and not blind:
        row[AT.mode_probability_K_alone] = shown.two_point * m[POINTS + K_ALONE]
        row[AT.mode_probability_B_alone] = shown.two_point * m[POINTS + B_ALONE]
        row[AT.insertion_depth], row[AT.insertion_depth_stddev] = insertion_depth(estimate)
        if row[AT.insertion_depth] == row[AT.insertion_depth]:
            row[AT.insertion_speed], row[AT.insertion_speed_stddev] = insertion_speed(estimate)
    # Nothing is known of the reactions elsewhere, but how large they can be: none in the air,
    # and otherwise what a rim of this tilt may wedge against what it carries.
    wide = force_stddev
    if three_point:
        if shown.time >= 0.0:
            row[AT.time_to_transition] = shown.time
            row[AT.time_to_transition_stddev] = shown.time_stddev
    elif d.mode != IN_AIR:
        wide = shown.wedged
    describe(estimate, peg_height, on_contacts, wide, row[:DESCRIBED])
    if not blind:
        follow_alarms(memory, o, t, risk, shown, row[_NORMAL])
    fill_declared(row, memory)


@compiled
def fill_known(row: np.ndarray, below: float, known: Known, on_contacts: int) -> None:
    """Fill in what is known of transition, scene and reactions."""
    row[AT.transition_probability] = below
    row[AT.friction], row[AT.friction_stddev] = known.friction, known.friction_stddev
    row[AT.clearance], row[AT.clearance_stddev] = known.clearance, known.clearance_stddev
    row[AT.reactions_determined] = known.reactions if on_contacts else 0.0


@compiled
def fill_declared(row: np.ndarray, memory: MemoryRecord) -> None:
    """Fill in mode, flag and alarms as they stand."""
    d = memory.declared[0]
    row[MODE], row[FLAG] = d.mode, d.flag
    for i in range(3):
        row[ALARMS + i * ALARM_WIDTH : ALARMS + (i + 1) * ALARM_WIDTH] = memory.said[i]


@compiled
def _fill_modes(row, d, t, shown):
    row[AT.three_point_validity] = shown.three_point + shown.stuck
    row[AT.mode_probability_three_point] = shown.three_point
    row[AT.mode_probability_two_point] = shown.two_point
    row[AT.mode_probability_opened] = shown.opened
    row[AT.mode_probability_stuck] = shown.stuck
    row[AT.mode_probability_free] = shown.free
    row[AT.mode_probability_unknown] = shown.other
    row[AT.position_offset], row[AT.position_misfit] = d.offset, d.deviations
    if d.onset == 1:
        row[AT.contact_age], row[AT.contact_latency] = t - d.turned, d.latency
    elif d.onset == 0:
        row[AT.free_age], row[AT.free_latency] = t - d.turned, d.latency


@compiled
def _fill_risk(row, risk):
    row[AT.jamming_risk] = risk.risk
    row[AT.jamming_wedging] = risk.wedging
    row[AT.jamming_stall] = risk.stall
    row[AT.jamming_load] = risk.load
    if risk.insertion != 0.0:
        row[AT.insertion_ratio], row[AT.whitney_margin] = risk.insertion, risk.margin
    else:
        row[AT.determinant] = risk.determinant
