"""A copy of the checkout that may be edited, with its compiled code beside it."""

import os
import shutil
from pathlib import Path

from peg_on_hole_ros.numba_cache import PACKAGE_FOLDER

ROOT = PACKAGE_FOLDER.parent
LEFT_OUT = shutil.ignore_patterns(".*", "out", "site", "__pycache__")


class CheckoutCopy:
    """
    A copy in a folder that is its own.

    Compiled code is kept beside it, and serves the next copy where nothing has changed.
    """

    def __init__(self, folder: Path):
        self.checkout = folder.resolve() / "checkout"
        self.compiled = folder.resolve() / "compiled"

    def copy(self, part: str = "") -> None:
        """Write the copy anew, as the checkout is, or a folder of it alone."""
        shutil.rmtree(self.checkout, ignore_errors=True)
        shutil.copytree(ROOT / part, self.checkout / part, ignore=LEFT_OUT)

    def place(self, name: str) -> Path:
        """Return where a file of the package is in the copy, by its name within the package."""
        return self.checkout / PACKAGE_FOLDER.name / name

    def edit(self, name: str, text: str) -> None:
        """Put a text in the place of a file's."""
        path = self.place(name)
        times = path.stat().st_atime_ns, path.stat().st_mtime_ns
        path.write_text(text, encoding="utf-8")
        # numba compiles anew what is younger.
        os.utime(path, ns=times)

    def environment(self) -> dict[str, str]:
        """Return the environment of a process that runs in the copy."""
        return {
            **os.environ,
            "PYTHONPATH": str(self.checkout),
            "NUMBA_CACHE_DIR": str(self.compiled),
        }
