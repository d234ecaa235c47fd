"""Nothing is known of the contacts: the wrench corrects nothing, and there is no model of it."""

from peg_on_hole_ros.estimator.update import reset_three
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.typed_record import Floats

SOLVED_REACTIONS = 0
WRENCH_MAY_DRIVE = False
IN_HOLE = False


@compiled
def begin_reactions(x: Floats, P: Floats, first: int, variance: float) -> None:
    """Set the reactions to zero, and give each its prior variance [N^2]."""
    for i in range(first, first + 3):
        x[i] = 0.0
    reset_three(P, first, first + 3, variance)
