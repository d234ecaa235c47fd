"""Everything that one estimate says of state, contacts and pose, filled by one compiled call."""

from math import ceil, pi, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimator.forces import (
    contact_forces,
    tilt_on_contacts,
    two_point_forces,
)
from peg_on_hole_ros.estimator.pose import fill_pose
from peg_on_hole_ros.estimator.pushing import fill_pushing
from peg_on_hole_ros.estimator.record import REACTIONS, SPEEDS, P, X
from peg_on_hole_ros.mechanics.kernel import compiled, scene_of


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


def description(
    memory: np.ndarray, peg_height: float, on_contacts: int, wide: float
) -> Description:
    """
    Return the description of an estimate by its record.

    Parameters
    ----------
    memory : ndarray
        From `fill_record`.
    peg_height : float
        H [m].
    on_contacts : int
        On how many contacts the peg rests with the reactions that were found: 3, or 2 in the hole,
        where B1 and B2 are halves of B; 0: they are zero. The peg's place is free but on three.
    wide : float
        Standard deviation of the reactions then [N].

    """
    out = np.empty(SIZE)
    describe(memory, peg_height, on_contacts, wide, out)
    return described(out)


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
    m: np.ndarray, peg_height: float, on_contacts: int, wide: float, out: np.ndarray
) -> None:
    """Fill in the array of `description`."""
    p = scene_of(m)
    for i in range(6):
        out[i] = m[X + i]
        for j in range(6):
            out[COVARIANCE + 6 * i + j] = m[P + 6 * i + j]
    for i in range(1, 3):
        out[i] -= 2.0 * pi * ceil((out[i] - pi) / (2.0 * pi))
    tilt = tilt_on_contacts(p, m[X])
    for i in range(3):
        # Rounding can leave a variance a little below zero where the equations are near singular.
        stddev = sqrt(max(m[REACTIONS + 21 + 7 * i], 0.0))
        out[NORMAL + i] = 0.0
        out[STDDEV + i] = stddev if on_contacts > 0 else wide
        out[SLIP + i] = m[SPEEDS + 2 * i]
        out[SLIP_STDDEV + i] = sqrt(max(m[SPEEDS + 2 * i + 1], 0.0))
    if on_contacts > 0:
        fill_pushing(m, out, NORMAL)
    if on_contacts == 2:
        two_point_forces(p, m, out, NORMAL, FORCE, POINT)
    else:
        contact_forces(p, m, tilt, out, NORMAL, FORCE, POINT)
    # Two contacts that give leave the depth open.
    fill_pose(p, m, peg_height, on_contacts != 3, out, POSITION, ROTATION, POSE)
