"""ROS messages as plain dicts of Python's own numbers: what a bag writer and rclpy both take."""

from collections.abc import Iterable
from math import sqrt

import numpy as np

from peg_on_hole_ros.mechanics.kernel import compiled

HOLE_FRAME = "hole"


def stamp(t_ns: int) -> dict:
    """Return builtin_interfaces/Time of an integer time [ns]; floor, so negative times work."""
    return {"sec": t_ns // 1_000_000_000, "nanosec": t_ns % 1_000_000_000}


def header(t_ns: int, frame_id: str = HOLE_FRAME) -> dict:
    """Return std_msgs/Header."""
    return {"stamp": stamp(t_ns), "frame_id": frame_id}


def floats(values: Iterable[float]) -> list[float]:
    """
    Return Python floats.

    rclpy serialises an int, a bool or a numpy scalar in a float64 field as rubbish, silently.
    """
    if type(values) is np.ndarray and values.dtype == np.float64:
        return values.tolist() if values.ndim == 1 else values.ravel().tolist()
    return [float(value) for value in values]


def xyz(values: Iterable[float]) -> dict:
    """Return geometry_msgs/Vector3 or Point of three numbers."""
    x, y, z = floats(values)
    return {"x": x, "y": y, "z": z}


def quaternion(rotation: np.ndarray) -> dict:
    """Return geometry_msgs/Quaternion of a rotation matrix, w >= 0, see `quaternions`."""
    return dict(zip("xyzw", quaternions(rotation.reshape(1, 3, 3))[0].tolist()))


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
def _fill_quaternions(rotations, found):
    for n in range(len(rotations)):
        R, q = rotations[n], found[n]
        trace = R[0, 0] + R[1, 1] + R[2, 2]
        i, most = 3, trace
        for k in range(2, -1, -1):
            if R[k, k] >= most:
                i, most = k, R[k, k]
        if i == 3:
            q[0], q[1], q[2] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
            q[3] = 1.0 + trace
        else:
            j, k = (i + 1) % 3, (i + 2) % 3
            q[i] = 1.0 - trace + 2.0 * R[i, i]
            q[j] = R[j, i] + R[i, j]
            q[k] = R[k, i] + R[i, k]
            q[3] = R[k, j] - R[j, k]
        scale = 1.0 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
        if q[3] < 0.0:
            scale = -scale
        for k in range(4):
            q[k] *= scale
