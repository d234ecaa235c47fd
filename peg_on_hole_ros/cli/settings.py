"""Configuration of a command, from its file or by default."""

from peg_on_hole_ros.configuration import from_parameters, node_options
from peg_on_hole_ros.edges.config_file import read_parameters
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.options import Configuration, NodeOptions


def load(path: str | None) -> tuple[Configuration, NodeOptions]:
    """Return what a ROS 2 parameters file gives, or the defaults; errors name the file."""
    parameters = read_parameters(path) if path else {}
    try:
        return from_parameters(parameters), node_options(parameters)
    except PegOnHoleError as error:
        raise PegOnHoleError(f"{path}: {error}") from None
