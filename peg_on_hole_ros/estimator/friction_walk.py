"""Friction that changes while the peg slides, and how well it may be learnt meanwhile."""

from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.state import FRICTION
from peg_on_hole_ros.mechanics.kernel import compiled


@compiled
def add_friction_noise(kalman: FilterRecord, component: int, dt: float) -> None:
    """
    Add the walk of friction in the top process-noise mode to a component, over a time [s].

    Where friction steps, no calm motion fits the reactions that the former friction leaves, and
    the evidence goes to the mode in which accelerations jump. With a friction that stays, that
    mode explains the step by accelerations for good: nothing is left for friction to be learnt
    from. With a friction that walks it finds the new one within some wrenches; the modes below,
    which are mixed from it once it is likely, go on with that, and win for they need no
    accelerations.
    """
    settings, walk = kalman.settings, kalman.settings.top_friction_walk
    if settings.modes < 2 or component % settings.modes < settings.modes - 1:
        return
    # In the hole, where a balance of two contacts leaves more to the model, friction would follow
    # what the model lacks.
    if kalman.state.contact_set != ContactSet.THREE:
        return
    # A friction that is known, or only considered, is not found anew.
    if kalman.friction_open and kalman.estimated[FRICTION] > 0.0:
        kalman.state.P[component, FRICTION, FRICTION] += walk * walk * dt


@compiled
def keep_friction_floor(
    kalman: FilterRecord, component: int, turned: float, friction: float
) -> float:
    """
    Return the floor of friction's variance in a component, and keep it until the next wrench.

    It is the friction error that the uncertain slip direction could cause. Orientations and
    depths correct friction by what it has in common with the motion, so it holds for them, too.

    Parameters
    ----------
    kalman : FilterRecord
        `state.friction_floor` is filled in.
    component : int
    turned : float
        See `direction.friction_direction_statistics`.
    friction : float
        Of the component, or as stated where that is more.

    """
    floor = turned * turned * friction * friction
    kalman.state.friction_floor[component] = floor
    return floor
