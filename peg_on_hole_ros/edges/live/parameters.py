"""Parameters of the node: declared from the table, checked together, fixed once configured."""

from pathlib import Path

import yaml
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.node import Node

from peg_on_hole_ros.configuration import check, from_parameters, node_options
from peg_on_hole_ros.edges.config_file import is_ours, matches
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.options import Configuration, NodeOptions
from peg_on_hole_ros.parameter_table import PARAMETERS

_BODY = "ros__parameters"


def declare(node: Node) -> None:
    """
    Declare every row of the table that no override has declared yet.

    Typing is dynamic, so that a value of a wrong type reaches the check of the configuration,
    whose message has unit, range and remedy; rclpy's own has none.
    """
    for row in PARAMETERS:
        unit = f" [{row.unit}]" if row.unit else ""
        descriptor = ParameterDescriptor(
            name=row.name, description=f"{row.effect}{unit}", dynamic_typing=True
        )
        if node.has_parameter(row.name):
            node.set_descriptor(row.name, descriptor)
        else:
            default = list(row.default) if isinstance(row.default, tuple) else row.default
            node.declare_parameter(row.name, default, descriptor)


class NoEmptyLists:
    """
    For a Node: refuses empty lists by name.

    ROS 2 hands them over as no value, and rclpy raises at one, before any check, without its name.
    """

    def declare_parameters(self, namespace, parameters, ignore_override=False):
        """Declare; a Node does it first with what files and arguments have."""
        empty = [row[0] for row in parameters if len(row) > 1 and row[1] is None]
        check({name: [] for name in empty})
        if empty:
            raise PegOnHoleError(
                f"{empty[0]} = [] is empty, which ROS 2 takes for no value; give it one, or take "
                "the line out"
            )
        return super().declare_parameters(namespace, parameters, ignore_override)


def values(node: Node) -> dict[str, object]:
    """Return every parameter of the node by its dotted name."""
    names = node.list_parameters([], 0).names
    return {name: node.get_parameter(name).value for name in names}


def read(node: Node) -> tuple[Configuration, NodeOptions]:
    """
    Return the checked configuration.

    Raises
    ------
    PegOnHoleError
        Unknown name, wrong type, value out of range, values that do not fit together.

    """
    parameters = values(node)
    return from_parameters(parameters), node_options(parameters)


def refusal(node: Node, configured: bool, changed) -> SetParametersResult:
    """Say whether parameters may be changed; a change without effect is refused with a reason."""
    ours = {row.name for row in PARAMETERS}
    new = {parameter.name: parameter.value for parameter in changed}
    if configured and ours & new.keys():
        return SetParametersResult(
            successful=False,
            reason="the estimator is built from its parameters when it is configured: "
            "deactivate and clean up the node first, then set them and configure it again",
        )
    try:
        from_parameters(values(node) | new)
    except PegOnHoleError as error:
        return SetParametersResult(successful=False, reason=str(error))
    return SetParametersResult(successful=True)


def check_files(full_name: str, arguments: list[str]) -> None:
    """
    Refuse parameters files that have this node's parameters under other nodes' names only.

    ROS 2 itself says nothing then, and the node would run with its defaults. All files count
    together: those of other programs, and of other nodes of this kind, may be among them.

    Parameters
    ----------
    full_name : str
        Of the node, such as `/cell/peg_on_hole`.
    arguments : list of str
        Of the process.

    Raises
    ------
    PegOnHoleError
        With the names that the files have.

    """
    others: dict[str, list[str]] = {}
    for path in _files(arguments):
        try:
            content = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, yaml.YAMLError):
            continue  # ROS 2 has its own word on these
        for name, body in _sections(content):
            ours = is_ours(body)
            # A part for all nodes may be there for the clock alone.
            if matches(name, full_name) and (ours or "*" not in name):
                return
            if ours:
                others.setdefault(path, []).append(name)
    if others:
        found = ", ".join(
            f"{path} has parameters for {', '.join(names)}" for path, names in others.items()
        )
        raise PegOnHoleError(
            f"{found}, but this node is {full_name} and would run with its defaults: write "
            f"'{full_name}:' or '/**:' in the file"
        )


def _files(arguments):
    return [value for word, value in zip(arguments, arguments[1:]) if word == "--params-file"]


def _sections(tree, prefix=""):
    if not isinstance(tree, dict):
        return
    for key, value in tree.items():
        if key == _BODY:
            yield prefix or "/", value
        else:
            yield from _sections(value, f"{prefix}/{str(key).strip('/')}")
