"""Parameters of the node: declared from the table, checked together, fixed once configured."""

from collections.abc import Callable, Iterable
from copy import copy
from pathlib import Path

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from peg_on_hole_ros.config.configuration import (
    BY_NAME,
    check,
    check_one,
    from_parameters,
    node_options,
)
from peg_on_hole_ros.config.node_parts import BODY, is_ours, of_node, parts
from peg_on_hole_ros.config.options import Configuration, NodeOptions
from peg_on_hole_ros.config.parameter_table import PARAMETERS
from peg_on_hole_ros.config.parameters_file import load_yaml, read_parameters
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.robot.urdf_source import beside
from peg_on_hole_ros.safe_text import printable
from peg_on_hole_ros.startup.exit_codes import exit_code_and_text

# What nothing reads after the process has started.
_AT_START = ("autostart",)
# Arguments of the launch file, which launch_ros writes to a parameters file of their own.
BY_LAUNCH = {"use_sim_time", "autostart"}


def declare(node: Node) -> None:
    """
    Declare every row of the table that no override has declared yet.

    Typing is dynamic, so that a value of a wrong type reaches the check of the configuration,
    whose message has unit, range and remedy; rclpy's own has none.
    """
    for row in PARAMETERS:
        if not node.has_parameter(row.name):
            default = list(row.default) if isinstance(row.default, tuple) else row.default
            descriptor = ParameterDescriptor(name=row.name, dynamic_typing=True)
            node.declare_parameter(row.name, default, descriptor)


def describe(node: Node) -> None:
    """Have the descriptors of parameters that have been checked say effect, unit and range."""
    for row in PARAMETERS:
        unit = f" [{row.unit}]" if row.unit else ""
        descriptor = ParameterDescriptor(
            name=row.name,
            description=f"{row.effect}{unit}",
            additional_constraints=_constraints(row),
            dynamic_typing=True,
        )
        if row.type == "double" and row.low is not None:
            ends = {"from_value": float(row.low), "to_value": float(row.high)}
            descriptor.floating_point_range = [FloatingPointRange(**ends)]
        if row.type == "integer" and row.low is not None:
            ends = {"from_value": int(row.low), "to_value": int(row.high)}
            descriptor.integer_range = [IntegerRange(**ends)]
        node.set_descriptor(row.name, descriptor)


def _constraints(row):
    """Return in words what a descriptor has no fields for."""
    told = [] if row.live else ["needs a node that is not configured"]
    if row.name in _AT_START:
        told = ["read when the process starts"]
    if row.choices:
        told.append(f"one of {', '.join(row.choices)}")
    elif row.type == "double[]":
        told.append(f"{len(row.default)} values from {row.low:g} to {row.high:g}")
    return "; ".join(told)


class ExplainsRefusals:
    """For a Node: says what can be set at present, and why the rest cannot."""

    def describe_parameter(self, name: str) -> ParameterDescriptor:
        """Return a descriptor; read_only: as long as a change would be refused."""
        # rclpy takes no descriptor back that is read-only, which is so for a while alone.
        descriptor = copy(super().describe_parameter(name))
        if name in BY_NAME:
            descriptor.read_only = bool(self._why_fixed(name))
        return descriptor

    def _why_fixed(self, name):
        """Return why no value of a parameter is taken at present; empty: one may be."""
        if self.is_finalized:
            return "the node is finalized, and reads no parameter any more; start it again"
        if self.is_declared and name in _AT_START:
            return "it is read once, when the process starts; restart the node with it"
        if self.is_configured and not BY_NAME[name].live:
            return (
                "the estimator is built with it when it is configured; deactivate and clean up "
                "the node first, then set it and configure the node again"
            )
        return ""

    def set_parameters_atomically(self, parameter_list: list[Parameter]) -> SetParametersResult:
        """Set all or none; what cannot be set at present, and no parameter, has its reason."""
        result = refusal(self, self._why_fixed, parameter_list)
        if not result.successful:
            return result
        before = [self.get_parameter(parameter.name) for parameter in parameter_list]
        try:
            return super().set_parameters_atomically(parameter_list)
        except Exception as error:
            # Of a callback: what it had taken by then is put back, and the node goes on.
            super().set_parameters_atomically(before)
            return _refused(error)


class FilesChecked:
    """
    For a Node: looks through the parameters files before ROS 2 hands over what it made of them.

    What is wrong is told with file and line, as by every command; ROS 2 hands over values alone,
    an empty list as no value, at which rclpy raises without its name.

    Attributes
    ----------
    arguments : list of str
        Of the process; set before the Node is made.

    """

    arguments: list[str]
    _looked = False

    def declare_parameters(
        self, namespace: str, parameters: list[tuple], ignore_override: bool = False
    ) -> list[Parameter]:
        """Declare; a Node does it first with what files and arguments have."""
        if not self._looked:
            self._looked = True
            check_files(self.get_fully_qualified_name(), self.arguments)
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
    if isinstance(parameters.get("joints.urdf"), str):
        parameters["joints.urdf"] = beside(parameters["joints.urdf"], _files(node.arguments))
    return from_parameters(parameters), node_options(parameters)


def refusal(
    node: Node, why_fixed: Callable[[str], str], changed: Iterable[Parameter]
) -> SetParametersResult:
    """
    Say whether parameters may be changed; a change without effect is refused with a reason.

    `why_fixed` returns why no value of a parameter is taken at present; empty: one may be.
    """
    new = {parameter.name: parameter.value for parameter in changed}
    try:
        for name, value in new.items():
            check_one(name, value)
        whys = {name: why_fixed(name) for name in new if name in BY_NAME}
        for why in filter(None, whys.values()):
            fixed = [name for name in whys if whys[name] == why]
            raise PegOnHoleError(f"{', '.join(fixed)}: {why}")
        from_parameters(values(node) | new)
    except Exception as error:
        return _refused(error)
    return SetParametersResult(successful=True)


def _refused(error):
    reason = printable(exit_code_and_text(error)[1])
    return SetParametersResult(successful=False, reason=reason)


def live(changed: Iterable[Parameter]) -> dict[str, object]:
    """Return name and value of those that a node takes while it runs, as JSON has them."""
    found = {}
    for parameter in changed:
        if parameter.name in BY_NAME and BY_NAME[parameter.name].live:
            value = parameter.value
            found[parameter.name] = value.tolist() if hasattr(value, "tolist") else value
    return found


def check_files(full_name: str, arguments: list[str]) -> None:
    """
    Check what parameters files have for this node, and refuse those that have it for others only.

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
        With file and line, or with the names that the files have.

    """
    others: dict[str, list[str]] = {}
    found = False
    for path in _files(arguments):
        try:
            sections = list(parts(load_yaml(Path(path))))
        except PegOnHoleError:
            continue  # ROS 2 has its own word on these, or takes them, as a group that is twice
        own = of_node(sections, full_name)
        if own:
            read_parameters(path, full_name)
        found |= any(_is_ours(part) or _names_it(part) for part in own)
        names = [
            f"/{printable(part.name.strip('/'))}"
            for part in sections
            if part not in own and _is_ours(part)
        ]
        if names:
            others[path] = names
    if others and not found:
        listed = ", ".join(
            f"{path} has parameters for {', '.join(names)}" for path, names in others.items()
        )
        raise PegOnHoleError(
            f"{listed}, but this node is {full_name} and would run with its defaults: write "
            f"'{full_name}:' or '/**:' in the file"
        )


def _files(arguments):
    return [value for word, value in zip(arguments, arguments[1:]) if word == "--params-file"]


def _names_it(part):
    # For all nodes there may be anything; and a launch sets its own of each by its name.
    body = _body(part)
    return "*" not in part.name and not (isinstance(body, dict) and set(body) <= BY_LAUNCH)


def _is_ours(part):
    return is_ours(_body(part))


def _body(part):
    return part.body.get(BODY) if isinstance(part.body, dict) else None
