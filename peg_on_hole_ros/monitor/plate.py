"""Whether a load is that of a plate beside the hole, by its line of action."""

from math import exp, hypot

from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.linear_algebra import (
    in_peg_axes,
    peg_rotation,
    peg_turns,
    surprise,
)
from peg_on_hole_ros.monitor.contact_load import ContactLoad
from peg_on_hole_ros.monitor.motion_now import Passed
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.monitor.tuned import EVIDENCE_WEIGHTS, PLATE_TEST
from peg_on_hole_ros.typed_record import Floats

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
    carried, turned = load.force, load.couple
    held = load.momentum_rate
    # What pushes the peg is against what is left for contacts to carry.
    F = in_peg_axes(turns, (-carried[0], -carried[1], -carried[2]))
    M = in_peg_axes(turns, (held[0] - turned[0], held[1] - turned[1], held[2] - turned[2]))
    M_x = M[0] - (a[1] * F[2] - a[2] * F[1])
    M_y = M[1] - (a[2] * F[0] - a[0] * F[2])
    S, white = estimate.work[:4].reshape(2, 2), estimate.work[4:6]
    moment, wide = estimate.work[6:8], estimate.work[8:12].reshape(2, 2)
    moment[0], moment[1] = M_x, M_y
    _fill_noise(estimate, a, load.share, S)
    squares = F[0] * F[0] + F[1] * F[1] + F[2] * F[2]
    off = PLATE_TEST.edge * PLATE_TEST.edge + radius * radius * azimuth
    # A squeeze is all couple, and hardly any force.
    spread = max(squares * radius * radius, M_x * M_x + M_y * M_y)
    for i in range(2):
        S[i, i] += squares * off + radius * radius * estimate.bias_load
        for j in range(i + 1):
            wide[i, j] = S[i, j] + (spread if i == j else 0.0)
    of_any, any_spread = surprise(wide, 2, moment, white)
    of_plate, plate_spread = surprise(S, 2, moment, white)
    ratio = 0.5 * (of_any + any_spread - of_plate - plate_spread)
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


@compiled
def _fill_noise(
    estimate: Estimate, a: tuple[float, float, float], share: float, S: Floats
) -> None:
    """Fill in the covariance of the couple across the peg about a point [N^2 m^2], peg axes."""
    J = estimate.work[12:24].reshape(2, 6)
    J[:, :] = 0.0
    J[0, 1], J[0, 2], J[0, 3] = a[2], -a[1], 1.0
    J[1, 0], J[1, 2], J[1, 4] = -a[2], a[0], 1.0
    for i in range(2):
        for j in range(i + 1):
            S[i, j] = 0.0
            for k in range(6):
                for l in range(6):
                    S[i, j] += share * J[i, k] * estimate.wrench_noise[k, l] * J[j, l]
