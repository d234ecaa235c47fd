"""The configuration that commands are given."""

import sys

from peg_on_hole_ros.config.configuration import (
    from_parameters,
    half_stated_zero,
    node_options,
    superseded,
)
from peg_on_hole_ros.config.options import Configuration, NodeOptions
from peg_on_hole_ros.config.parameters_file import read_parameters
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.robot.urdf_source import beside


def load(path: str | None) -> tuple[Configuration, NodeOptions]:
    """Return what a ROS 2 parameters file gives, for None the defaults; errors name the file."""
    check_path(path)
    parameters = {} if path is None else read_parameters(path)
    if path and "joints.urdf" in parameters:
        parameters["joints.urdf"] = beside(str(parameters["joints.urdf"]), [path])
    try:
        configuration, node = from_parameters(parameters), node_options(parameters)
    except PegOnHoleError as error:
        raise PegOnHoleError(f"{path}: {error}") from None
    for line in superseded(parameters):
        print(f"configuration: {line}", file=sys.stderr)
    remark(configuration)
    return configuration, node


def check_path(path: str | None) -> None:
    """Refuse an empty path, as an unset variable of a shell gives: the defaults are not meant."""
    if path == "":
        raise PegOnHoleError(
            "the path of the configuration is empty; name a file, or leave it out"
        )


def remark(configuration: Configuration) -> None:
    """Say what can be used and may not be meant."""
    half = half_stated_zero(configuration)
    if half:
        print(f"configuration: {half}", file=sys.stderr)
