"""Whether the slip keeps its direction over a step, and with it friction."""

from peg_on_hole_ros.estimation.kernel.held_wrench import move_wrench, ramps
from peg_on_hole_ros.estimation.kernel.memory import (
    BEGIN,
    RAMP,
    X,
    covariance_entry,
    times_covariance,
)
from peg_on_hole_ros.estimation.kernel.runaway import solve_at_begin
from peg_on_hole_ros.estimation.kernel.slip import along
from peg_on_hole_ros.estimation.steps.implicit_euler import fill_slopes, inverse_of, times_column
from peg_on_hole_ros.mechanics.kernel import WIDTH, closed_forms, compiled


@compiled
def slip_without_kink(p, m, dt):
    """
    Return how far from none the slip would be after an interval, if friction did not turn round.

    Where friction stops the peg, or nearly, neither the state at the end nor its spread shows what
    led there. The linearly implicit step goes on past the kink of dry friction, and its slopes
    are those of a smooth motion: what it makes of each contact's slip, along the present one, says
    whether the interval surely ends in a slip, or surely past one that turned round.

    Parameters
    ----------
    p : SceneScalars
    m : ndarray
        Memory, with state and covariance at the begin of the interval, and BEGIN as `runs_away`
        has filled it; it is used up.
    dt : float
        [s].

    Returns
    -------
    distance : float
        In squared standard deviations, of the contact where it is most.
    evaluations : int
        Of the six equations.

    """
    y, dy = m[BEGIN : BEGIN + 6], m[BEGIN + 6 : BEGIN + 6 + 6 * WIDTH].reshape(6, WIDTH)
    evaluations = 0
    if ramps(m):
        # It was filled under the wrench at the end; this asks for the mean one.
        back = 1.0 - 0.5 * (m[RAMP + 6] + m[RAMP + 7])
        move_wrench(m, -back)
        solve_at_begin(p, m)
        move_wrench(m, back)
        evaluations = 1
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, m[X])
    r0, r1, r2 = m[X + 3], m[X + 4], m[X + 5]
    row0, row1, row2 = inverse_of(dt, dy)
    a0 = dt * (y[0] + dt * (dy[0, 0] * r0 + dy[0, 1] * r1 + dy[0, 2] * r2))
    a1 = dt * (y[1] + dt * (dy[1, 0] * r0 + dy[1, 1] * r1 + dy[1, 2] * r2))
    a2 = dt * (y[2] + dt * (dy[2, 0] * r0 + dy[2, 1] * r1 + dy[2, 2] * r2))
    gain0 = times_column(row0, a0, a1, a2)
    gain1 = times_column(row1, a0, a1, a2)
    gain2 = times_column(row2, a0, a1, a2)
    fill_slopes(dt, dy, row0, row1, row2, dy)
    uncertain = times_covariance(m, dy, 3)
    most = 0.0
    for i in range(3):
        speed, d0, d1, d2 = along(p, geo, i, r0, r1, r2)
        end = speed + d0 * gain0 + d1 * gain1 + d2 * gain2
        variance = 0.0
        for j in range(3):
            d_j = d0 if j == 0 else (d1 if j == 1 else d2)
            for k in range(3):
                d_k = d0 if k == 0 else (d1 if k == 1 else d2)
                variance += d_j * d_k * covariance_entry(m, dy, j, k, uncertain)
        most = max(most, end * end / (variance + 1e-300))
    return most, evaluations
