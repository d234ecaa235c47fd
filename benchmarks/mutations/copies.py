"""A copy of the checkout in which all mutants of a draw stand at once, compiled once."""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.mutations.draw import PACKAGE, ROOT, SWITCH, Mutant, switched
from benchmarks.mutations.switch import VARIABLE

LEFT_OUT = shutil.ignore_patterns(".*", "out", "site", "__pycache__")
FROM_COMPILER = re.compile(rf"{SWITCH}\(\) == (\d+)")


class Copy:
    """
    A copy with all mutants, in a folder that is its own.

    Compiled code is kept beside it, and serves the next copy where nothing has changed.
    """

    def __init__(self, folder: Path, mutants: Sequence[Mutant]):
        self.checkout, self._compiled = (
            folder.resolve() / "checkout",
            folder.resolve() / "compiled",
        )
        self.mutants = list(mutants)

    def make(self) -> None:
        """Write the copy, and compile it; what cannot be compiled is taken out of the mutants."""
        while True:
            self.write()
            done = self.run(0, [sys.executable, "tools/compiled.py"], None)
            if done.returncode == 0:
                return
            bad = {int(found) for found in FROM_COMPILER.findall(done.stdout)}
            if not bad:
                raise RuntimeError(f"the copy does not compile:\n{done.stdout[-4000:]}")
            print("not compiled:", *(f"  {self.mutants[k - 1]}" for k in sorted(bad)), sep="\n")
            self.mutants = [m for k, m in enumerate(self.mutants, 1) if k not in bad]

    def run(self, number: int, command: list[str], timeout: float | None):
        """Run a command in the copy with a mutant on, 0 for none; all it prints is one text."""
        environment = {
            **os.environ,
            "PYTHONPATH": str(self.checkout),
            "NUMBA_CACHE_DIR": str(self._compiled),
            VARIABLE: str(number),
        }
        return subprocess.run(
            command, cwd=self.checkout, env=environment, timeout=timeout, text=True,
            errors="replace", stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip

    def write(self) -> None:
        """Write the copy with the mutants, each behind its switch."""
        shutil.rmtree(self.checkout, ignore_errors=True)
        shutil.copytree(ROOT, self.checkout, ignore=LEFT_OUT)
        shutil.copy2(Path(__file__).with_name("switch.py"), self._place(f"{SWITCH}_switch.py"))
        numbers = {mutant: k for k, mutant in enumerate(self.mutants, 1)}
        for name in {mutant.path for mutant in self.mutants}:
            path = self._place(name)
            times = path.stat().st_atime_ns, path.stat().st_mtime_ns
            text = switched(name, path.read_text(encoding="utf-8"), numbers.get)
            path.write_text(text, encoding="utf-8")
            # numba compiles anew what is younger.
            os.utime(path, ns=times)

    def _place(self, name):
        return self.checkout / PACKAGE / name
