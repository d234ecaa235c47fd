"""What a command says that needs ROS 2, where there is none."""

from peg_on_hole_ros.errors import PegOnHoleError


def no_ros(error: ModuleNotFoundError, what: str) -> PegOnHoleError:
    """
    Return the error that tells how to come by ROS 2.

    Parameters
    ----------
    error : ModuleNotFoundError
        Raised again where a module of this package is what is missing.
    what : str
        That needs it, as the beginning of a sentence.

    """
    if not error.name or error.name.startswith("peg_on_hole_ros"):
        raise error
    return PegOnHoleError(
        f"{what} needs ROS 2 ({error.name} is missing): source its setup.bash, or install its "
        "wheels from a checkout of this package: pip install '.[ros]'"
    )
