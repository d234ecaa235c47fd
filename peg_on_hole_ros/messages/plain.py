"""ROS messages as plain dicts of Python's own numbers: what a bag writer and rclpy both take."""

from collections.abc import Iterable

import numpy as np

from peg_on_hole_ros.mechanics.quaternion import quaternions

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
