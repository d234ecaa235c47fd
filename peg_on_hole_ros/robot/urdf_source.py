"""Where a robot's description is to be had: a file, within bounds, or a topic."""

import stat
from collections.abc import Iterable
from pathlib import Path

from peg_on_hole_ros.config.options import JointInput
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.safe_text import printable, shown

# A robot's description has some 100 kB.
MOST_URDF_BYTES = 16 * 10**6
PACKAGE_SCHEME = "package://"
# Value of `joints.urdf` for a description that comes by topics.robot_description.
FROM_TOPIC = "topic"


def awaited(options: JointInput) -> bool:
    """Return whether a description is needed that a topic has yet to bring."""
    return options.source == "robot" and options.urdf == FROM_TOPIC and not options.description


def named(options: JointInput) -> str:
    """Return what messages call the description; raises PegOnHoleError for what is no path."""
    if options.described_by:
        return options.described_by
    return "the robot's description" if options.urdf == FROM_TOPIC else str(urdf_path(options))


def urdf_path(options: JointInput) -> Path:
    """Return where joints.urdf is, `~` replaced; raises PegOnHoleError for what is no path."""
    try:
        path = Path(options.urdf).expanduser()
    except RuntimeError:
        user = options.urdf.split("/")[0]
        raise PegOnHoleError(f"joints.urdf: there is no user for {shown(user)}") from None
    if "\0" in options.urdf:
        raise PegOnHoleError(f"joints.urdf = {shown(options.urdf)} is no name of a file")
    if options.urdf.startswith(PACKAGE_SCHEME):
        name, _, rest = options.urdf.removeprefix(PACKAGE_SCHEME).partition("/")
        raise PegOnHoleError(
            f"joints.urdf = {shown(options.urdf)} names a package; give the file's path: "
            f"`ros2 pkg prefix --share {printable(name)}` prints the folder that has "
            f"{shown(rest)}"
        )
    return path


def beside(urdf: str, files: Iterable[str | Path]) -> str:
    """
    Return where a URDF is, of a name that is relative to the parameters file that states it.

    Parameters
    ----------
    urdf : str
        `joints.urdf`; a name that is found from the working directory stays.
    files : iterable of str or Path
        Parameters files.

    """
    try:
        if (
            urdf in ("", FROM_TOPIC)
            or Path(urdf).is_absolute()
            or urdf.startswith("~")
            or Path(urdf).exists()
        ):
            return urdf
        found = [Path(file).parent / urdf for file in files]
        return next((str(path) for path in found if path.is_file()), urdf)
    except ValueError:
        # A NUL: what is wrong is told where the file is read.
        return urdf


def description_of(options: JointInput) -> str:
    """
    Return the robot's description, from a file where it is not at hand.

    Raises
    ------
    PegOnHoleError
        No such file, none that is regular, one above MOST_URDF_BYTES, or no text.

    """
    if awaited(options):
        raise PegOnHoleError("joints.urdf = 'topic': no description has come yet")
    return options.description or _urdf_text(urdf_path(options))


def _urdf_text(path):
    check_regular(path)
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise PegOnHoleError(f"joints.urdf: there is no file {path.absolute()}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise PegOnHoleError(f"joints.urdf: cannot read {path}: {error}") from None


def check_regular(path: Path) -> None:
    """Refuse what may block or have no end, before it is opened; a file may be missing."""
    try:
        found = path.stat()
    except OSError:
        return
    if not stat.S_ISREG(found.st_mode):
        raise PegOnHoleError(f"joints.urdf: {path} is no regular file, so it is not opened")
    if found.st_size > MOST_URDF_BYTES:
        raise PegOnHoleError(
            f"joints.urdf: {path} has {found.st_size / 1e6:.6g} MB, a description at most "
            f"{MOST_URDF_BYTES / 1e6:g} MB"
        )
