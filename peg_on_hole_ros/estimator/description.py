"""Everything that one estimate says of state, contacts and pose, filled by one compiled call."""

from math import ceil, cos, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimator.forces import (
    contact_forces,
    tilt_on_contacts,
    two_point_forces,
)
from peg_on_hole_ros.estimator.record import Estimate, Motion, Reactions, scene_of
from peg_on_hole_ros.mechanics.kernel import SceneScalars, closed_forms, compiled


class Description(NamedTuple):
    """
    An estimate in the arrays of `records.Outputs`, see there; all are views of one array.

    Attributes
    ----------
    state : ndarray, shape (6,)
    state_covariance : ndarray, shape (6, 6)
    normal, normal_stddev : ndarray, shape (3,)
    slip_speed, slip_speed_stddev : ndarray, shape (3,)
    contact_force, contact_point : ndarray, shape (3, 3)
    position : ndarray, shape (3,)
    rotation : ndarray, shape (3, 3)
    pose_covariance : ndarray, shape (6, 6)

    """

    state: np.ndarray
    state_covariance: np.ndarray
    normal: np.ndarray
    normal_stddev: np.ndarray
    slip_speed: np.ndarray
    slip_speed_stddev: np.ndarray
    contact_force: np.ndarray
    contact_point: np.ndarray
    position: np.ndarray
    rotation: np.ndarray
    pose_covariance: np.ndarray


# Places of the attributes in the one array, in their order.
STATE, COVARIANCE, NORMAL, STDDEV, SLIP, SLIP_STDDEV = 0, 6, 42, 45, 48, 51
FORCE, POINT, POSITION, ROTATION, POSE = 54, 63, 72, 75, 84
SIZE = 120

# Hildreth's iteration converges linearly: each pass multiplies the error by the squared
# correlation of the reactions that would pull. It ends where a pass moves none by more than this
# share of a standard deviation.
_MOST_PASSES = 1000
_PASS_ENDS = 1e-10


def described(out: np.ndarray) -> Description:
    """Return what `describe` has filled in by name, shape (SIZE,)."""
    return Description(
        out[:6],
        out[6:42].reshape(6, 6),
        out[42:45],
        out[45:48],
        out[48:51],
        out[51:54],
        out[54:63].reshape(3, 3),
        out[63:72].reshape(3, 3),
        out[72:75],
        out[75:84].reshape(3, 3),
        out[84:].reshape(6, 6),
    )


def described_rows(rows: np.ndarray) -> Description:
    """Return the same of many, by their first columns, shape (n, SIZE or more)."""
    n = len(rows)
    return Description(
        rows[:, :6],
        rows[:, 6:42].reshape(n, 6, 6),
        rows[:, 42:45],
        rows[:, 45:48],
        rows[:, 48:51],
        rows[:, 51:54],
        rows[:, 54:63].reshape(n, 3, 3),
        rows[:, 63:72].reshape(n, 3, 3),
        rows[:, 72:75],
        rows[:, 75:84].reshape(n, 3, 3),
        rows[:, 84:120].reshape(n, 6, 6),
    )


@compiled
def describe(
    estimate: Estimate, peg_height: float, on_contacts: int, wide: float, out: np.ndarray
) -> None:
    """
    Fill in an estimate's description by its record, see `described`.

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
    out : ndarray, shape (SIZE,)

    """
    p, motion, slips = scene_of(estimate), estimate.motion, estimate.slips
    out[0], out[1], out[2] = motion.gamma, motion.psi, motion.phi
    out[3], out[4], out[5] = motion.gamma_rate, motion.psi_rate, motion.phi_rate
    for i in range(6):
        for j in range(6):
            out[COVARIANCE + 6 * i + j] = motion.covariance[i, j]
    for i in range(1, 3):
        out[i] -= 2.0 * pi * ceil((out[i] - pi) / (2.0 * pi))
    tilt = tilt_on_contacts(p, motion.gamma)
    for i in range(3):
        # Rounding can leave a variance a little below zero where the equations are near singular.
        stddev = sqrt(max(estimate.reactions.covariance[i, i], 0.0))
        out[NORMAL + i] = 0.0
        out[STDDEV + i] = stddev if on_contacts > 0 else wide
        out[SLIP + i] = slips[i].speed
        out[SLIP_STDDEV + i] = sqrt(max(slips[i].variance, 0.0))
    if on_contacts > 0:
        fill_pushing(estimate.reactions, estimate.work, out, NORMAL)
    if on_contacts == 2:
        two_point_forces(p, estimate, out, NORMAL, FORCE, POINT)
    else:
        contact_forces(p, estimate, tilt, out, NORMAL, FORCE, POINT)
    # Two contacts that give leave the depth open.
    fill_pose(p, motion, peg_height, on_contacts != 3, out, POSITION, ROTATION, POSE)


@compiled
def fill_pushing(reactions: Reactions, pulls: np.ndarray, out: np.ndarray, normal: int) -> None:
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
    out : ndarray
        Filled at three places.
    normal : int
        Their first: N_K, N_B1, N_B2 [N].

    """
    least = 0.0
    for i in range(3):
        out[normal + i] = reactions.normal[i]
        least = min(least, reactions.normal[i])
    if least == 0.0:
        return
    covariance = reactions.covariance
    for i in range(3):
        pulls[i] = 0.0
    for _ in range(_MOST_PASSES):
        moved = 0.0
        for i in range(3):
            variance = covariance[i, i]
            if variance <= 0.0:
                continue
            step = max(-pulls[i], -out[normal + i] / variance)
            pulls[i] += step
            moved = max(moved, step * step * variance)
            for j in range(3):
                out[normal + j] += covariance[i, j] * step
        if moved <= _PASS_ENDS * _PASS_ENDS:
            break
    for i in range(3):
        out[normal + i] = max(out[normal + i], 0.0)


@compiled
def fill_pose(
    p: SceneScalars,
    motion: Motion,
    peg_height: float,
    position_free: bool,
    out: np.ndarray,
    position: int,
    rotation: int,
    covariance: int,
) -> None:
    """
    Fill in place, orientation and covariance of the peg's frame.

    Parameters
    ----------
    p : SceneScalars
    motion : Motion
    peg_height : float
        H [m].
    position_free : bool
        No three contacts hold the peg: its place is then unknown to about its own height.
    out : ndarray
        Filled by rows from three places on.
    position, rotation, covariance : int
        Place of O2, centre of the lower end face, in the hole frame (3) [m]; of R_HP (3, 3); of
        the covariance of place and rotation about the hole's axes (6, 6), rank 3 on three
        contacts.

    """
    # At and below gamma0 the closed forms end; the pose there is that of gamma0, marked as free.
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, max(motion.gamma, p.gamma0 * (1.0 + 1e-9)))
    s, c, a1, a2 = geo[0], geo[1], geo[2], geo[3]
    spsi, cpsi = sin(motion.psi), cos(motion.psi)
    sphi, cphi = sin(motion.phi), cos(motion.phi)
    along_h, along_z = a2 * s, a1 - a2 * c
    out[position] = cpsi * along_h
    out[position + 1] = spsi * along_h
    out[position + 2] = along_z
    sg, cg = sin(motion.gamma), cos(motion.gamma)
    out[rotation] = cpsi * cg * cphi - spsi * sphi
    out[rotation + 1] = -cpsi * cg * sphi - spsi * cphi
    out[rotation + 2] = -cpsi * sg
    out[rotation + 3] = spsi * cg * cphi + cpsi * sphi
    out[rotation + 4] = -spsi * cg * sphi + cpsi * cphi
    out[rotation + 5] = -spsi * sg
    out[rotation + 6] = sg * cphi
    out[rotation + 7] = -sg * sphi
    out[rotation + 8] = cg
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
    C = motion.covariance
    for i in range(6):
        a, b, f = J[i]
        k0 = a * C[0, 0] + b * C[1, 0] + f * C[2, 0]
        k1 = a * C[0, 1] + b * C[1, 1] + f * C[2, 1]
        k2 = a * C[0, 2] + b * C[1, 2] + f * C[2, 2]
        for j in range(i + 1):
            value = k0 * J[j][0] + k1 * J[j][1] + k2 * J[j][2]
            if position_free and j < 3:
                value = peg_height * peg_height if i == j else 0.0
            out[covariance + 6 * i + j] = value
            out[covariance + 6 * j + i] = value
