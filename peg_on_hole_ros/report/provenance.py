"""Where a report comes from: versions, date, the input's hash, settings."""

import hashlib
import platform
from collections.abc import Iterable
from datetime import datetime, timezone
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from peg_on_hole_ros import __version__
from peg_on_hole_ros.config.configuration import BY_NAME, to_parameters
from peg_on_hole_ros.config.options import Configuration

_NAMED_LIBRARIES = ("numpy", "numba", "scipy", "mcap", "plotly")


def versions() -> list[tuple[str, str]]:
    """Return names and versions of what has made the report."""
    found = [("peg_on_hole_ros", __version__), ("Python", platform.python_version())]
    for name in _NAMED_LIBRARIES:
        try:
            found.append((name, version(name)))
        except PackageNotFoundError:
            continue
    return [*found, ("system", platform.platform())]


def made_at() -> str:
    """Return date and time of now, UTC."""
    return datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M:%S UTC")


def stamp_text(t: float) -> str:
    """Return a stamp [s] as date and time, UTC; as a number where it is none of a calendar."""
    try:
        return datetime.fromtimestamp(t, timezone.utc).strftime("%Y-%m-%d %H:%M:%S UTC")
    except (OverflowError, OSError, ValueError):
        return f"{t:.3f} s"


def hash_file(digest: "hashlib._Hash", path: Path) -> None:
    """Add the content of a file to a hash, in pieces: a bag may be larger than the memory."""
    with path.open("rb") as stream:
        while piece := stream.read(1 << 20):
            digest.update(piece)


def hashes(files: Iterable[Path]) -> list[tuple[str, str]]:
    """Return name and SHA-256 of each file."""
    found = []
    for path in files:
        digest = hashlib.sha256()
        hash_file(digest, path)
        found.append((path.name, digest.hexdigest()))
    return found


def settings(configuration: Configuration) -> tuple[list[tuple], list[tuple]]:
    """Return rows of the settings that are not the defaults (with these), and of the others."""
    usual = to_parameters(Configuration())
    changed, kept = [], []
    for name, value in to_parameters(configuration).items():
        unit = BY_NAME[name].unit
        if value == usual[name]:
            kept.append((name, str(value), unit))
        else:
            changed.append((name, str(value), str(usual[name]), unit))
    return changed, kept
