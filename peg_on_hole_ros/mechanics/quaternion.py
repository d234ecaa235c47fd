"""Rotation matrices as quaternions."""

from math import sqrt

import numpy as np

from peg_on_hole_ros.mechanics.kernel import compiled


def quaternions(rotations: np.ndarray) -> np.ndarray:
    """
    Return x, y, z, w of rotation matrices, w >= 0, shape (n, 4).

    Shepperd's method: the largest of the four components is taken from the diagonal, so nothing
    is divided by a small number.

    Parameters
    ----------
    rotations : ndarray, shape (n, 3, 3)

    """
    found = np.empty((len(rotations), 4))
    _fill_quaternions(np.ascontiguousarray(rotations), found)
    return found


@compiled
def fill_quaternion(R: np.ndarray, q: np.ndarray) -> None:
    """Fill in x, y, z, w of the rotation matrix R (3, 3); see `quaternions`."""
    trace = R[0, 0] + R[1, 1] + R[2, 2]
    i, most = 3, trace
    for k in range(2, -1, -1):
        if R[k, k] >= most:
            i, most = k, R[k, k]
    if i == 3:
        q[0] = R[2, 1] - R[1, 2]
        q[1] = R[0, 2] - R[2, 0]
        q[2] = R[1, 0] - R[0, 1]
        q[3] = 1.0 + trace
    else:
        j, k = (i + 1) % 3, (i + 2) % 3
        q[i] = 1.0 - trace + 2.0 * R[i, i]
        q[j] = R[j, i] + R[i, j]
        q[k] = R[k, i] + R[i, k]
        q[3] = R[k, j] - R[j, k]
    x, y, z, w = q[0], q[1], q[2], q[3]
    scale = 1.0 / sqrt(x * x + y * y + z * z + w * w)
    if w < 0.0:
        scale = -scale
    for k in range(4):
        q[k] *= scale


@compiled
def _fill_quaternions(rotations, found):
    for n in range(len(rotations)):
        fill_quaternion(rotations[n], found[n])
