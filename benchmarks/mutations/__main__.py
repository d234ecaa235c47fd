"""
Draw mutants of the package, and tell which of them no test notices.

    python -m benchmarks.mutations [--part monitor engine estimator] [--count 20] [--seed 2]
        [--minutes MINUTES] [--only TEXT] --out DIR

All mutants of a part stand in one copy of the checkout, each behind a switch, so they are compiled
once (`copies`). Over each run the tests of its room that run at every push, until one fails; over
those that survive all these the neighbouring rooms' tests, then the nightly ones of the room. A
test that fails with no mutant on does not count. Results are kept in DIR/PART.csv: a run that was
stopped goes on. `--only` tries those anew whose name contains a text. Ends with 1 where fewer than
LEAST are noticed; survivors in `judged.JUDGED` do not count.
"""

import argparse
import csv
import re
import subprocess
import sys
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from math import inf
from pathlib import Path
from threading import Lock
from xml.etree import ElementTree

from scipy.stats import binomtest

from benchmarks.mutations.copies import Copy
from benchmarks.mutations.draw import Mutant, drawn
from benchmarks.mutations.judged import JUDGED

# The room's tests, and those of its neighbours.
TESTS = {
    "monitor": (["test/monitor"], ["test/engine", "test/replay", "test/messages"]),
    "engine": (
        ["test/engine"],
        ["test/diagnosis", "test/replay", "test/monitor", "test/messages", "test/bags"],
    ),
    "estimator": (["test/estimator"], ["test/monitor", "test/measurements", "test/engine"]),
    "mechanics": (["test/mechanics"], ["test/estimator", "test/sim"]),
}
LEAST = 0.9
PROCESSES = 2
# What runs for longer does not end [s].
TIMEOUT = 1800.0
PYTEST = [sys.executable, "-m", "pytest", "-q", "-x", "-n", "0", "-p", "no:cacheprovider"]
FELL = re.compile(r"^(?:FAILED|ERROR) (\S+)", re.M)
# What pytest ends with where nothing was chosen.
NO_TESTS = 5


class Trials:
    """Tests run over the mutants of one copy."""

    def __init__(self, copy: Copy, part: str):
        self.copy = copy
        room, neighbours = ([copy.checkout / place for place in places] for places in TESTS[part])
        # What is run: everything over all mutants before the next, which takes longer.
        self.stages = [(room, "not nightly"), (neighbours, "not nightly"), (room, "nightly")]
        # Tests that pass with no mutant on, those that do not, and what files take [s].
        self.sound, self.fell_anyway, self.seconds = set(), set(), Counter()
        self.lock = Lock()

    def measure(self) -> None:
        """Run the room's tests at every push with no mutant on, once for a folder."""
        places, marks = self.stages[0]
        report = self.copy.checkout.parent / "times.xml"
        if not report.exists():
            command = [each for each in PYTEST if each != "-x"]
            command += ["-m", marks, f"--junitxml={report}", *self._files(places)]
            self.copy.run(0, command, None)
        for case in ElementTree.parse(report).iter("testcase"):
            file = case.attrib["classname"].replace(".", "/") + ".py"
            self.seconds[file] += float(case.attrib["time"])
            fell = case.find("failure") is not None or case.find("error") is not None
            (self.fell_anyway if fell else self.sound).add(f"{file}::{case.attrib['name']}")

    def killer(self, number: int, stage: int) -> str:
        """Return the test of a stage that notices a mutant, empty where none does."""
        places, marks = self.stages[stage]
        tests = self._in_order(places, self.copy.mutants[number - 1])
        while True:
            left_out = [f"--deselect={test}" for test in sorted(self.fell_anyway)]
            try:
                done = self.copy.run(number, [*PYTEST, "-m", marks, *left_out, *tests], TIMEOUT)
            except subprocess.TimeoutExpired:
                return "does not end"
            if done.returncode in (0, NO_TESTS):
                return ""
            if done.returncode < 0:
                return f"ended by signal {-done.returncode}"
            found = FELL.search(done.stdout)
            if not found:
                raise RuntimeError(f"pytest ended with {done.returncode}:\n{done.stdout[-2000:]}")
            if self._passes(found[1]):
                return found[1]

    def _in_order(self, places, mutant):
        # Those that name the module first, then those that take little.
        module = Path(mutant.path)
        named = re.compile(rf"\b{module.parent.name}(\.| import .*\b){module.stem}\b")

        def rank(file):
            return not named.search((self.copy.checkout / file).read_text("utf-8")), self.seconds[
                file
            ]

        return sorted(self._files(places), key=rank)

    def _files(self, places):
        found = (file for place in places for file in sorted(place.rglob("test_*.py")))
        return [str(file.relative_to(self.copy.checkout)) for file in found]

    def _passes(self, test):
        with self.lock:
            if test not in self.sound | self.fell_anyway:
                command = [*PYTEST, "-m", "nightly or not nightly", test]
                fell = self.copy.run(0, command, TIMEOUT).returncode
                (self.fell_anyway if fell else self.sound).add(test)
            return test in self.sound


class Results:
    """Who killed each mutant, and the last stage that was run: a table in a file."""

    def __init__(self, path: Path):
        self.path, self.rows, self.lock = path, {}, Lock()
        if path.exists():
            with path.open(encoding="utf-8", newline="") as file:
                for row in csv.DictReader(file):
                    fields = [row[name] for name in Mutant._fields[:-1]]
                    mutant = Mutant(*fields, int(row["which"]))
                    self.rows[mutant] = int(row["stage"]), row["killed_by"]

    def put(self, mutant: Mutant, stage: int, killer: str) -> None:
        """Add what a stage found, and write the table."""
        with self.lock:
            self.rows[mutant] = stage, killer
            with self.path.open("w", encoding="utf-8", newline="") as file:
                writer = csv.writer(file, lineterminator="\n")
                writer.writerow([*Mutant._fields, "stage", "killed_by"])
                writer.writerows([*each, *found] for each, found in self.rows.items())

    def has(self, mutant: Mutant, stage: int) -> bool:
        """Return whether a mutant is killed, or has survived a stage."""
        last, killer = self.rows.get(mutant, (-1, ""))
        return bool(killer) or last >= stage


def run(part: str, options) -> dict[Mutant, str]:
    """Try the mutants of a part, and return who killed each."""
    end = time.monotonic() + 60.0 * options.minutes
    copy = Copy(options.out / part, drawn(part, options.seed, options.count))
    copy.make()
    trials, results = Trials(copy, part), Results(options.out / f"{part}.csv")
    trials.measure()
    for mutant in [each for each in copy.mutants if options.only and options.only in str(each)]:
        results.rows.pop(mutant, None)

    def try_one(number, stage):
        mutant, begin = copy.mutants[number - 1], time.monotonic()
        if results.has(mutant, stage) or begin > end:
            return
        killer = trials.killer(number, stage)
        results.put(mutant, stage, killer)
        took = time.monotonic() - begin
        print(f"{number} {stage} {took:.0f} s {mutant}: {killer or 'SURVIVED'}", flush=True)

    for stage in range(options.stages):
        with ThreadPoolExecutor(PROCESSES) as pool:
            list(pool.map(partial(try_one, stage=stage), range(1, len(copy.mutants) + 1)))
    return {each: results.rows[each][1] for each in copy.mutants if each in results.rows}


def main(arguments=None) -> int:
    """Run and print the share that is noticed, and the survivors."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--part", nargs="+", choices=list(TESTS), default=list(TESTS))
    parser.add_argument("--count", type=int, default=20, help="mutants of each part (20)")
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument(
        "--minutes", type=float, default=inf, help="begin none of a part after so long"
    )
    parser.add_argument(
        "--stages", type=int, default=3, help="of the three; 1 runs the room's tests at push alone"
    )
    parser.add_argument("--only", help="try anew those whose name contains this")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    enough = True
    for part in options.part:
        results = run(part, options)
        counted = {str(m): killer for m, killer in results.items() if str(m) not in JUDGED}
        if not counted:
            print(f"{part}: none was tried")
            enough = False
            continue
        found = binomtest(sum(map(bool, counted.values())), len(counted))
        share, sure = found.statistic, found.proportion_ci(method="wilson")
        enough &= share >= LEAST
        between = f"95 % interval {sure.low:.0%} to {sure.high:.0%}"
        print(f"{part}: {share:.0%} of {len(counted)} mutants noticed ({between}); not noticed:")
        print(*(f"  {m}" for m, killer in counted.items() if not killer), sep="\n")
    return int(not enough)


if __name__ == "__main__":
    sys.exit(main())
