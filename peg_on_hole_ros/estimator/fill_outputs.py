"""State, contacts and pose of one estimate as outputs, filled by one compiled call."""

from math import ceil, cos, pi, sin, sqrt

import numpy as np

from peg_on_hole_ros.estimator.contact_sets import registry
from peg_on_hole_ros.estimator.estimate import Estimate, Motion, Reactions, scene_of
from peg_on_hole_ros.estimator.forces import (
    contact_forces,
    tilt_on_contacts,
    two_point_forces,
)
from peg_on_hole_ros.estimator.tuned import POSE_FLOOR, PUSHING_REACTIONS
from peg_on_hole_ros.mechanics.kernel import SceneScalars, closed_forms, compiled
from peg_on_hole_ros.mechanics.linear_algebra import peg_rotation, peg_turns
from peg_on_hole_ros.mechanics.quaternion import fill_quaternion
from peg_on_hole_ros.outputs import Row


@compiled
def fill_outputs(
    estimate: Estimate, peg_height: float, on_contacts: int, wide: float, row: Row
) -> None:
    """
    Fill in state, contacts and pose of an estimate.

    Parameters
    ----------
    estimate : Estimate
    peg_height : float
        H [m].
    on_contacts : int
        On how many contacts the peg rests with the reactions that were found: 3, or 2 in the hole,
        where B1 and B2 are halves of B; 0: they are zero. The peg's place is free but on three.
    wide : float
        Standard deviation of the reactions then [N].
    row : Row
        Changed.

    """
    p, motion, slips = scene_of(estimate), estimate.motion, estimate.slips
    state = row.state
    state[0], state[1], state[2] = motion.gamma, motion.psi, motion.phi
    state[3], state[4], state[5] = motion.gamma_rate, motion.psi_rate, motion.phi_rate
    for i in range(6):
        # Rounding may leave a variance of zero a hair below it.
        row.state_stddev[i] = sqrt(max(motion.covariance[i, i], 0.0))
        for j in range(6):
            row.state_covariance[i, j] = motion.covariance[i, j]
    for i in range(1, 3):
        state[i] -= 2.0 * pi * ceil((state[i] - pi) / (2.0 * pi))
    tilt, unknown = tilt_on_contacts(p, motion.gamma), registry.solved_reactions(on_contacts)
    for i in range(3):
        # Rounding can leave a variance a little below zero where the equations are near singular.
        variance = max(estimate.reactions.covariance[i, i], 0.0)
        stddev = sqrt(variance + estimate.accuracy.reactions[i])
        row.normal[i] = 0.0
        row.normal_stddev[i] = stddev if unknown > 0 else wide
        row.slip_speed[i] = slips[i].speed
        row.slip_speed_stddev[i] = sqrt(max(slips[i].variance, 0.0))
    if unknown > 0:
        fill_pushing(estimate.reactions, estimate.work, row.normal)
        _fill_accuracy_doubt(estimate, row)
    if registry.is_in_hole(on_contacts):
        two_point_forces(p, estimate, row)
    else:
        contact_forces(p, estimate, tilt, row)
    fill_torques(row.contact_point, row.contact_wrench)
    # Two contacts that give leave the depth open.
    fill_pose(p, motion, peg_height, unknown < 3, row)
    fill_quaternion(row.rotation, row.orientation)


@compiled
def _fill_accuracy_doubt(estimate: Estimate, row: Row) -> None:
    """Fill in what each kind of accuracy adds to the reaction that it moves most [N]."""
    effect = estimate.accuracy
    for k in range(len(row.accuracy_doubt)):
        most = 0.0
        for i in range(3):
            most = max(most, effect.by_kind[k, i])
        if effect.stated != 0:
            row.accuracy_doubt[k] = sqrt(most)


@compiled
def fill_torques(point: np.ndarray, wrench: np.ndarray) -> None:
    """
    Fill in the torques of forces about the origin.

    Parameters
    ----------
    point : ndarray, shape (3, 3)
        K, B1, B2 (rows) [m].
    wrench : ndarray, shape (3, 6)
        Force [N] and torque [N m]; changed.

    """
    for i in range(3):
        x, y, z = point[i, 0], point[i, 1], point[i, 2]
        X, Y, Z = wrench[i, 0], wrench[i, 1], wrench[i, 2]
        wrench[i, 3], wrench[i, 4], wrench[i, 5] = y * Z - z * Y, z * X - x * Z, x * Y - y * X


@compiled
def fill_pushing(reactions: Reactions, pulls: np.ndarray, normal: np.ndarray) -> None:
    """
    Fill in the reactions nearest to the estimated ones of which none is below zero.

    Nearest in units of their covariance: what one may not pull moves the others as far as they
    vary with it. In these units the true reactions, which push, are never farther from it than
    from the estimate, so that the covariance that was found still covers it. Dual coordinate
    ascent of Hildreth (Naval Research Logistics Quarterly 4, 1957, 79-85).

    Parameters
    ----------
    reactions : Reactions
    pulls : ndarray
        Scratch, three entries.
    normal : ndarray, shape (3,)
        N_K, N_B1, N_B2 [N]; filled.

    """
    least = 0.0
    for i in range(3):
        normal[i] = reactions.normal[i]
        least = min(least, reactions.normal[i])
    if least == 0.0:
        return
    covariance = reactions.covariance
    for i in range(3):
        pulls[i] = 0.0
    for _ in range(PUSHING_REACTIONS.most_passes):
        moved = 0.0
        for i in range(3):
            variance = covariance[i, i]
            if variance <= 0.0:
                continue
            step = max(-pulls[i], -normal[i] / variance)
            pulls[i] += step
            moved = max(moved, step * step * variance)
            for j in range(3):
                normal[j] += covariance[i, j] * step
        if moved <= PUSHING_REACTIONS.least_step * PUSHING_REACTIONS.least_step:
            break
    for i in range(3):
        normal[i] = max(normal[i], 0.0)


@compiled
def fill_pose(
    p: SceneScalars,
    motion: Motion,
    peg_height: float,
    position_free: bool,
    row: Row,
) -> None:
    """
    Fill in place, rotation and covariance of the peg's frame.

    The place is that of O2, centre of the lower end face, in the hole frame [m]; the covariance
    is of place and rotation about the hole's axes, of rank 3 on three contacts but for the floor.

    Parameters
    ----------
    p : SceneScalars
    motion : Motion
    peg_height : float
        H [m].
    position_free : bool
        No three contacts hold the peg: its place is then unknown to about its own height.
    row : Row
        Changed.

    """
    # At and below gamma0 the closed forms end; the pose there is that of gamma0, marked as free.
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, max(motion.gamma, p.gamma0 * (1.0 + 1e-9)))
    s, c, a1, a2 = geo.s, geo.c, geo.a1, geo.a2
    spsi, cpsi = sin(motion.psi), cos(motion.psi)
    along_h, along_z = a2 * s, a1 - a2 * c
    row.position[0] = cpsi * along_h
    row.position[1] = spsi * along_h
    row.position[2] = along_z
    sg, cg = sin(motion.gamma), cos(motion.gamma)
    turned = peg_rotation(peg_turns(motion.gamma, motion.psi, motion.phi))
    for i in range(3):
        for j in range(3):
            row.rotation[i, j] = turned[3 * i + j]
    # Columns: by gamma about eps = (spsi, -cpsi, 0), by psi about z, by phi about zeta.
    by_h, by_z = a1 + a2 * c, (a2 - a1 * c) / s + a2 * s
    J = (
        (cpsi * by_h, -spsi * along_h, 0.0),
        (spsi * by_h, cpsi * along_h, 0.0),
        (by_z, 0.0, 0.0),
        (spsi, 0.0, -cpsi * sg),
        (-cpsi, 0.0, -spsi * sg),
        (0.0, 1.0, cg),
    )
    C, covariance = motion.covariance, row.pose_covariance
    for i in range(6):
        a, b, f = J[i]
        k0 = a * C[0, 0] + b * C[1, 0] + f * C[2, 0]
        k1 = a * C[0, 1] + b * C[1, 1] + f * C[2, 1]
        k2 = a * C[0, 2] + b * C[1, 2] + f * C[2, 2]
        for j in range(i + 1):
            value = k0 * J[j][0] + k1 * J[j][1] + k2 * J[j][2]
            if position_free and j < 3:
                value = peg_height * peg_height if i == j else 0.0
            covariance[i, j] = covariance[j, i] = value
        floor = POSE_FLOOR.position_stddev if i < 3 else POSE_FLOOR.rotation_stddev
        covariance[i, i] += floor * floor
