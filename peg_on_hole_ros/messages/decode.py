"""Wrench and joint-state messages, from ROS or from a bag, become samples or a named reason."""

from math import isfinite
from types import SimpleNamespace
from typing import Any, NamedTuple

from peg_on_hole_ros.measurements.wrench_reduction import wrench_fault
from peg_on_hole_ros.records import JointSample, WrenchSample

WRENCH_TYPE = "geometry_msgs/msg/WrenchStamped"
JOINTS_TYPE = "sensor_msgs/msg/JointState"

# What a message of the wrong shape or type raises when its fields are read.
MISFITS = (AttributeError, IndexError, KeyError, OverflowError, TypeError, ValueError)


class Malformed(NamedTuple):
    """
    A message that gives no sample.

    Attributes
    ----------
    reason : str
        `unreadable` (fields missing or of another type), `bad_stamp` (nanoseconds outside 0 to
        1e9), `not_finite`, `out_of_range` (a wrench that no sensor measures),
        `length_mismatch` (names and positions), `repeated_name`.

    """

    reason: str


def wrench_sample(message: Any) -> WrenchSample | Malformed:
    """
    Read a geometry_msgs/WrenchStamped; never raises.

    Parameters
    ----------
    message : rclpy message, message decoded from a bag, or dict
        Fields by name.

    """
    try:
        message = _by_attribute(message)
        t_ns = _stamp(message)
        force, torque = message.wrench.force, message.wrench.torque
        numbers = (
            *(float(force.x), float(force.y), float(force.z)),
            *(float(torque.x), float(torque.y), float(torque.z)),
        )
    except MISFITS:
        return Malformed("unreadable")
    if t_ns is None:
        return Malformed("bad_stamp")
    return checked_wrench(WrenchSample(t_ns, numbers[:3], numbers[3:]))


def checked_wrench(sample: WrenchSample) -> WrenchSample | Malformed:
    """Return a wrench that was read, or what is wrong with its numbers."""
    fault = wrench_fault(sample)
    return Malformed(fault) if fault else sample


def joint_sample(message: Any, needed: tuple[str, ...] = ()) -> JointSample | Malformed:
    """
    Read a sensor_msgs/JointState; never raises. Velocity and effort are not looked at.

    Parameters
    ----------
    message : rclpy message, message decoded from a bag, or dict
        Fields by name.
    needed : tuple of str
        Joints whose positions have to be finite; empty: all. Others may hold anything, as a
        driver that does not measure a joint puts NaN.

    """
    try:
        message = _by_attribute(message)
        t_ns = _stamp(message)
        names = tuple(map(str, message.name))
        position = tuple(map(float, message.position))
    except MISFITS:
        return Malformed("unreadable")
    if t_ns is None:
        return Malformed("bad_stamp")
    return checked_joints(JointSample(t_ns, names, position), needed)


def checked_joints(sample: JointSample, needed: tuple[str, ...] = ()) -> JointSample | Malformed:
    """Return a joint state that was read, or what is wrong with it; `needed` as above."""
    names, position = sample.names, sample.position
    if len(names) != len(position):
        return Malformed("length_mismatch")
    if len(set(names)) != len(names):
        return Malformed("repeated_name")
    for name, value in zip(names, position):
        if not isfinite(value) and (not needed or name in needed):
            return Malformed("not_finite")
    return sample


def frame_of(message: Any) -> str:
    """Return the frame_id of a message; empty where it has none."""
    frame = getattr(getattr(message, "header", None), "frame_id", "")
    return frame if isinstance(frame, str) else ""


def stamp_of(message: Any) -> int | None:
    """Return the stamp of a decoded message [ns]; None: it has none, or a bad one."""
    try:
        return _stamp(message)
    except MISFITS:
        return None


def _stamp(message):
    stamp = message.header.stamp
    sec, nanosec = int(stamp.sec), int(stamp.nanosec)
    return sec * 1_000_000_000 + nanosec if 0 <= nanosec < 1_000_000_000 else None


def _by_attribute(message):
    if isinstance(message, dict):
        return SimpleNamespace(**{key: _by_attribute(value) for key, value in message.items()})
    return message
