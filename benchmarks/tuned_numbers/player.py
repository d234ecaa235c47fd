"""
Play scenes in a copy of the package whose tuned numbers lie in memory, with one of them changed.

As a program (`python -P -m benchmarks.tuned_numbers.player FOLDER`) it answers requests, a line of
JSON each on standard input, on standard output. `Beside` makes the copy, and asks.
"""

import importlib
import json
import os
import pkgutil
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.harness.copied import ROOT, CheckoutCopy
from benchmarks.harness.runner import sources_key
from peg_on_hole_ros.numba_cache import PACKAGE_FOLDER
from peg_on_hole_ros.tuned_numbers import TunedNumber, listed, tuned_numbers

MEMORY = Path(__file__).with_name("memory.py")
STANDS_IN = """

import peg_on_hole_ros.tuned_memory as _memory  # noqa: E402

_memory.stand_in("{room}", globals())
"""
# With another value a scene may take so many times as long as with the shipped one [-], [s].
TIMES_LONGER, LONGER = 20.0, 20.0
# What becomes of a scene with another value.
AT_IMPORT, NOT_READ, SAME, CHANGED, RAISED, ENDED = OUTCOMES = (
    "read at import", "not read", "same", "changed", "raised", "ended",
)  # fmt: skip
# Rooms that only show what others compute, or that need what is not there.
NOT_IMPORTED = {"ros", "watch", "report", "plots", "startup", "cli"}


class Asked(NamedTuple):
    """
    A scene, and the number that is changed in it.

    Attributes
    ----------
    scene : str
    number : str
        As `tuned_numbers.listed` names it, an entry of several with its place in brackets; empty:
        all are as they are shipped.
    value : float or int

    """

    scene: str
    number: str = ""
    value: float = 0


def single_numbers() -> Iterator[tuple[str, float | int]]:
    """Yield name and value of each number, each entry of several by itself."""
    for each in listed(tuned_numbers()):
        yield from _entries(each)


def _entries(number: TunedNumber) -> Iterator[tuple[str, float | int]]:
    if isinstance(number.value, tuple):
        yield from ((f"{number.name}[{i}]", value) for i, value in enumerate(number.value))
    else:
        yield number.name, number.value


class Beside:
    """
    A process that plays scenes in the copy, begun anew where it has ended.

    Parameters
    ----------
    folder : Path
        Where the copy is, its compiled code, and what is simulated.

    """

    def __init__(self, folder: Path):
        self.folder = folder.resolve()
        self.copy = CheckoutCopy(self.folder / f"copy_{sources_key(('.',), (MEMORY,))}")
        if not self.copy.checkout.exists():
            self._write()
        self._process: subprocess.Popen | None = None

    def ask(self, asked: Asked) -> dict[str, Any]:
        """
        Return `outcome`, one of OUTCOMES, and with some of them `figures`, or what happened.

        Raises
        ------
        RuntimeError
            The process has ended with all numbers as they are shipped.

        """
        if self._process is None:
            self._process = self._begun()
        process = self._process
        for each in (asked._replace(number=""), asked):
            assert process.stdin is not None and process.stdout is not None
            process.stdin.write(json.dumps(each._asdict()) + "\n")
            process.stdin.flush()
            line = process.stdout.readline()
            if line:
                continue
            self.close()
            what = f"the process ended with {process.returncode}"
            if not each.number:
                raise RuntimeError(f"{each.scene}: {what}")
            return {"outcome": ENDED, "what": what}
        return json.loads(line)

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.communicate()
            self._process = None

    def _begun(self):
        path = os.pathsep.join((str(self.copy.checkout), str(ROOT)))
        return subprocess.Popen(
            [sys.executable, "-P", "-m", "benchmarks.tuned_numbers.player", str(self.folder)],
            env={**self.copy.environment(), "PYTHONPATH": path}, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )  # fmt: skip

    def _write(self):
        """Write the copy, whole or not at all: other processes may come to do so."""
        copy = CheckoutCopy(self.folder / f"partial_{os.getpid()}")
        copy.copy(PACKAGE_FOLDER.name)
        shutil.copy2(MEMORY, copy.place("tuned_memory.py"))
        for path in sorted(PACKAGE_FOLDER.glob("*/tuned.py")):
            text = path.read_text(encoding="utf-8") + STANDS_IN.format(room=path.parent.name)
            copy.edit(path.relative_to(PACKAGE_FOLDER).as_posix(), text)
        try:
            copy.checkout.parent.replace(self.copy.checkout.parent)
        except OSError:
            shutil.rmtree(copy.checkout.parent)


class Player:
    """What plays scenes within the copy."""

    def __init__(self, folder: Path):
        self.memory: Any = importlib.import_module("peg_on_hole_ros.tuned_memory")
        self.scenes: Any = importlib.import_module("benchmarks.tuned_numbers.scenes")
        for room in pkgutil.iter_modules([str(PACKAGE_FOLDER)]):
            if room.ispkg and room.name not in NOT_IMPORTED:
                within = [str(PACKAGE_FOLDER / room.name)]
                for each in pkgutil.walk_packages(within, f"{PACKAGE_FOLDER.name}.{room.name}."):
                    importlib.import_module(each.name)
        self.at_import = self.memory.read_since()
        self.folder, self.shipped = folder, dict(single_numbers())
        self.several = {each.name: each.value for each in listed(tuned_numbers())}
        self._as_shipped = cache(self._twice)

    def answer(self, asked: Asked) -> dict[str, Any]:
        """Return what becomes of a scene, with a number changed."""
        name = asked.number.partition("[")[0]
        if name in self.at_import:
            return {"outcome": AT_IMPORT}
        came, read, seconds = self._as_shipped(asked.scene)
        if not asked.number:
            return {"outcome": SAME, **came._asdict()}
        if name not in read and not name.startswith("settings."):
            return {"outcome": NOT_READ}
        self._set(asked.number, asked.value)
        # Time of the process: by default the signal ends it, within compiled code too.
        signal.setitimer(signal.ITIMER_VIRTUAL, LONGER + TIMES_LONGER * seconds)
        try:
            changed = self.scenes.came_of(asked.scene, self.folder)
        except Exception as error:  # noqa: BLE001
            return {"outcome": RAISED, "what": f"{type(error).__name__}: {error}"}
        finally:
            signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
            self._set(asked.number, self.shipped[asked.number])
        same = changed.digest == came.digest
        return {"outcome": SAME if same else CHANGED, **changed._asdict()}

    def _twice(self, scene):
        """Return what comes of a scene as shipped, which numbers were read, how long it took."""
        self.memory.read_since()
        came = self.scenes.came_of(scene, self.folder)
        begin = time.process_time()
        again = self.scenes.came_of(scene, self.folder)
        seconds = time.process_time() - begin
        if again.digest != came.digest:
            raise RuntimeError(f"{scene}: played twice, it is not the same bit for bit")
        return came, self.memory.read_since(), seconds

    def _set(self, number, value):
        name, _, place = number.partition("[")
        record, _, field = name.rpartition(".")
        if place:
            several = list(self.several[name])
            several[int(place[:-1])] = value
            value = tuple(several)
        settings: Any = importlib.import_module("peg_on_hole_ros.estimator.settings")
        if record != "settings":
            setattr(self.memory.STANDING_IN[record], field, value)
        elif place:
            settings._OF_MODES[field] = value
        else:
            setattr(settings.Settings, field, value)


def _serve(folder):
    # What the package prints is no answer.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    player = Player(folder)
    for line in sys.stdin:
        answers.write(json.dumps(player.answer(Asked(**json.loads(line)))) + "\n")
        answers.flush()


if __name__ == "__main__":
    _serve(Path(sys.argv[1]))
