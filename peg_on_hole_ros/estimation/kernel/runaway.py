"""Whether a motion runs away from its prediction faster than any estimate could follow."""

from peg_on_hole_ros.estimation.kernel.held_wrench import move_wrench
from peg_on_hole_ros.estimation.kernel.memory import BEGIN, RAMP, SCALES, WORK, U, X
from peg_on_hole_ros.estimation.steps.implicit_euler import determinant_of
from peg_on_hole_ros.mechanics.kernel import WIDTH, accelerate_with_derivatives, compiled, inlined

# Rates at which small changes of a motion may grow [1/s]. Those of pegs that a filter follows grow
# by 10 to 300 a second; where a contact slows down under a great load, by thousands.
FASTEST_GROWTH = 600.0


@inlined
def solve_at_begin(p, m):
    """Fill BEGIN under the wrench that is held; return its derivatives, a view, shape (6, 14)."""
    y, dy = m[BEGIN : BEGIN + 6], m[BEGIN + 6 : BEGIN + 6 + 6 * WIDTH].reshape(6, WIDTH)
    accelerate_with_derivatives(
        p, m[SCALES : SCALES + 3], m[X : X + 6], m[U : U + 6], m[WORK:], y, dy
    )
    return dy


@compiled
def runs_away(p, m):
    """
    Return whether a small change of the motion grows faster than FASTEST_GROWTH under this wrench.

    Dry friction turns with the slip. Where a loaded contact slows down, that pushes a peg on in
    the direction in which it has strayed, and in a rigid world the faster the slower it slips:
    only what holds the peg keeps it on its way, which no wrench of the past tells. An implicit
    step does not show it. Above the inverse of its length it damps what grows, and states a
    motion that is a guess for one that is known.

    Growth s has s v = A_v v + A_q v / s, by the derivatives of the accelerations. Their matrix
    1 - (A_v + A_q h) h, that of the implicit step, has a determinant that is 1 for h = 0, and
    passes zero at the inverse of the fastest growth.

    Parameters
    ----------
    p : SceneScalars
    m : ndarray
        Memory, with state, wrench and velocity scales of friction at the begin of the interval;
        BEGIN is filled, under the wrench at its end.

    """
    # The stamp of the wrench may be later.
    left = 1.0 - m[RAMP + 7]
    move_wrench(m, -left)
    dy = solve_at_begin(p, m)
    move_wrench(m, left)
    return determinant_of(1.0 / FASTEST_GROWTH, dy) < 0.0
