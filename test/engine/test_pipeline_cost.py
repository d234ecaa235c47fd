"""The benchmark of the pipeline's cost runs, and its parts make up the whole."""

import csv
from itertools import count

import pytest

from benchmarks.cost import pipeline_cost as cost


@pytest.fixture
def ticking(monkeypatch):
    """Give a clock that goes on by a second a look: what is timed is then counted."""
    monkeypatch.setattr(cost, "perf_counter", count().__next__)


def test_every_part_and_variant_is_timed_printed_and_written(ticking, tmp_path, capsys):
    path = tmp_path / "cost.csv"
    assert cost.main(["--repetitions", "1", "--csv", str(path)]) == 0
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    text = capsys.readouterr().out
    assert all(row["median_us"] in text and row["name"] in text for row in rows)
    variants = [row["name"] for row in rows if row["kind"] == "variant"]
    assert variants == [cost.ALL, cost.NONE_LATE, cost.NO_MODES, cost.NEITHER]
    parts = {row["name"]: float(row["share"]) for row in rows if row["kind"] == "part"}
    assert set(parts) == {cost.ENGINE, cost.OUTPUTS, cost.INPUT, cost.REST}
    # The rest is what is left of the whole: below zero, where something is timed twice.
    assert all(share > 0 for share in parts.values())


def test_a_part_is_timed_without_the_parts_that_it_calls(ticking):
    parts = cost.Parts()
    inner = parts.timing(lambda: None, "inner")
    middle = parts.timing(lambda: (inner(), inner()), "middle")
    outer = parts.timing(lambda: (middle(), inner()), "outer")
    outer()
    # A look at begin and end of each of five calls: a tick from any look to the next, which is
    # the part's in whose call it goes by, so a call's own are one more than the calls in it.
    assert parts.spent == {"outer": 3, "middle": 3, "inner": 3}
    assert parts.spent.total() == 2 * 5 - 1


def test_what_no_part_takes_is_the_rest(ticking, monkeypatch):
    """Of a pipeline whose play is one call of one part, and nothing besides."""

    class Line:
        def __init__(self, configuration):
            self.work = lambda: None

        def play(self, samples):
            for _ in samples:
                self.work()
                yield None

    monkeypatch.setattr(cost, "Pipeline", Line)
    monkeypatch.setattr(cost, "timed", lambda line: [(line, "work", "work")])
    found = cost.in_parts(None, range(4))
    # Nine ticks: one within each call, one before, between and behind them.
    assert found == {"work": 4 / 4, cost.REST: 5 / 4}
