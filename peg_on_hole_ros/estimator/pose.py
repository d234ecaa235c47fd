"""The peg's frame in the hole's frame on three contacts, with its covariance, as scalar code."""

from math import cos, sin

import numpy as np

from peg_on_hole_ros.estimator.record import P, X
from peg_on_hole_ros.mechanics.kernel import SceneScalars, closed_forms, compiled


@compiled
def fill_pose(
    p: SceneScalars,
    m: np.ndarray,
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
    m : ndarray
        Memory of the filter.
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
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, max(m[X], p.gamma0 * (1.0 + 1e-9)))
    s, c, a1, a2 = geo[0], geo[1], geo[2], geo[3]
    spsi, cpsi = sin(m[X + 1]), cos(m[X + 1])
    sphi, cphi = sin(m[X + 2]), cos(m[X + 2])
    along_h, along_z = a2 * s, a1 - a2 * c
    out[position] = cpsi * along_h
    out[position + 1] = spsi * along_h
    out[position + 2] = along_z
    sg, cg = sin(m[X]), cos(m[X])
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
    for i in range(6):
        a, b, f = J[i]
        k0 = a * m[P] + b * m[P + 6] + f * m[P + 12]
        k1 = a * m[P + 1] + b * m[P + 7] + f * m[P + 13]
        k2 = a * m[P + 2] + b * m[P + 8] + f * m[P + 14]
        for j in range(i + 1):
            value = k0 * J[j][0] + k1 * J[j][1] + k2 * J[j][2]
            if position_free and j < 3:
                value = peg_height * peg_height if i == j else 0.0
            out[covariance + 6 * i + j] = value
            out[covariance + 6 * j + i] = value
