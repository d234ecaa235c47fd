"""Plain dicts become rclpy messages, by a plan made once for each message type."""

from array import array
from functools import cache
from importlib import import_module
from typing import Any


def message_class(ros_type: str) -> type:
    """Return the Python class of a type such as `sensor_msgs/msg/JointState`."""
    package, kind, name = ros_type.split("/")
    return getattr(import_module(f"{package}.{kind}"), name)


def to_ros(ros_type: str, fields: dict) -> Any:
    """
    Return the rclpy message with these fields; others keep their defaults.

    Parameters
    ----------
    ros_type : str
        As in `sensor_msgs/msg/JointState`.
    fields : dict
        By name, nested; numbers are Python's own.

    Raises
    ------
    KeyError
        A field that the type does not have.

    """
    return _filled(ros_type, fields)


def _filled(ros_type, fields):
    cls, plan = _plan(ros_type)
    message = cls()
    for name, value in fields.items():
        convert = plan[name]
        setattr(message, name, value if convert is None else convert(value))
    return message


@cache
def _plan(ros_type):
    cls = _class(ros_type)
    plan = {name: _converter(kind) for name, kind in cls.get_fields_and_field_types().items()}
    return cls, plan


def _class(ros_type):
    return message_class(ros_type if ros_type.count("/") == 2 else ros_type.replace("/", "/msg/"))


def _converter(kind):
    if kind == "octet":
        return lambda value: bytes((value,))
    if kind == "sequence<double>":
        return lambda value: array("d", value)
    if kind.startswith("sequence<") and "/" in kind:
        inner = kind.removeprefix("sequence<").removesuffix(">")
        return lambda values: [_filled(inner, value) for value in values]
    if "/" in kind:
        return lambda value: _filled(kind, value)
    return None
