"""
Draw mutants of the package, and tell which of them no test notices.

    python -m benchmarks.mutations [--part monitor engine estimator] [--count 20] [--seed 2]
        [--minutes MINUTES] [--only TEXT] --out DIR

All mutants of a part stand in one copy of the checkout, each behind a switch, so they are compiled
once (`copies`). For each the tests run that run at every push, those of its room first, until one
fails; then the nightly ones of its room. What a test finds is counted only where the test passes
with no mutant on. Results are kept in DIR/PART.csv: a run that was stopped goes on. `--only` tries
those anew whose name contains a text. Ends with 1 where fewer than LEAST are noticed; survivors in
`judged.JUDGED` do not count.
"""

import argparse
import csv
import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from math import inf
from pathlib import Path
from threading import Lock

from scipy.stats import binomtest

from benchmarks.mutations.copies import Copy
from benchmarks.mutations.draw import ROOT, Mutant, drawn
from benchmarks.mutations.judged import JUDGED

# The room's tests, and those of its neighbours.
TESTS = {
    "monitor": (["test/monitor"], ["test/engine", "test/replay", "test/messages"]),
    "engine": (["test/engine"], ["test/replay", "test/monitor", "test/messages", "test/bags"]),
    "estimator": (["test/estimator"], ["test/monitor", "test/measurements", "test/engine"]),
    "mechanics": (["test/mechanics"], ["test/estimator", "test/sim"]),
}
LEAST = 0.9
PROCESSES = 2
# What runs for longer does not end [s].
TIMEOUT = 1800.0
PYTEST = [sys.executable, "-m", "pytest", "-q", "-x", "-n", "0", "-p", "no:cacheprovider"]
FELL = re.compile(r"^(?:FAILED|ERROR) (\S+)", re.M)
COLUMNS = [*Mutant._fields, "killed_by", "seconds"]


def in_order(places: list[str], mutant: Mutant) -> list[str]:
    """Return the files of tests, those first that name a module most often for their length."""
    module = Path(mutant.path)
    words = (mutant.function.split(".")[-1].strip("_"), module.stem)

    def named(file):
        text = file.read_text(encoding="utf-8")
        return [-len(re.findall(rf"\b{word}\b", text)) / len(text) for word in words]

    files = [file for place in places for file in (ROOT / place).rglob("test_*.py")]
    return [str(file.relative_to(ROOT)) for file in sorted(files, key=named)]


class Trials:
    """Tests run over the mutants of one copy."""

    def __init__(self, copy: Copy, part: str):
        self.copy, self.room, self.neighbours = copy, *TESTS[part]
        # Tests that pass and that fall with no mutant on.
        self.sound, self.fell_anyway = set(), set()
        self.lock = Lock()

    def killer(self, number: int) -> str:
        """Return the test that notices a mutant, empty where none does."""
        mutant = self.copy.mutants[number - 1]
        rooms = in_order(self.room, mutant)
        at_push = [*rooms, *in_order(self.neighbours, mutant)]
        return self._first(number, "not nightly", at_push) or self._first(number, "nightly", rooms)

    def _first(self, number, marks, tests):
        while True:
            left_out = [f"--deselect={test}" for test in sorted(self.fell_anyway)]
            try:
                done = self.copy.run(number, [*PYTEST, "-m", marks, *left_out, *tests], TIMEOUT)
            except subprocess.TimeoutExpired:
                return f"does not end ({marks})"
            if done.returncode in (0, 5):
                return ""
            found = FELL.search(done.stdout)
            if not found:
                return f"ended with {done.returncode}"
            if self._passes(found[1]):
                return found[1]

    def _passes(self, test):
        with self.lock:
            if test not in self.sound | self.fell_anyway:
                command = [*PYTEST, "-m", "nightly or not nightly", test]
                done = self.copy.run(0, command, TIMEOUT)
                (self.fell_anyway if done.returncode else self.sound).add(test)
                if done.returncode:
                    print(f"falls with no mutant on: {test}", flush=True)
            return test in self.sound


def read(path: Path) -> dict[str, str]:
    """Return who killed each mutant, by name, from a table of results."""
    if not path.exists():
        return {}
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    names = (
        str(Mutant(*(row[k] for k in Mutant._fields[:-1]), int(row["which"]))) for row in rows
    )
    return {name: row["killed_by"] for name, row in zip(names, rows)}


def run(part: str, options) -> tuple[list[Mutant], dict[str, str]]:
    """Try all mutants of a part, and return them and who killed each."""
    end = time.monotonic() + 60.0 * options.minutes
    path = options.out / f"{part}.csv"
    # Some cannot be compiled.
    copy = Copy(options.out / part, drawn(part, options.seed, options.count))
    copy.make()
    trials, results, lock = Trials(copy, part), read(path), Lock()

    def try_one(number):
        mutant, begin = copy.mutants[number - 1], time.monotonic()
        asked = options.only in str(mutant) if options.only else str(mutant) not in results
        if not asked or begin > end:
            return
        killer = trials.killer(number)
        seconds = time.monotonic() - begin
        print(f"{part} {number} {seconds:.0f} s {mutant}: {killer or 'SURVIVED'}", flush=True)
        with lock:
            results[str(mutant)] = killer
            new = not path.exists()
            with path.open("a", encoding="utf-8", newline="") as file:
                writer = csv.writer(file)
                if new:
                    writer.writerow(COLUMNS)
                writer.writerow([*mutant, killer, round(seconds)])

    with ThreadPoolExecutor(PROCESSES) as pool:
        list(pool.map(try_one, range(1, len(copy.mutants) + 1)))
    return copy.mutants, results


def main(arguments=None) -> int:
    """Run and print the share that is noticed, and the survivors."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--part", nargs="+", choices=list(TESTS), default=list(TESTS))
    parser.add_argument("--count", type=int, default=20, help="mutants of each part (20)")
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument(
        "--minutes", type=float, default=inf, help="begin none of a part after so long"
    )
    parser.add_argument("--only", help="try anew those whose name contains this")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    enough = True
    for part in options.part:
        mutants, results = run(part, options)
        counted = [m for m in map(str, mutants) if m in results and m not in JUDGED]
        if not counted:
            print(f"{part}: none was tried")
            enough = False
            continue
        found = binomtest(sum(bool(results[m]) for m in counted), len(counted))
        share, sure = found.statistic, found.proportion_ci(method="wilson")
        enough &= share >= LEAST
        between = f"95 % interval {sure.low:.0%} to {sure.high:.0%}"
        print(f"{part}: {share:.0%} of {len(counted)} mutants noticed ({between}); not noticed:")
        print(*(f"  {m}" for m in counted if not results[m]), sep="\n")
    return int(not enough)


if __name__ == "__main__":
    sys.exit(main())
