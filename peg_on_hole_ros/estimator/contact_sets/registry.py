"""Contact sets by their members: the one place that chooses between them."""

from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.contact_sets import free, three_on_rim, two_in_hole, unknown
from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled
from peg_on_hole_ros.typed_record import Floats


@compiled
def solved_reactions(contact_set: int) -> int:
    """Return how many reactions a wrench determines; 0: it does not correct the motion."""
    if contact_set == ContactSet.THREE:
        return three_on_rim.SOLVED_REACTIONS
    if contact_set == ContactSet.TWO:
        return two_in_hole.SOLVED_REACTIONS
    if contact_set == ContactSet.NONE:
        return free.SOLVED_REACTIONS
    return unknown.SOLVED_REACTIONS


@compiled
def may_drive_motion(contact_set: int) -> bool:
    """Return whether a wrench alone may drive the motion."""
    if contact_set == ContactSet.THREE:
        return three_on_rim.WRENCH_MAY_DRIVE
    if contact_set == ContactSet.TWO:
        return two_in_hole.WRENCH_MAY_DRIVE
    if contact_set == ContactSet.NONE:
        return free.WRENCH_MAY_DRIVE
    return unknown.WRENCH_MAY_DRIVE


@compiled
def is_in_hole(contact_set: int) -> bool:
    """Return whether the peg is in the hole, on K and B."""
    if contact_set == ContactSet.THREE:
        return three_on_rim.IN_HOLE
    if contact_set == ContactSet.TWO:
        return two_in_hole.IN_HOLE
    if contact_set == ContactSet.NONE:
        return free.IN_HOLE
    return unknown.IN_HOLE


@compiled
def begin_reactions(contact_set: int, x: Floats, P: Floats, first: int, variance: float) -> None:
    """Give the reactions, from a place on, their prior with a variance [N^2]."""
    if contact_set == ContactSet.THREE:
        three_on_rim.begin_reactions(x, P, first, variance)
    elif contact_set == ContactSet.TWO:
        two_in_hole.begin_reactions(x, P, first, variance)
    elif contact_set == ContactSet.NONE:
        free.begin_reactions(x, P, first, variance)
    else:
        unknown.begin_reactions(x, P, first, variance)


@compiled
def linearise(
    contact_set: int, kalman: FilterRecord, scene: SceneScalars, x: Floats, P: Floats,
    mode_stddev: float,
) -> float:  # fmt: skip
    """Linearise the balance of a contact set that has a model; see the package."""
    if contact_set == ContactSet.THREE:
        return three_on_rim.linearise(kalman, scene, x, P, mode_stddev)
    if contact_set == ContactSet.TWO:
        return two_in_hole.linearise(kalman, scene, x, P, mode_stddev)
    return free.linearise(kalman, scene, x, P, mode_stddev)
