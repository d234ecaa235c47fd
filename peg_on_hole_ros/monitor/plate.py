"""Whether a load is that of a plate beside the hole, by its line of action."""

from math import exp, hypot

from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.linear_algebra import peg_rotation, peg_turns
from peg_on_hole_ros.monitor.contact_load import ContactLoad
from peg_on_hole_ros.monitor.line_of_action import evidence_through
from peg_on_hole_ros.monitor.motion_now import Passed
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.monitor.tuned import EVIDENCE_WEIGHTS, PLATE_TEST

# A tilted peg touches a plate at its lowest point: one force within a cone about the plate's
# normal, and no couple about that point. Contacts on the rim that carry a push along the hole have
# a couple about it of about the push times the radius: B1 and B2 are on the peg's other side. Two
# points in the hole push aslant. The couple about the hole's axis is left out: without slip there
# is none in either case. docs/modes.md, "Elsewhere", has the figures.


@compiled
def plate_evidence(estimate: Estimate, load: ContactLoad) -> float:
    """
    Return log p(load | plate below the lowest point) - log p(load | the hole's contacts).

    Parameters
    ----------
    estimate : Estimate
    load : ContactLoad
        Which has taken the wrench.

    """
    p, motion = estimate.scene, estimate.motion
    azimuth = motion.covariance[1, 1]
    if load.share <= 0.0 or azimuth > PLATE_TEST.azimuth_stddev * PLATE_TEST.azimuth_stddev:
        return 0.0
    turns = peg_turns(motion.gamma, motion.psi, motion.phi)
    r, radius = peg_rotation(turns), 0.5 * p.d
    across = max(hypot(r[6], r[7]), 1e-9)
    # From the mass centre to the lowest point, peg axes.
    a = (-radius * r[6] / across, -radius * r[7] / across, -p.H_c)
    off = PLATE_TEST.edge * PLATE_TEST.edge + radius * radius * azimuth
    ratio = evidence_through(estimate, load, a, off)
    carried = load.force
    noise = load.share * max(estimate.wrench_noise[0, 0], estimate.wrench_noise[1, 1])
    aside = hypot(carried[0], carried[1]) + PLATE_TEST.steepest * carried[2]
    if aside > 0.0:
        ratio -= 0.5 * aside * aside / (noise + estimate.bias_load)
    most: float = EVIDENCE_WEIGHTS.most
    # What is no number is no evidence.
    return min(max(ratio, -most), most) if ratio == ratio else 0.0


@compiled
def follow_plate(
    plate: float, evidence: float, prior: float, passed: Passed, settings: MonitorSettings
) -> float:
    """
    Return the probability of a plate after one more piece of evidence.

    A couple that no plate has refutes it soon; a load as a plate's may be a coincidence.
    """
    plate += (1.0 - exp(-settings.mode_change_rate * passed.dt)) * (prior - plate)
    against = min(evidence + PLATE_TEST.doubt, 0.0)
    found = min(passed.dt / PLATE_TEST.memory, 1.0) * evidence
    found += min(passed.dt / settings.evidence_time, 1.0) * against
    odds = plate * exp(found)
    return odds / (odds + 1.0 - plate)
