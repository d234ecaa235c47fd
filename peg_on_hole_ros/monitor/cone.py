"""
Whether a load is that of a cone under the lower edge, as of a chamfer, by its line of action.

A cone touches the lower edge at one point and pushes it inwards and up: the force comes from
there, and has no couple about it. What is one wall's leans farther than its friction allows here,
and rim and wall together have a couple about that point, but at one depth that is soon passed.
"""

from math import hypot, sqrt

from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.linear_algebra import in_peg_axes, peg_turns
from peg_on_hole_ros.monitor.contact_load import ContactLoad
from peg_on_hole_ros.monitor.line_of_action import evidence_through
from peg_on_hole_ros.monitor.tuned import EVIDENCE_WEIGHTS, PLATE_TEST, WALLS_TEST
from peg_on_hole_ros.monitor.walls import most_friction


@compiled
def cone_evidence(estimate: Estimate, load: ContactLoad) -> float:
    """
    Return log p(load | a cone below the edge) - log p(load | rim and wall), at least 0.

    Parameters
    ----------
    estimate : Estimate
    load : ContactLoad
        Which has taken the wrench.

    """
    p, motion, force = estimate.scene, estimate.motion, load.force
    push, side, radius = -force[2], hypot(force[0], force[1]), 0.5 * p.d
    if load.share <= 0.0 or push <= 0.0 or side <= 0.0:
        return 0.0
    of_force = load.share * estimate.wrench_noise[0, 0] + estimate.bias_load
    beyond = push - most_friction(estimate) * side
    if beyond < WALLS_TEST.sure * sqrt(of_force + (WALLS_TEST.share * push) ** 2):
        return 0.0
    turns = peg_turns(motion.gamma, motion.psi, motion.phi)
    # What the peg hands on leads to where it stands; from the mass centre, peg axes.
    x, y, _ = in_peg_axes(turns, (force[0] / side, force[1] / side, 0.0))
    a = (radius * x, radius * y, -p.H_c)
    off = PLATE_TEST.edge * PLATE_TEST.edge + radius * radius * of_force / (side * side)
    ratio = evidence_through(estimate, load, a, off)
    most: float = EVIDENCE_WEIGHTS.most
    return min(max(ratio, 0.0), most) if ratio == ratio else 0.0
