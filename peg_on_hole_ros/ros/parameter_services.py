"""The services of a node's parameters, by its public methods: nothing that is asked ends it."""

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from rclpy.exceptions import ParameterNotDeclaredException, ParameterUninitializedException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_parameters

from peg_on_hole_ros.safe_text import printable

# A parameter that is not declared, or has no value.
_ABSENT = (ParameterNotDeclaredException, ParameterUninitializedException)


def serve_parameters(node: Node) -> None:
    """
    Give a node the six services of parameters that every node of ROS 2 has.

    rclpy's own end the node by a parameter of a type that there is not.

    Parameters
    ----------
    node : Node
        Without services of parameters (`start_parameter_services=False`).

    """
    for name, (kind, answer) in _ANSWERS.items():
        node.create_service(
            kind, f"~/{name}", partial(answer, node), qos_profile=qos_profile_parameters
        )


def _describe(node, request, response):
    response.descriptors = _of_all(node.describe_parameters, request.names)
    return response


def _get(node, request, response):
    found = _of_all(node.get_parameters, request.names)
    response.values = [parameter.get_parameter_value() for parameter in found]
    return response


def _get_types(node, request, response):
    response.types = _of_all(node.get_parameter_types, request.names)
    return response


def _of_all(get, names):
    """Return what all names have; nothing where one of them is absent, as rclpy answers."""
    try:
        return get(names)
    except _ABSENT:
        return []


def _list(node, request, response):
    response.result = node.list_parameters(request.prefixes, request.depth)
    return response


def _set(node, request, response):
    response.results = [_set_all(node, [message]) for message in request.parameters]
    return response


def _set_atomically(node, request, response):
    response.result = _set_all(node, request.parameters)
    return response


def _set_all(node: Node, messages: Iterable[ParameterMessage]) -> SetParametersResult:
    """Set all or none of what was asked for; what is thrown is the reason why not."""
    try:
        parameters = [Parameter.from_parameter_msg(message) for message in messages]
        return node.set_parameters_atomically(parameters)
    # A type that does not exist, a parameter that is not declared, one that cannot be deleted.
    except Exception as error:
        return SetParametersResult(successful=False, reason=printable(error))


_ANSWERS: dict[str, tuple[type, Callable[[Node, Any, Any], Any]]] = {
    "describe_parameters": (DescribeParameters, _describe),
    "get_parameters": (GetParameters, _get),
    "get_parameter_types": (GetParameterTypes, _get_types),
    "list_parameters": (ListParameters, _list),
    "set_parameters": (SetParameters, _set),
    "set_parameters_atomically": (SetParametersAtomically, _set_atomically),
}
