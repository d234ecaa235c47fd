"""
Encode messages given as dicts to CDR, as ROS 2 puts them on the wire (little endian, XCDR1).

The library's encoder walks the definition anew for each of the nine messages of an estimate,
which takes longer than the estimate. Here the walk is prepared once for a type, and of messages
that recur at 1 kHz with the same texts only the stamp and the numbers are written anew.
"""

import struct
from array import array
from functools import cache

import numpy as np

from peg_on_hole_ros.messages.cdr_layout import ENCAPSULATION, SECOND_NS, U32, MessageLayout
from peg_on_hole_ros.messages.definitions import fields

# Code of struct, size, default.
_PRIMITIVES = {
    "bool": ("?", 1, False),
    "byte": ("B", 1, 0),
    "uint8": ("B", 1, 0),
    "int32": ("i", 4, 0),
    "uint32": ("I", 4, 0),
    "float32": ("f", 4, 0.0),
    "float64": ("d", 8, 0.0),
}
# Seconds of a stamp have 32 bits with their sign.
_LEAST_SECOND = -(1 << 31)
# Texts that change with every message would fill the memory.
_MOST_KEPT_LAYOUTS = 256


class Encoder:
    """
    Turns messages of one type into bytes.

    Parameters
    ----------
    ros_type : str
        As in `sensor_msgs/msg/JointState`.

    """

    def __init__(self, ros_type: str) -> None:
        self._type = ros_type
        self._write = _structure(ros_type.replace("/msg/", "/"))
        self._split = _SPLITS.get(ros_type)
        self._known: dict[tuple, MessageLayout] = {}

    def __call__(self, message: dict) -> bytes:
        """Return the encoded message; a field left out has its default."""
        if self._split is None:
            return self.walk(message)
        try:
            key, numbers = self._split(message)
            stamp = message["header"]["stamp"]
            sec, nanosec = stamp["sec"], stamp["nanosec"]
        except (KeyError, TypeError):
            return self.walk(message)
        if not (_LEAST_SECOND <= sec < -_LEAST_SECOND and 0 <= nanosec < SECOND_NS):
            return self.walk(message)
        layout = self._known.get(key)
        if layout is None:
            layout = self._learn(key, message)
        # Of what is no number numpy would make one, and an array does not.
        return layout.write_one(sec * SECOND_NS + nanosec, np.frombuffer(array("d", numbers)))

    def many(self, message: dict, t_ns: np.ndarray, numbers: np.ndarray) -> np.ndarray:
        """
        Return messages that differ from one in stamp and numbers alone, shape (n, bytes).

        Parameters
        ----------
        message : dict
            Any of them.
        t_ns : ndarray of int64, shape (n,)
            Stamps [ns].
        numbers : ndarray, shape (n, k)
            All float64 of each, in the order of the message.

        """
        return self.layout(message).write(t_ns, numbers)

    def layout(self, message: dict) -> MessageLayout:
        """Return the layout of a message of joint states, a wrench or a pose."""
        return MessageLayout(self._type, self.walk(message))

    def walk(self, message: dict) -> bytes:
        """Return the encoded message by its definition."""
        buffer = bytearray(ENCAPSULATION)
        self._write(buffer, message)
        return bytes(buffer)

    def _learn(self, key, message):
        layout = self.layout(message)
        if len(self._known) >= _MOST_KEPT_LAYOUTS:
            self._known.clear()
        self._known[key] = layout
        return layout


def _joint_state(message):
    position, velocity, effort = (message[k] for k in ("position", "velocity", "effort"))
    key = (message["header"]["frame_id"], *message["name"], len(position), len(velocity))
    return (*key, len(effort)), [*position, *velocity, *effort]


def _wrench(message):
    force, torque = message["wrench"]["force"], message["wrench"]["torque"]
    numbers = [force["x"], force["y"], force["z"], torque["x"], torque["y"], torque["z"]]
    return message["header"]["frame_id"], numbers


def _pose(message):
    pose, covariance = message["pose"]["pose"], message["pose"]["covariance"]
    p, q = pose["position"], pose["orientation"]
    numbers = [p["x"], p["y"], p["z"], q["x"], q["y"], q["z"], q["w"], *covariance]
    return (message["header"]["frame_id"], len(covariance)), numbers


# What makes two messages differ in more than stamp and numbers, and the numbers in their order.
_SPLITS = {
    "sensor_msgs/msg/JointState": _joint_state,
    "geometry_msgs/msg/WrenchStamped": _wrench,
    "geometry_msgs/msg/PoseWithCovarianceStamped": _pose,
}


def _pad(buffer, size):
    # Places count from behind the encapsulation, whose four bytes do not matter up to size 4.
    buffer.extend(bytes((len(ENCAPSULATION) - len(buffer)) % size))


@cache
def _structure(name):
    members = []
    for kind, field, default in fields(name):
        array = kind.endswith("]")
        base, _, length = kind.removesuffix("]").partition("[")
        write = _element(base, default)
        if array:
            write = _array(write, int(length) if length else None)
        members.append((field, write))

    def write(buffer, message):  # type: ignore[no-redef]
        message = {} if message is None else message
        for field, write_member in members:
            write_member(buffer, message.get(field))

    return write


def _element(base, default):
    if base == "string":
        return _write_string
    if base not in _PRIMITIVES:
        return _structure(base)
    code, size, zero = _PRIMITIVES[base]
    pack = struct.Struct(f"<{code}").pack
    default = zero if default is None else type(zero)(float(default))

    def write(buffer, value):
        _pad(buffer, size)
        buffer.extend(pack(default if value is None else value))

    return write


def _write_string(buffer, value):
    data = (value or "").encode() + b"\0"
    _pad(buffer, 4)
    buffer.extend(U32.pack(len(data)))
    buffer.extend(data)


def _array(write, length):
    def write_array(buffer, values):
        values = [None] * (length or 0) if values is None else values
        if length is None:
            _pad(buffer, 4)
            buffer.extend(U32.pack(len(values)))
        elif len(values) != length:
            raise ValueError(f"{len(values)} values for a field of {length}")
        for value in values:
            write(buffer, value)

    return write_array
