"""Whatever a copy of a bag has suffered, every command ends as documented, soon and in bounds."""

import re
import subprocess
import sys

import numpy as np
import pytest

from benchmarks.mutated_bags import KINDS, Outcome
from peg_on_hole_ros.bags.score import ErrorSums
from simulated import ROOT


@pytest.mark.nightly
@pytest.mark.parametrize("count", [len(KINDS), 5 * len(KINDS)])
def test_damaged_copies_end_as_documented(count):
    command = [sys.executable, "-m", "benchmarks.mutated_bags", "--count", str(count)]
    # Other damage than that of the published figures.
    run = subprocess.run([*command, "--seed", "1001"], cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    *_, last = run.stdout.splitlines()
    assert last == f"{count} copies, 0 faults, 0 losses that were not told"
    head, *rows = re.findall(r"^\| (\w+) \| (\d+) \| \d+ \| (\d+) \| (\d+) \|", run.stdout, re.M)
    assert head == ("damage", "0", "3", "4") and [kind for kind, *_ in rows] == list(KINDS)
    # The damage is one: most of it is found, and much of it leaves something to be read.
    sound, unreadable, cut_short = (sum(int(row[i]) for row in rows) for i in (1, 2, 3))
    assert cut_short > sound and sound + unreadable + cut_short > count


def test_what_counts_as_a_fault():
    error = "peg-on-hole: error: a is damaged\n"
    assert not Outcome(0, 0.1, 10**8, "configuration: that in a\n").fault()
    assert not Outcome(3, 0.1, 10**8, error).fault()
    for outcome in (
        Outcome(70, 0.1, 10**8, error),
        Outcome(-9, 0.1, 10**8, ""),
        Outcome(3, 0.1, 10**8, ""),
        Outcome(3, 0.1, 10**8, 2 * error),
        Outcome(0, 0.1, 10**8, "Traceback (most recent call last):\n"),
        Outcome(4, 11.0, 10**8, error),
        Outcome(4, 0.1, 6 * 10**8, error),
    ):
        assert outcome.fault(), outcome


def test_a_truth_that_is_no_number_has_no_error():
    errors = ErrorSums()
    truth = np.array([0.3, np.nan, 0.0, np.inf, 1e200, 5.0])
    with np.errstate(over="ignore"):
        errors.count_in(np.ones(6, bool), truth, np.ones(6), truth)
    known = {name for name, value in errors.rmse().items() if value is not None}
    assert known == {"gamma", "phi", "B2"}
