"""All that one wrench shows of mode and forecast."""

from math import fabs, hypot, pi, sin, sqrt
from typing import Annotated

from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.estimator.forces import rim_load
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.cone import cone_evidence
from peg_on_hole_ros.monitor.contact_load import (
    ContactLoad,
    carried_load,
    forget_load,
    stands_out,
)
from peg_on_hole_ros.monitor.contact_probabilities import (
    CLOSED,
    COUNT,
    FREE,
    LOST_B1,
    LOST_B2,
    LOST_K,
    OTHER,
    ContactEvidence,
    forget_contacts,
    load_evidence,
    misfit_evidence,
    normal_cdf,
    opening_evidence,
    weigh,
)
from peg_on_hole_ros.monitor.motion_now import Passed
from peg_on_hole_ros.monitor.motion_trend import MotionTrend, rest_probability, time_to_reach
from peg_on_hole_ros.monitor.place_check import PlaceMisfit
from peg_on_hole_ros.monitor.plate import follow_plate, plate_evidence
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.monitor.tuned import CREDITED_REACTIONS, EVIDENCE_WEIGHTS, PLATE_TEST
from peg_on_hole_ros.monitor.walls import evidence_against_walls
from peg_on_hole_ros.typed_record import Floats, Record


class Shown(Record):
    """
    What is known after one wrench.

    Attributes
    ----------
    three_point, two_point, opened, stuck, free, other, elsewhere : float
        Probabilities, together 1.
    on_hole : float
        Probability that the rim or the hole carries the peg.
    below : float
        Probability that gamma is below gamma0, clearance included.
    time, time_stddev : float
        Until gamma0 [s]; time below zero: there is none.
    wedged : float
        What a rim of this tilt may wedge against what it carries [N].
    usable : bool
        Whether the reactions of three contacts are numbers to use.
    lost_K, lost_B1, lost_B2 : float
        Probability that this contact alone has opened.

    """

    three_point: float
    two_point: float
    opened: float
    stuck: float
    free: float
    other: float
    elsewhere: float
    on_hole: float
    below: float
    time: float
    time_stddev: float
    wedged: float
    usable: bool
    lost_K: float
    lost_B1: float
    lost_B2: float


class Evidence(Record):
    """
    What wrenches have shown of the contacts.

    Attributes
    ----------
    hypotheses : ndarray, shape (6,)
        Probabilities, see `contacts`.
    plate : float
        Probability that what touches is a plate below the peg's lowest point.
    load : ContactLoad
    pressed : ContactLoad
        The same over `PLATE_TEST.memory`.
    shown : Shown
        By the last wrench.

    """

    hypotheses: Annotated[Floats, (COUNT,)]
    plate: float
    load: ContactLoad
    pressed: ContactLoad
    shown: Shown


@compiled
def forget_evidence(evidence: Evidence) -> None:
    """Forget what wrenches have shown; what the last one did stays to be read."""
    forget_contacts(evidence.hypotheses)
    evidence.plate = PLATE_TEST.prior
    forget_load(evidence.load)
    forget_load(evidence.pressed)


@compiled
def wedged_load(estimate: Estimate, force_stddev: float) -> float:
    """Return what a rim of this tilt may wedge against what it carries [N]."""
    force, couple = rim_load(estimate)
    # A squeezed peg feels a couple and no force: over the peg's radius it counts as one.
    carried = hypot(force, 2.0 * couple / estimate.scene.d)
    tilt = max(estimate.motion.gamma, estimate.scene.gamma0)
    return (carried + force_stddev) / sin(min(tilt, 0.5 * pi))


@compiled
def gamma0_slope(estimate: Estimate) -> float:
    """Return by how much gamma0 changes with the clearance [rad/m]."""
    # cos(gamma0) = 1 - clearance / D.
    return 1.0 / (estimate.scene.D * sin(estimate.scene.gamma0))


@compiled
def gamma0_variance(estimate: Estimate) -> float:
    """Return the variance that the clearance leaves gamma0 [rad^2]."""
    slope = gamma0_slope(estimate)
    return max(estimate.diameter_variance, 0.0) * slope * slope


@compiled
def below_gamma0(estimate: Estimate) -> float:
    """Return the probability that gamma is below gamma0."""
    motion = estimate.motion
    variance = max(motion.covariance[0, 0] + gamma0_variance(estimate), 1e-24)
    return normal_cdf((estimate.scene.gamma0 - motion.gamma) / sqrt(variance))


@compiled
def finite_reactions(estimate: Estimate, wedged: float) -> bool:
    """Return whether the equations gave reactions that are more than rounding."""
    N = estimate.reactions.normal
    largest = max(fabs(N[0]), fabs(N[1]), fabs(N[2]))
    known = estimate.determinant == estimate.determinant
    return known and largest <= CREDITED_REACTIONS.absurd * wedged


@compiled
def pushing(estimate: Estimate) -> bool:
    """Return whether the reactions may be those of contacts that push."""
    reactions, push = estimate.reactions, True
    for i in range(3):
        variance = max(reactions.covariance[i, i], 0.0)
        push = push and -CREDITED_REACTIONS.pull * sqrt(variance) < reactions.normal[i]
    return push


@compiled
def new_share(estimate: Estimate, i: int) -> float:
    """
    Return which share of a reaction's evidence for its contact is news at each sample.

    What friction and clearance make of a reaction stays: however many samples show it, it is one
    piece of evidence. By more than `CREDITED_REACTIONS.pull`, they do not explain it.
    """
    reactions = estimate.reactions
    N, variance = reactions.normal[i], max(reactions.covariance[i, i], 1e-18)
    if N < 0.0 and CREDITED_REACTIONS.pull * CREDITED_REACTIONS.pull * variance < N * N:
        return 1.0
    by_friction, by_diameter = reactions.by_friction[i], reactions.by_diameter[i]
    lasting: float = by_friction * by_friction + by_diameter * by_diameter
    news: float = 1.0 - lasting / variance
    return max(0.0, news)


@compiled
def weigh_wrench(
    estimate: Estimate,
    evidence: Evidence,
    motion: MotionTrend,
    settings: MonitorSettings,
    passed: Passed,
    nis: float,
    place: PlaceMisfit,
    no_way: bool,
) -> None:
    """
    Weigh the hypotheses with what a wrench shows.

    Parameters
    ----------
    estimate : Estimate
    evidence : Evidence
        Changed.
    motion : MotionTrend
    settings : MonitorSettings
    passed : Passed
    nis : float
        Running mean of the normalised innovation squared; below zero: it is not known.
    place : PlaceMisfit
        The last that was measured.
    no_way : bool
        Whether nothing has shown a peg below gamma0 in the hole, see `way_in`.

    """
    scene, p, shown = estimate.scene, evidence.hypotheses, evidence.shown
    dt, correlation = passed.dt, settings.evidence_time
    wedged = wedged_load(estimate, settings.force_stddev)
    under = below_gamma0(estimate)
    finite = finite_reactions(estimate, wedged)
    lost_K = lost_B1 = lost_B2 = 0.0
    rest = rest_probability(motion, settings.rest_rate)
    if finite:
        # At rest friction may be anything within its cone, and the equations' reactions are moot.
        moves, N, C = 1.0 - rest, estimate.reactions.normal, estimate.reactions.covariance
        lost_K = moves * new_share(estimate, 0) * opening_evidence(N[0], C[0, 0])
        lost_B1 = moves * new_share(estimate, 1) * opening_evidence(N[1], C[1, 1])
        lost_B2 = moves * new_share(estimate, 2) * opening_evidence(N[2], C[2, 2])
    other = misfit_evidence(nis) if nis >= 0.0 else 0.0
    above = 1.0 - under
    # Below gamma0 there is only the hole to touch, and what is around it: a load high above both
    # is the sensor's.
    displaced = place.evidence
    outside = displaced * under * (1.0 - place.within_reach)
    load = _load_evidence(estimate, evidence.load, settings, dt)
    load = min(load, load * (1.0 - outside / EVIDENCE_WEIGHTS.most)) - outside
    displaced *= above
    if displaced > 0.0:
        # A motion that fits three contacts is no evidence for them where the peg does not stand.
        other = max(other, 0.0)
    found = ContactEvidence(load, lost_K, lost_B1, lost_B2, other, displaced, rest)
    weigh(p, found, dt, settings.mode_change_rate, correlation)
    prior = PLATE_TEST.no_way * under + PLATE_TEST.prior * above if no_way else PLATE_TEST.prior
    carried_load(estimate, evidence.pressed, dt, PLATE_TEST.memory)
    found_plate = plate_evidence(estimate, evidence.pressed)
    if no_way and under > 0.5:
        no_walls = evidence_against_walls(estimate, evidence.pressed, place)
        no_walls = max(no_walls, cone_evidence(estimate, evidence.pressed))
        found_plate = max(found_plate, no_walls) if no_walls > 0.0 else found_plate
    found_plate *= 1.0 - p[FREE]
    evidence.plate = follow_plate(evidence.plate, found_plate, prior, passed, settings)
    plate = max(evidence.plate - PLATE_TEST.least, 0.0) / (1.0 - PLATE_TEST.least)
    fill_probabilities(shown, p, plate, place.beside, under, rest, no_way)
    spread0 = gamma0_variance(estimate)
    spread0 += (settings.forecast_clearance_stddev * gamma0_slope(estimate)) ** 2
    time, stddev = time_to_reach(motion, scene.gamma0, spread0, settings)
    shown.time = time - passed.since if time > passed.since else -1.0
    shown.time_stddev = stddev
    shown.wedged = wedged
    shown.usable = finite and pushing(estimate)


@compiled
def fill_probabilities(
    shown: Shown,
    p: Floats,
    plate: float,
    beside: float,
    under: float,
    rest: float,
    no_way: bool,
) -> None:
    """
    Fill in the probabilities of what carries the peg.

    Below gamma0 the bottom of a hole pushes as a plate does: which of them it is, only the way
    there shows, or the place.

    Parameters
    ----------
    shown : Shown
        Changed.
    p : ndarray, shape (6,)
        Probabilities of the contacts.
    plate, beside, under, rest : float
        Probabilities of a plate by the load, and by the place; of gamma below gamma0; of rest.
    no_way : bool
        As for `weigh_wrench`.

    """
    touches, above = 1.0 - p[FREE], 1.0 - under
    on_rim = above * (1.0 - beside) * (1.0 - plate)
    in_hole = under * (1.0 - beside)
    not_told = in_hole * plate if no_way else 0.0
    shown.three_point = p[CLOSED] * on_rim * (1.0 - rest)
    shown.two_point = touches * (in_hole - not_told)
    shown.opened = (p[LOST_K] + p[LOST_B1] + p[LOST_B2]) * on_rim
    shown.stuck = p[CLOSED] * on_rim * rest
    shown.free = p[FREE]
    shown.other = p[OTHER] * on_rim + touches * not_told
    shown.elsewhere = touches * (above - on_rim + under * beside)
    shown.on_hole = touches * (on_rim + in_hole - not_told)
    shown.below = under
    shown.lost_K, shown.lost_B1 = p[LOST_K] * on_rim, p[LOST_B1] * on_rim
    shown.lost_B2 = p[LOST_B2] * on_rim


@compiled
def _load_evidence(
    estimate: Estimate, load: ContactLoad, settings: MonitorSettings, dt: float
) -> float:
    """
    Return the evidence of a carried load for contact.

    A rim that touches is distinguished from noise, from an unknown bias of the sensor, and from a
    holder that moves the peg in the air.
    """
    time, threshold = settings.evidence_time, settings.contact_force_threshold
    carried, _ = carried_load(estimate, load, dt, time)
    moved = estimate.scene.m * settings.free_acceleration
    squares = stands_out(estimate, load, threshold * threshold + moved * moved, time)
    return load_evidence(squares) if carried == carried else 0.0
