"""A copy of the checkout in which all mutants of a draw stand at once, compiled once."""

import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.harness.copied import CheckoutCopy
from benchmarks.mutations.draw import SWITCH, Mutant, switched
from benchmarks.mutations.switch import VARIABLE

FROM_COMPILER = re.compile(rf"{SWITCH}\(\) == (\d+)")


class Copy(CheckoutCopy):
    """A copy with all mutants."""

    def __init__(self, folder: Path, mutants: Sequence[Mutant]):
        super().__init__(folder)
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
        environment = {**self.environment(), VARIABLE: str(number)}
        return subprocess.run(
            command, cwd=self.checkout, env=environment, timeout=timeout, text=True,
            errors="replace", stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip

    def write(self) -> None:
        """Write the copy with the mutants, each behind its switch."""
        self.copy()
        shutil.copy2(Path(__file__).with_name("switch.py"), self.place(f"{SWITCH}_switch.py"))
        numbers = {mutant: k for k, mutant in enumerate(self.mutants, 1)}
        for name in {mutant.path for mutant in self.mutants}:
            text = self.place(name).read_text(encoding="utf-8")
            self.edit(name, switched(name, text, numbers.get))
