"""One bag among many: replayed by whoever has time for it, or found to be done."""

import hashlib
import json
import threading
from contextlib import redirect_stderr
from functools import cache
from io import StringIO
from pathlib import Path
from typing import NamedTuple

from peg_on_hole_ros import __version__
from peg_on_hole_ros.bags.storage.bag_files import bag_files
from peg_on_hole_ros.cli.bag_and_configuration import Reading, open_recording
from peg_on_hole_ros.cli.many_bags.which_bags import RESULT
from peg_on_hole_ros.cli.output_paths import write_text
from peg_on_hole_ros.cli.replay import replay
from peg_on_hole_ros.cli.table import to_json
from peg_on_hole_ros.errors import BagDamaged, BagError
from peg_on_hole_ros.numba_cache import PACKAGE_FOLDER
from peg_on_hole_ros.report.provenance import hash_file
from peg_on_hole_ros.safe_text import printable
from peg_on_hole_ros.startup.exit_codes import exit_code_and_text

SUMMARY, REPORT, ESTIMATE = "summary.json", "report.html", "estimate.mcap"
# A bag that cannot be read stays so; what went wrong otherwise may have been the machine's.
_FINAL = (0, BagError.exit_code, BagDamaged.exit_code)
# A cluster's worker may have several threads, and errors of a process are one stream.
_ONE_AT_A_TIME = threading.Lock()


class Task(NamedTuple):
    """
    A bag to be replayed; it can go to another process or machine that has the same folders.

    Attributes
    ----------
    path : Path
        Of the bag, as it was given.
    bag : Path
        The same, absolute.
    folder : Path
        For its results, absolute.
    settings : str
        Hash of all that the result depends on beside the bag.
    config : str or None
        Configuration, absolute.
    reading : Reading
    report, estimate : bool
        What is written beside the summary.

    """

    path: Path
    bag: Path
    folder: Path
    settings: str
    config: str | None
    reading: Reading
    report: bool
    estimate: bool

    @property
    def name(self) -> str:
        """Return the name of the folder."""
        return self.folder.name


def work(task: Task) -> dict:
    """
    Replay a bag, or find it done; return its result, ready for JSON.

    Nothing that is wrong with a bag is raised: it is `exit_code` and `error` of the result. The
    result is written last, so what was broken off is done anew.
    """
    with _ONE_AT_A_TIME, redirect_stderr(StringIO()) as told:
        key = None
        try:
            task.folder.mkdir(parents=True, exist_ok=True)
            key = {"bag": _hash_of_bag(task.bag), "settings": task.settings}
            before = _done(task, key)
            if before is not None:
                return before | {"path": printable(task.path), "done_before": True}
            found = _replayed(task)
        except Exception as error:
            code, text = exit_code_and_text(error)
            found = {"exit_code": code, "error": printable(text)}
    # Of many bags each says what is usual.
    usual = printable(f"configuration: that in {task.bag}")
    notes = [line for line in told.getvalue().splitlines() if line and line != usual]
    result = failed(task, 0, None) | found | {"key": key, "notes": notes}
    if key is not None and result["exit_code"] in _FINAL:
        write_text(task.folder / RESULT, to_json(result) + "\n")
    return result


def failed(task: Task, code: int, error: str | None) -> dict:
    """Return the result of a bag of which nothing but an error is known."""
    return {
        "path": printable(task.path),
        "name": task.name,
        "exit_code": code,
        "error": error,
        "summary": None,
        "doubts": [],
        "files": [],
        "key": None,
        "notes": [],
        "done_before": False,
    }


def settings_hash(*parts: object) -> str:
    """Return a hash of what results depend on: parts that print alike, and this program."""
    digest = hashlib.sha256(f"{__version__} {_program()} {parts!r}".encode())
    return digest.hexdigest()


@cache
def _program():
    digest = hashlib.sha256()
    for path in sorted(PACKAGE_FOLDER.rglob("*")):
        if path.suffix in (".py", ".js", ".css"):
            digest.update(path.relative_to(PACKAGE_FOLDER).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()


def _hash_of_bag(path):
    found = bag_files(path)
    digest = hashlib.sha256()
    for file in found.read():
        if not file.is_file():
            continue
        digest.update(file.name.encode("utf-8", "surrogateescape") + b"\0")
        hash_file(digest, file)
    return digest.hexdigest()


def _done(task, key):
    """Return the result that is there, if it is that of this bag and these settings, whole."""
    try:
        before = json.loads((task.folder / RESULT).read_text(encoding="utf-8"))
        same = before["key"] == key and all(
            (task.folder / name).is_file() for name in before["files"]
        )
    except (OSError, ValueError, TypeError, KeyError):
        return None
    # A file that the bag itself names is not part of the hash.
    return before if same and not task.reading.any_urdf else None


def _replayed(task):
    report = task.folder / REPORT if task.report else None
    estimate = task.folder / ESTIMATE if task.estimate else None
    bag, configuration, node, _ = open_recording(
        str(task.bag), task.config, [estimate and str(estimate)], (), task.reading
    )
    summary, _, doubts, no_page = replay(bag, configuration, node, estimate, report)
    if no_page is not None:
        raise no_page
    # What differs from run to run is no result.
    summary = summary | {"bag": printable(task.path), "realtime_factor": None}
    write_text(task.folder / SUMMARY, to_json(summary) + "\n")
    damage = BagDamaged(bag.damage) if bag.damage else None
    return {
        "exit_code": damage.exit_code if damage else 0,
        "error": printable(damage) if damage else None,
        "summary": summary,
        "doubts": list(map(printable, doubts)),
        "files": [SUMMARY, *([REPORT] if report else []), *([ESTIMATE] if estimate else [])],
    }
