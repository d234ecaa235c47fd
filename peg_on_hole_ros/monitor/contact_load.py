"""The load that contacts carry: the wrench that the motion of the peg does not account for."""

from math import exp, fabs, nan, sin, sqrt

from peg_on_hole_ros.estimator.estimate import Estimate, scene_of
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.linear_algebra import (
    FORCE,
    TORQUE,
    factor_cholesky,
    peg_rotation,
    peg_turns,
    rotated,
    whiten,
)
from peg_on_hole_ros.monitor.trend import is_number
from peg_on_hole_ros.monitor.tuned import FREE_PEG_LOAD
from peg_on_hole_ros.typed_record import Record, Vector3

# A single wrench of 0.2 N and 5 mN m looks as if a rim carried 0.6 N; the mean over
# `monitor.evidence_time` distinguishes a free peg from one that is touched lightly. A peg that is
# turned in the air needs a couple for it, some 0.1 N m at 200 rad/s^2: it is known from the rates.
# Its force for being moved is not, for nothing measures where the peg is.
#
# Axes: those of the hole. Of a peg that hangs nearly upright psi and phi are noise, and so are any
# axes that turn with one of them.


class ContactLoad(Record):
    """
    Means of what is left for contacts to carry, hole axes.

    Attributes
    ----------
    share : float
        Share of one wrench's variance that is left in the means; 0: they are over nothing.
    force, couple : ndarray, shape (3,)
        [N], [N m].
    momentum_rate : ndarray, shape (3,)
        Rate of change of the angular momentum [N m].
    momentum : ndarray, shape (3,)
        The angular momentum as it was last [N m s].

    """

    share: float
    force: Vector3
    couple: Vector3
    momentum_rate: Vector3
    momentum: Vector3


@compiled
def forget_load(load: ContactLoad) -> None:
    """Forget all wrenches."""
    load.share = 0.0
    for i in range(3):
        load.force[i] = load.couple[i] = 0.0
        load.momentum_rate[i] = load.momentum[i] = 0.0


@compiled
def carried_load(
    estimate: Estimate, load: ContactLoad, dt: float, time: float
) -> tuple[float, float]:
    """
    Add one wrench to the means, and return what is left for a rim to carry.

    Parameters
    ----------
    estimate : Estimate
    load : ContactLoad
        Changed.
    dt : float
        Since the wrench before [s].
    time : float
        Over which means are taken [s].

    Returns
    -------
    carried : float
        Root of the squares of force and couple; a couple counts by its force at the peg's
        radius [N]. NaN for a wrench that is no number: it is not taken.
    variance : float
        What noise alone would make of its square [N^2].

    """
    p = scene_of(estimate)
    motion, u = estimate.motion, estimate.wrench
    turns = peg_turns(motion.gamma, motion.psi, motion.phi)
    r, (s, c, spsi, cpsi, _, _) = peg_rotation(turns), turns
    w_x = motion.gamma_rate * spsi - motion.phi_rate * s * cpsi
    w_y = -motion.gamma_rate * cpsi - motion.phi_rate * s * spsi
    w_z = motion.psi_rate + motion.phi_rate * c
    along = (p.Iz - p.Ie) * (motion.phi_rate + motion.psi_rate * c)
    _, _, z_x, _, _, z_y, _, _, z_z = r
    momentum = (p.Ie * w_x + along * z_x, p.Ie * w_y + along * z_y, p.Ie * w_z + along * z_z)
    F_x, F_y, F_z = rotated(r, u, FORCE)
    force = (F_x + p.m * p.g_x, F_y + p.m * p.g_y, F_z + p.m * p.g_z)
    couple = rotated(r, u, TORQUE)
    over_radius, R = 2.0 / p.d, estimate.wrench_noise
    noise = jump = 0.0
    for i in range(3):
        noise += R[i, i] + over_radius * over_radius * R[3 + i, 3 + i]
        jump += (force[i] - load.force[i]) ** 2
        jump += (over_radius * (couple[i] - load.couple[i])) ** 2
    L_x, L_y, L_z = momentum
    if not is_number(jump + fabs(L_x) + fabs(L_y) + fabs(L_z)):
        return nan, noise
    share = 1.0 - exp(-dt / time)
    begun = load.share > 0.0
    least = FREE_PEG_LOAD.azimuth_stddev * FREE_PEG_LOAD.azimuth_stddev
    turns = begun and dt > 0.0 and motion.covariance[1, 1] < least
    for i in range(3):
        rate = (momentum[i] - load.momentum[i]) / dt if turns else 0.0
        load.momentum_rate[i] += share * (rate - load.momentum_rate[i])
        load.momentum[i] = momentum[i]
    # A load that has changed is not a mean of before and after.
    if not begun or jump > FREE_PEG_LOAD.jump * noise:
        load.share = share = 1.0
    else:
        load.share = (1.0 - share) * (1.0 - share) * load.share + share * share
    squares = 0.0
    for i in range(3):
        load.force[i] += share * (force[i] - load.force[i])
        load.couple[i] += share * (couple[i] - load.couple[i])
        held = load.couple[i] - load.momentum_rate[i]
        squares += load.force[i] ** 2 + (over_radius * held) ** 2
    pull = _pull(load)
    squares -= pull * pull * (1.0 - 1.0 / (FREE_PEG_LOAD.lift * FREE_PEG_LOAD.lift))
    return sqrt(squares), load.share * noise + _turned(estimate, time)


@compiled
def _pull(load: ContactLoad) -> float:
    """Return the force out of the hole [N]: contacts push, unless a squeeze makes them pull."""
    force: float = load.force[2]
    return max(force, 0.0)


@compiled
def _turned(estimate: Estimate, time: float) -> float:
    """Return the variance that the rates leave to a couple, as a force at the peg's radius."""
    p, s, C = scene_of(estimate), sin(estimate.motion.gamma), estimate.motion.covariance
    turned = 2.0 / p.d * p.Ie / time
    variance: float = turned * turned * (C[3, 3] + s * s * C[4, 4])
    return variance


@compiled
def stands_out(estimate: Estimate, load: ContactLoad, floor: float, time: float) -> float:
    """
    Return the square of a carried load over what nothing, or next to nothing, would make of it.

    Force and couple count by their joint noise: about the mass centre of a peg far from its
    sensor the couple is noisy, and mostly by the force's noise, which the force shows.

    Parameters
    ----------
    estimate, load, time
        As for `carried_load`, which has taken the wrench.
    floor : float
        Square of the load that counts as none [N^2].

    """
    over_radius, motion = 2.0 / scene_of(estimate).d, estimate.motion
    r = peg_rotation(peg_turns(motion.gamma, motion.psi, motion.phi))
    pull = _pull(load) * (1.0 - 1.0 / FREE_PEG_LOAD.lift)
    # The covariance, then its Cholesky factor, and the load, whitened by it.
    factor, white = estimate.work[:36].reshape(6, 6), estimate.work[36:42]
    # In the peg's axes, in which the noise stands.
    for i in range(3):
        force = couple = 0.0
        for k in range(3):
            lifted = pull if k == 2 else 0.0
            force += r[3 * k + i] * (load.force[k] - lifted)
            couple += r[3 * k + i] * (load.couple[k] - load.momentum_rate[k])
        white[i], white[TORQUE + i] = force, over_radius * couple
    # Of six squares as of one.
    room = 6.0 * FREE_PEG_LOAD.room * load.share
    turned = FREE_PEG_LOAD.room * _turned(estimate, time)
    least = floor + FREE_PEG_LOAD.room * estimate.bias_load
    for i in range(6):
        for k in range(i + 1):
            v = room * estimate.wrench_noise[i, k]
            if i > 2:
                v *= over_radius
            if k > 2:
                v *= over_radius
            if i == k:
                v += least + (turned if i > 2 else 0.0)
            factor[i, k] = v
    factor_cholesky(factor, 6)
    return whiten(factor, 6, white, white)
