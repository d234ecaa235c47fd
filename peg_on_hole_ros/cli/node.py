"""`peg-on-hole node`: the ROS 2 node."""

import argparse
from typing import NoReturn

from peg_on_hole_ros.cli.settings import check_path
from peg_on_hole_ros.config.parameters_file import read_parameters
from peg_on_hole_ros.errors import PegOnHoleError


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
        if not error.name or error.name.startswith("peg_on_hole_ros"):
            raise
        raise PegOnHoleError(
            f"the node needs ROS 2 ({error.name} is missing): source its setup.bash, or install "
            "its wheels from a checkout of this package: pip install '.[ros]'"
        ) from None
    node.main([*file, *arguments.others, *arguments.ros])
