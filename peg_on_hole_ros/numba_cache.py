"""Where compiled code is kept between runs: a folder for each state of the sources."""

import hashlib
import os
import stat
import sys
import tempfile
from pathlib import Path

PACKAGE_FOLDER = Path(__file__).parent
# Where functions that numba compiles stand, or what goes into them. The table of outputs does not:
# the type of a row, which comes of it, is a part of what numba keys its code on.
COMPILED = (
    "mechanics", "measurements", "estimator", "identification", "monitor", "diagnosis", "engine",
    "sim", "study",
    "bags/storage/message_rows.py", "messages/cdr_layout.py",
)  # fmt: skip


def source_key() -> str:
    """
    Return a name for the present state of the sources.

    numba keys what it keeps on the file of the compiled function alone; an edit of a function or
    of a constant that it takes from another file would go unseen.
    """
    digest = hashlib.sha256()
    for part in COMPILED:
        for path in sorted((PACKAGE_FOLDER / part).rglob("*.py")) or [PACKAGE_FOLDER / part]:
            name = path.relative_to(PACKAGE_FOLDER).as_posix()
            digest.update(name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def choose_folder() -> Path:
    """
    Tell numba where to keep compiled code, and return that folder.

    It is named by the state of the sources, under NUMBA_CACHE_DIR where that is set, else under
    the user's cache (XDG_CACHE_HOME or ~/.cache), else under a temporary one of the user's own.
    Called before numba is imported; where it was imported already, its setting is changed.

    Raises
    ------
    OSError
        NUMBA_CACHE_DIR is set to what cannot be written.

    """
    key = source_key()
    given = os.environ.get("NUMBA_CACHE_DIR")
    if given:
        # A child process finds the folder that its parent chose.
        folder = Path(given) if Path(given).name == key else Path(given) / key
        folder.mkdir(parents=True, exist_ok=True)
    else:
        folder = _in_users_cache(key) or _in_temporary(key)
    os.environ["NUMBA_CACHE_DIR"] = str(folder)
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = str(folder)
    return folder


def _in_users_cache(key):
    base = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    folder = Path(base) / "peg_on_hole_ros" / key
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK | os.X_OK) else None


def _in_temporary(key):
    # What lies here is run as code: others must not have made the folder or write in it.
    root = Path(tempfile.gettempdir()) / f"peg_on_hole_ros_{os.getuid()}"
    try:
        root.mkdir(mode=0o700, exist_ok=True)
        found = root.lstat()
        if stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid():
            root.chmod(0o700)
            (root / key).mkdir(exist_ok=True)
            return root / key
    except OSError:
        pass
    return Path(tempfile.mkdtemp(prefix="peg_on_hole_ros_"))
