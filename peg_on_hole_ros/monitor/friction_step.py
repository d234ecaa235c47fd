"""Friction that has stepped while the peg slides on three contacts."""

from math import fabs, isfinite, nan, sqrt

from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.known_quantities import Known
from peg_on_hole_ros.monitor.tuned import FRICTION_STEP
from peg_on_hole_ros.typed_record import Record


class FrictionStep(Record):
    """
    The friction of a while ago, and that before the last step.

    Attributes
    ----------
    earlier, earlier_stddev : float
        Friction from one to two intervals ago [-]; NaN: not known then.
    kept, kept_stddev : float
        Friction at the begin of the present interval [-].
    since : float
        Since the present interval began [s].
    follows : bool
        Whether friction has stepped in the present interval.
    before : float
        Friction before its last step in this contact [-]; NaN: none has been found.

    """

    earlier: float
    earlier_stddev: float
    kept: float
    kept_stddev: float
    since: float
    follows: bool
    before: float


@compiled
def forget_friction(step: FrictionStep) -> None:
    """Forget the friction of a contact that has ended."""
    step.earlier = step.earlier_stddev = step.kept = step.kept_stddev = nan
    step.since, step.follows, step.before = 0.0, False, nan


@compiled
def follow_friction(step: FrictionStep, known: Known, contacts: int, dt: float) -> None:
    """
    Compare friction with that of a while ago.

    Parameters
    ----------
    step : FrictionStep
        Changed.
    known : Known
    contacts : int
        Of ContactSet.
    dt : float
        Since the last wrench [s].

    """
    if contacts == ContactSet.NONE:
        forget_friction(step)
        return
    friction, stddev = known.friction, known.friction_stddev
    # A stated friction has no deviation, and one that is hardly known has not stepped but been
    # found.
    if contacts != ContactSet.THREE or not known.reactions_determined:
        return
    if not 0.0 < stddev <= FRICTION_STEP.known_share * friction:
        return
    step.since += dt
    apart = fabs(friction - step.earlier)
    chance = FRICTION_STEP.significance * sqrt(stddev**2 + step.earlier_stddev**2)
    if apart > max(FRICTION_STEP.least, chance) and not step.follows:
        step.before, step.since, step.follows = step.earlier, 0.0, True
    if step.since < FRICTION_STEP.interval and isfinite(step.kept):
        return
    # After a step neither is of the way to the new friction.
    if step.follows:
        step.earlier, step.earlier_stddev = friction, stddev
    else:
        step.earlier, step.earlier_stddev = step.kept, step.kept_stddev
    step.kept, step.kept_stddev = friction, stddev
    step.since, step.follows = 0.0, False
