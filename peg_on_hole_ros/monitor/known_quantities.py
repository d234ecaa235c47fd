"""What is known of friction, clearance and reactions, whatever the contact mode."""

from math import fabs, sqrt

from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.tuned import KNOWN_QUANTITIES
from peg_on_hole_ros.typed_record import Record


class Known(Record):
    """
    What is known of the scene and of the reactions.

    Attributes
    ----------
    friction, friction_stddev : float
        [-].
    clearance, clearance_stddev : float
        [m].
    reactions_determined : bool
        Whether the reactions of three contacts, if there are three, are numbers to trust.

    """

    friction: float
    friction_stddev: float
    clearance: float
    clearance_stddev: float
    reactions_determined: bool


@compiled
def fill_known(known: Known, estimate: Estimate, determinant: float, band: float) -> None:
    """
    Fill in what is known.

    Parameters
    ----------
    known : Known
        Filled in.
    estimate : Estimate
    determinant : float
        Of the six equations over its frictionless value.
    band : float
        `monitor.singular_band`.

    """
    scene, reactions, accuracy = estimate.scene, estimate.reactions, estimate.accuracy
    clearance, variance = scene.D - scene.d, max(estimate.friction_variance, 0.0)
    if variance > 0.0 and estimate.motion.gamma < scene.gamma0:
        variance += (scene.f * KNOWN_QUANTITIES.gives / clearance) ** 2
    known.friction, known.friction_stddev = scene.f, sqrt(variance + accuracy.friction)
    known.clearance = clearance
    known.clearance_stddev = sqrt(max(estimate.diameter_variance, 0.0))
    total = reactions.normal[0] + reactions.normal[1] + reactions.normal[2]
    # Beside the singular set little is known; two points in the hole have none.
    two = estimate.contacts == ContactSet.TWO
    clear = determinant > band or two
    for i in range(3):
        # There B1 and B2 are halves.
        share = 2.0 if two and i > 0 else 1.0
        clear = (
            clear
            and share * sqrt(max(reactions.covariance[i, i], 0.0) + accuracy.reactions[i])
            <= total / KNOWN_QUANTITIES.over_spread
        )
        clear = (
            clear
            and share * fabs(reactions.by_friction[i]) <= total / KNOWN_QUANTITIES.over_friction
        )
    known.reactions_determined = clear
