"""The benchmark of the pipeline's cost runs, and its parts make up the whole."""

import csv

import pytest

import pipeline_cost as cost


def test_every_part_and_variant_is_timed_printed_and_written(tmp_path, capsys):
    path = tmp_path / "cost.csv"
    assert cost.main(["--repetitions", "1", "--csv", str(path)]) == 0
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    text = capsys.readouterr().out
    assert all(row["median_us"] in text and row["name"] in text for row in rows)
    variants = [row["name"] for row in rows if row["kind"] == "variant"]
    assert variants == [cost.ALL, cost.NONE_LATE, cost.NO_MODES, cost.NEITHER]
    parts = {row["name"]: float(row["share"]) for row in rows if row["kind"] == "part"}
    assert set(parts) == {
        cost.ESTIMATE, cost.FILTER, cost.JUDGE, cost.DECLARE, cost.OUTPUTS, cost.INPUT, cost.LATE,
        cost.REST,
    }  # fmt: skip
    assert all(share > 0 for share in parts.values())
    assert sum(parts.values()) == pytest.approx(1.0, abs=0.005)


def test_a_part_is_timed_without_the_parts_that_it_calls():
    parts = cost.Parts()
    inner = parts.timing(lambda: sum(range(200_000)), "inner")
    outer = parts.timing(lambda: inner(), "outer")
    outer()
    assert 0 < parts.spent["outer"] < parts.spent["inner"]
