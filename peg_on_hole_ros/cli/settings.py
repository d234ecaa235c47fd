"""What commands have in common: their configuration, and places that can be written."""

from pathlib import Path

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


def check_places(source: str, outputs: list[str]) -> None:
    """
    Refuse places that cannot be written before the work, not after it.

    Parameters
    ----------
    source : str
        File that is read, and must not be overwritten.
    outputs : list of str

    Raises
    ------
    PegOnHoleError

    """
    for path in map(Path, outputs):
        if not path.parent.is_dir():
            raise PegOnHoleError(f"cannot write {path}: there is no folder {path.parent}")
        if path.is_dir():
            raise PegOnHoleError(f"cannot write {path}: it is a folder")
        if path.exists() and Path(source).exists() and path.samefile(source):
            raise PegOnHoleError(f"cannot write {path}: it is the file that is read")
    if len({Path(path).absolute() for path in outputs}) < len(outputs):
        raise PegOnHoleError("--out, --report and --summary name one file twice")


def out_folder(path: str) -> Path:
    """
    Return a folder for results, made where it is missing.

    Raises
    ------
    PegOnHoleError
        It is a file, or cannot be made.

    """
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PegOnHoleError(f"cannot make the folder {folder}: {error.strerror}") from None
    return folder
