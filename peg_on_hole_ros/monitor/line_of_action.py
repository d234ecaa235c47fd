"""Whether a load passes through one point of the peg: as of a single contact there."""

from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.linear_algebra import in_peg_axes, peg_turns, surprise
from peg_on_hole_ros.monitor.contact_load import ContactLoad
from peg_on_hole_ros.typed_record import Floats


@compiled
def evidence_through(
    estimate: Estimate, load: ContactLoad, a: tuple[float, float, float], off: float
) -> float:
    """
    Return log p(load | one force at a point) - log p(load | any couple).

    Parameters
    ----------
    estimate : Estimate
    load : ContactLoad
        Which has taken the wrench.
    a : tuple of float
        From the mass centre to the point, peg axes [m].
    off : float
        Variance of where the point is [m^2].

    """
    motion, radius = estimate.motion, 0.5 * estimate.scene.d
    turns = peg_turns(motion.gamma, motion.psi, motion.phi)
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
    # A squeeze is all couple, and hardly any force.
    spread = max(squares * radius * radius, M_x * M_x + M_y * M_y)
    for i in range(2):
        S[i, i] += squares * off + radius * radius * estimate.bias_load
        for j in range(i + 1):
            wide[i, j] = S[i, j] + (spread if i == j else 0.0)
    of_any, any_spread = surprise(wide, 2, moment, white)
    of_plate, plate_spread = surprise(S, 2, moment, white)
    ratio: float = 0.5 * (of_any + any_spread - of_plate - plate_spread)
    return ratio


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
