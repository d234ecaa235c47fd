"""Pictures that commands write: as PNG and as SVG, the same bytes for the same numbers."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from peg_on_hole_ros.errors import PegOnHoleError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def needed() -> None:
    """
    Refuse before the work, not after it, where pictures cannot be drawn.

    Raises
    ------
    PegOnHoleError
        matplotlib is missing.

    """
    if importlib.util.find_spec("matplotlib") is None:
        raise PegOnHoleError(
            "pictures need matplotlib, which is not installed: pip install matplotlib"
        )


def save(figure: Figure, stem: Path, suffixes: Sequence[str] = (".png", ".svg")) -> list[Path]:
    """Write a picture as stem.png and stem.svg; return the paths."""
    import matplotlib

    written = []
    with matplotlib.rc_context({"svg.hashsalt": "peg-on-hole", "svg.fonttype": "none"}):
        for suffix in suffixes:
            path = stem.with_suffix(suffix)
            # No date: the same numbers give the same file.
            metadata = {"Date": None} if suffix == ".svg" else {"Software": None}
            try:
                figure.savefig(path, metadata=metadata)
            except OSError as error:
                raise PegOnHoleError(f"cannot write {path}: {error.strerror}") from None
            written.append(path)
    return written
