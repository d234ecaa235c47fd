"""
Check parameters once and fill the records that pipeline and node are built from.

One behaviour for the node and the command line: types are as strict as those of ROS 2. An integer
where a double belongs is refused (ROS 2 refuses a file with it, and an array that mixes the two
before any code of a node runs), so a file that passes here also starts the node.
"""

import difflib
import re
from dataclasses import fields
from math import isfinite, radians
from typing import Any

from peg_on_hole_ros.config.options import (
    Configuration,
    Frames,
    JointInput,
    NodeOptions,
    Topics,
)
from peg_on_hole_ros.config.parameter_table import OLD_METHODS, PARAMETERS, SUPERSEDED, Parameter
from peg_on_hole_ros.errors import PegOnHoleError, wrong_prefix_remedy
from peg_on_hole_ros.safe_text import MOST_SHOWN, cut, printable, shown

BY_NAME: dict[str, Parameter] = {row.name: row for row in PARAMETERS}

# What every ROS 2 node has of its own; a parameters file may set them.
ROS_NAMES = ("use_sim_time", "start_type_description_service")
_ROS_PREFIX = "qos_overrides."

_TOPIC = re.compile(r"/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")
_PYTHON = {"bool": bool, "integer": int, "double": float, "string": str}
_WORDS = {bool: "a bool", int: "an integer", float: "a double", str: "a string"}
# For ROS 2 these are texts, and would become the name of a file or a topic.
_NOTHING = ("null", "Null", "NULL", "~")


def from_parameters(parameters: dict[str, object]) -> Configuration:
    """
    Return the configuration; a parameter that is not given has its default.

    Parameters
    ----------
    parameters : dict of str to bool, int, float, str or sequence
        Dotted names; those of the node and of ROS 2 itself are allowed and checked.

    Raises
    ------
    PegOnHoleError
        Unknown name, wrong type, value out of range, or values that do not fit together.

    """
    values = check(parameters)
    groups = {}
    for group in fields(Configuration):
        record = type(group.default_factory())  # type: ignore[operator]
        names = {f.name: f"{group.name}.{f.name}" for f in fields(record)}
        given = {field: values[name] for field, name in names.items() if name in values}
        groups[group.name] = record(**given)
    configuration = Configuration(**groups)
    _check_together(configuration)
    return configuration


def node_options(parameters: dict[str, object]) -> NodeOptions:
    """Return what only the node uses; raises like `from_parameters`."""
    values: dict[str, Any] = check(parameters)
    return NodeOptions(**{f.name: values[f.name] for f in fields(NodeOptions)})


def to_parameters(configuration: Configuration, node: NodeOptions | None = None) -> dict:
    """
    Return dotted name to value, in the table's order; arrays are lists, as YAML has them.

    Gravity that follows from the robot is the default, as it was stated.
    """
    follows = configuration.joints.robot_gravity == configuration.scene.gravity
    values = {}
    for row in PARAMETERS:
        group, _, name = row.name.rpartition(".")
        if not group and node is None:
            continue
        value = getattr(getattr(configuration, group) if group else node, name)
        if follows and row.name == "scene.gravity":
            value = row.default
        values[row.name] = list(value) if isinstance(value, tuple) else value
    return values


def check(parameters: dict[str, object]) -> dict[str, object]:
    """
    Return a value for every row of the table, each checked on its own; arrays are tuples.

    What is of an older version, and has no place any more, counts as not given: `superseded`.
    """
    parameters = _of_this_version(parameters)
    for name, value in parameters.items():
        if name not in BY_NAME:
            check_one(name, value)
    return {row.name: checked(row, parameters.get(row.name, row.default)) for row in PARAMETERS}


def superseded(parameters: dict[str, object]) -> list[str]:
    """Return a line for each parameter that is of an older version: what took its place."""
    lines = [
        f"{name} no longer exists, and is not used: {SUPERSEDED[name]}"
        for name in parameters
        if name in SUPERSEDED
    ]
    if parameters.get("filter.method") in OLD_METHODS:
        method = parameters["filter.method"]
        lines.append(
            f"filter.method = {method!r} no longer exists: {_default_method()!r} is used instead"
        )
    return lines


def _of_this_version(parameters):
    kept = {name: value for name, value in parameters.items() if name not in SUPERSEDED}
    if kept.get("filter.method") in OLD_METHODS:
        kept["filter.method"] = _default_method()
    return kept


def _default_method():
    return BY_NAME["filter.method"].default


def check_one(name: str, value: Any) -> object:
    """Return the value of a parameter of the table or of ROS 2, or raise with what is wrong."""
    if name in BY_NAME:
        return checked(BY_NAME[name], value)
    if name in ROS_NAMES:
        # ROS 2 logs that it does not take another type, and goes on without it.
        if type(value) is not bool:
            raise PegOnHoleError(
                f"{name} = {shown(value)} is {_kind(value)}, not a bool: true or false"
            )
    elif not name.startswith(_ROS_PREFIX):
        raise PegOnHoleError(_unknown(name))
    return value


def checked(row: Parameter, value: Any) -> object:
    """Return the value of one parameter in its Python type, or raise with what is wrong."""
    kind = row.type.removesuffix("[]")
    if value is None or isinstance(value, str) and value in _NOTHING:
        raise PegOnHoleError(
            f"{row.name} has no value ({'null' if value is None else value}); {_example(row)}, or "
            "take the line out for the default"
        )
    if not row.type.endswith("[]"):
        return _scalar(row, row.name, kind, value)
    # The names of a group in place of a list would be taken for its items.
    if isinstance(value, (str, bytes, dict, set)) or not hasattr(value, "__len__"):
        raise PegOnHoleError(f"{row.name} = {shown(value)} is not {row.type}; {_example(row)}")
    # tolist() of numpy and array.array gives Python's own numbers.
    items = value.tolist() if hasattr(value, "tolist") else list(value)
    if not items:
        raise PegOnHoleError(f"{row.name} = [] is empty; {_example(row)}")
    if kind == "double" and len(items) != len(row.default):
        raise PegOnHoleError(
            f"{row.name} = {shown(items)} has {len(items)} values, not {len(row.default)}; "
            f"{_example(row)}"
        )
    return tuple(_scalar(row, f"{row.name}[{i}]", kind, item) for i, item in enumerate(items))


def _scalar(row, name, kind, value):
    example = _example(row, name != row.name)
    if value is None or name != row.name and value in ("", *_NOTHING):
        raise PegOnHoleError(
            f"{name} = {'null' if value is None else shown(value)} is empty; {example}"
        )
    # bool is an int for Python, not for ROS 2; numpy's numbers are neither.
    if type(value) is not _PYTHON[kind]:
        remedy = example
        if kind == "string" and type(value) in (bool, int, float):
            remedy = "write it within quotes"
        if kind == "double" and type(value) is int:
            remedy = f"write {_double(value)} (ROS 2 does not take an integer for a double)"
        raise PegOnHoleError(
            f"{name} = {shown(value)} is {_kind(value)}, not {_WORDS[_PYTHON[kind]]}; {remedy}"
        )
    if row.choices and value not in row.choices:
        raise PegOnHoleError(f"{name} = {shown(value)} is not one of {', '.join(row.choices)}")
    if row.topic and not _TOPIC.fullmatch(value):  # type: ignore[call-overload]
        raise PegOnHoleError(f"{name} = {shown(value)} is not the name of a topic; {example}")
    if row.low is not None:
        _within(row, name, value)
    return value


def _kind(value):
    """Return what a value is, in words."""
    if isinstance(value, dict):
        return "a group of names"
    return _WORDS.get(type(value), f"a {type(value).__name__}")


def _double(value):
    """Return an integer as a double is written; a text of its own where none is so large."""
    try:
        return shown(float(value))
    except OverflowError:
        return "a double"


def _within(row, name, value):
    if type(value) is int:
        # Of any size, where it did not come through ROS 2.
        value = float(max(min(value, 1 << 63), -1 << 63))
    if isfinite(value) and row.low <= value <= row.high:
        return
    unit = f" {row.unit}" if row.unit else ""
    remedy = f"the default is {_default_text(row.default)}{unit}"
    if row.unit in ("rad", "rad/s") and isfinite(value) and row.low <= radians(value) <= row.high:
        per = " a second" if row.unit == "rad/s" else ""
        remedy = f"degrees? {value:g} of them{per} are {radians(value):.6g}{unit}"
    elif isfinite(value):
        remedy = wrong_prefix_remedy(value, row.unit, row.low, row.high) or remedy
    raise PegOnHoleError(
        f"{name} = {value:g}{unit} is not within {row.low:g} to {row.high:g}{unit}; {remedy}"
    )


def _unknown(name):
    below = [row for row in BY_NAME if row.startswith(f"{name}.")]
    if below:
        return f"{name} is a group of parameters, not one of them; write it as in '{below[0]}'"
    if ":" in name:
        return f"unknown parameter {shown(name)}; {spaced(name)}"
    if name.rsplit(".", 1)[-1].isdigit():
        return f"unknown parameter {shown(name)}; a number has a point, not a comma: 0.2"
    # Words misspelt, or the right words in the wrong group.
    given, name = name, name[:MOST_SHOWN]
    near = difflib.get_close_matches(name, BY_NAME, n=3, cutoff=0.7)
    last = {row.rsplit(".", 1)[-1]: row for row in BY_NAME}
    for word in difflib.get_close_matches(name.rsplit(".", 1)[-1], last, n=3, cutoff=0.75):
        if last[word] not in near:
            near.append(last[word])
    if not near:
        group = name.split(".", 1)[0] + "."
        near = [row for row in BY_NAME if row.startswith(group)]
    if not near:
        groups = sorted({row.split(".")[0] for row in BY_NAME})
        return f"unknown parameter {shown(given)}; there are: {', '.join(groups)}"
    return f"unknown parameter {shown(given)}; the nearest are: {', '.join(near)}"


def spaced(text: str) -> str:
    """Return the remedy for a name that has its value in it, since YAML asks for a space."""
    name, _, value = text.partition(":")
    written = cut(printable(f"{name.rsplit('.', 1)[-1]}: {value}"))
    return f"a colon needs a space behind it: '{written}'"


def half_stated_zero(configuration: Configuration) -> str:
    """Return what is stated of a sensor's zero by half, and what that means, or nothing."""
    wrench = configuration.wrench
    force, torque = wrench.bias_force_stddev, wrench.bias_torque_stddev
    if bool(force) == bool(torque):
        return ""
    said, value, other, of = (
        ("wrench.bias_force_stddev", f"{force:g} N", "wrench.bias_torque_stddev", "torques")
        if force
        else ("wrench.bias_torque_stddev", f"{torque:g} N m", "wrench.bias_force_stddev", "forces")
    )
    return (
        f"state {other} too, unless the bias of the {of} is known, as 0 means: {said} is {value}"
    )


def _check_together(configuration):
    joints, monitor = configuration.joints, configuration.monitor
    usual = JointInput().hole_xyz_stddev
    if len(set(joints.names)) != len(joints.names):
        raise PegOnHoleError(f"joints.names = {list(joints.names)} names a joint twice")
    if joints.source == "peg" and len(joints.names) != 3:
        raise PegOnHoleError(
            f"joints.names = {list(joints.names)} has {len(joints.names)} names; "
            "joints.source peg needs 3, in the order gamma, psi, phi"
        )
    if joints.source != "robot" and joints.hole_xyz_stddev not in (0.0, usual):
        raise PegOnHoleError(
            f"joints.hole_xyz_stddev = {joints.hole_xyz_stddev:g} m needs joints.source robot, "
            f"which is {joints.source!r}: the peg's own angles do not determine where it is; "
            "set it to 0.0"
        )
    if monitor.inserted_depth and joints.place_stddev is None:
        raise PegOnHoleError(
            f"monitor.inserted_depth = {monitor.inserted_depth:g} m needs the measured place of "
            "the peg: joints.source robot, with joints.hole_xyz and hole_xyz_stddev stated; set "
            "it to 0.0"
        )
    axes = configuration.wrench.axes
    if not axes or joints.source != "robot" and axes not in ("sensor", "base"):
        raise PegOnHoleError(
            f"wrench.axes = {shown(axes)} is not one of sensor, base; the name of a link needs "
            "joints.source robot"
        )
    if joints.source == "robot":
        for name in ("urdf", "tip_frame"):
            if not getattr(joints, name):
                raise PegOnHoleError(f"joints.{name} is empty, but joints.source robot needs it")
    for group, low, high in (
        ("monitor", "transition_probability_off", "transition_probability_on"),
        ("monitor", "jamming_warn", "jamming_error"),
        ("plan", "min_closing_rate", "max_closing_rate"),
    ):
        record = getattr(configuration, group)
        if getattr(record, low) > getattr(record, high):
            unit = BY_NAME[f"{group}.{low}"].unit
            unit = f" {unit}" if unit else ""
            raise PegOnHoleError(
                f"{group}.{low} = {getattr(record, low):g}{unit} is above {group}.{high} = "
                f"{getattr(record, high):g}{unit}; it has to be at most that"
            )
    if monitor.alarm_hysteresis >= monitor.jamming_warn:
        raise PegOnHoleError(
            f"monitor.alarm_hysteresis = {monitor.alarm_hysteresis:g} is not below "
            f"monitor.jamming_warn = {monitor.jamming_warn:g}: a risk of 0 would clear no alarm; "
            "make it smaller, such as a seventh of that"
        )
    check_topics(configuration.topics)
    _check_frames(configuration.frames)


def _check_frames(frames: Frames) -> None:
    names = {f"frames.{name}": value for name, value in vars(frames).items()}
    for name, value in names.items():
        # As tf2 has it.
        if value.startswith("/"):
            raise PegOnHoleError(
                f"{name} = {shown(value)} begins with a slash, which no frame of tf2 does; take "
                "it out"
            )
        if not value and name != "frames.base":
            raise PegOnHoleError(f"{name} is empty; {_example(BY_NAME[name])}")
    told: dict[str, str] = {}
    for name, value in names.items():
        if value and value in told:
            raise PegOnHoleError(
                f"{told[value]} and {name} are both {shown(value)}: they are two frames, and need "
                "two names"
            )
        told[value] = name


def check_topics(topics: Topics) -> None:
    """
    Refuse one topic for both.

    Raises
    ------
    PegOnHoleError

    """
    # A name without a slash lies in the root, or in the node's namespace, which often is the root.
    if topics.wrench.lstrip("/") == topics.joint_states.lstrip("/"):
        raise PegOnHoleError(
            f"topics.wrench = {topics.wrench!r} and topics.joint_states = "
            f"{topics.joint_states!r} are one topic; they have to be two"
        )


def _default_text(default):
    return str(list(default)) if isinstance(default, tuple) else f"{default:g}"


def _example(row, item=False):
    """Return what a parameter is, or an item of it, with its default as an example."""
    kind, value = row.type, row.default
    if item:
        kind, value = kind.removesuffix("[]"), value[0]
    elif isinstance(value, tuple):
        value = list(value)
    return f"it is {_article(kind)}" + (f" such as {value!r}" if value != "" else "")


def _article(kind):
    return f"an {kind}" if kind == "integer" else f"a {kind}"
