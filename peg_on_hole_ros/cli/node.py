"""`peg-on-hole node`: the ROS 2 node."""

import argparse
from typing import NoReturn

from peg_on_hole_ros.cli.settings import check_path
from peg_on_hole_ros.cli.without_ros import no_ros
from peg_on_hole_ros.config.parameters_file import read_parameters


def run(arguments: argparse.Namespace) -> NoReturn:
    """Run the node until it is stopped; `--config` is given to it as ROS's parameters file."""
    file = []
    check_path(arguments.config)
    if arguments.config is not None:
        # For the same errors as every other command; what fits together the node itself checks,
        # since arguments behind --ros-args may change single values.
        read_parameters(arguments.config)
        file = ["--ros-args", "--params-file", arguments.config, "--"]
    try:
        from peg_on_hole_ros.ros import node
    except ModuleNotFoundError as error:
        raise no_ros(error, "the node") from None
    node.main([*file, *arguments.others, *arguments.ros])
