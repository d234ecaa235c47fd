"""The configuration that commands are given."""

from peg_on_hole_ros.configuration import from_parameters, node_options
from peg_on_hole_ros.edges.config_file import read_parameters
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.options import Configuration, NodeOptions


def load(path: str | None) -> tuple[Configuration, NodeOptions]:
    """Return what a ROS 2 parameters file gives, for None the defaults; errors name the file."""
    if path == "":
        raise PegOnHoleError(
            "the path of the configuration is empty; name a file, or leave it out"
        )
    parameters = {} if path is None else read_parameters(path)
    try:
        return from_parameters(parameters), node_options(parameters)
    except PegOnHoleError as error:
        raise PegOnHoleError(f"{path}: {error}") from None
