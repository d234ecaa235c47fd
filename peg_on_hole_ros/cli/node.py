"""`peg-on-hole node`: the ROS 2 node."""

from peg_on_hole_ros.errors import PegOnHoleError


def run(arguments) -> int:
    """Run the node until it is stopped."""
    try:
        from peg_on_hole_ros.edges import node
    except ModuleNotFoundError as error:
        if not error.name or error.name.startswith("peg_on_hole_ros"):
            raise
        raise PegOnHoleError(
            f"the node needs ROS 2 ({error.name} is missing): source its setup.bash, or install "
            "the wheels: pip install 'peg_on_hole_ros[ros]'"
        ) from None
    return node.main(arguments.arguments) or 0
