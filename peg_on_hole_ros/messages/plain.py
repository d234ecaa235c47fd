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
    _fill_quaternions(np.ascontiguousarray(rotations).reshape(-1, 9), found)
    return found


@compiled
def fill_quaternion(R: np.ndarray, first: int, q: np.ndarray, to: int) -> None:
    """Fill in x, y, z, w of the rotation matrix that stands row by row from a place on."""
    trace = R[first] + R[first + 4] + R[first + 8]
    i, most = 3, trace
    for k in range(2, -1, -1):
        if R[first + 4 * k] >= most:
            i, most = k, R[first + 4 * k]
    if i == 3:
        q[to] = R[first + 7] - R[first + 5]
        q[to + 1] = R[first + 2] - R[first + 6]
        q[to + 2] = R[first + 3] - R[first + 1]
        q[to + 3] = 1.0 + trace
    else:
        j, k = (i + 1) % 3, (i + 2) % 3
        q[to + i] = 1.0 - trace + 2.0 * R[first + 4 * i]
        q[to + j] = R[first + 3 * j + i] + R[first + 3 * i + j]
        q[to + k] = R[first + 3 * k + i] + R[first + 3 * i + k]
        q[to + 3] = R[first + 3 * k + j] - R[first + 3 * j + k]
    x, y, z, w = q[to], q[to + 1], q[to + 2], q[to + 3]
    scale = 1.0 / sqrt(x * x + y * y + z * z + w * w)
    if w < 0.0:
        scale = -scale
    for k in range(4):
        q[to + k] *= scale


@compiled
def _fill_quaternions(rotations, found):
    for n in range(len(rotations)):
        fill_quaternion(rotations[n], 0, found[n], 0)
