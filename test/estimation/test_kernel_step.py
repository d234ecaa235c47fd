"""The benchmark of a filter step runs, and writes what it prints."""

import csv

import pytest

import kernel_step


@pytest.mark.xdist_group("filterpy")
def test_every_way_is_timed_printed_and_written(tmp_path, capsys):
    path = tmp_path / "steps.csv"
    assert kernel_step.main(["--repetitions", "1", "--csv", str(path)]) == 0
    with path.open(newline="") as file:
        rows = {row["way"]: row for row in csv.DictReader(file)}
    assert list(rows) == list(kernel_step.WAYS)
    text = capsys.readouterr().out
    for row in rows.values():
        assert row["median_us"] in text
        assert 0 < float(row["least_us"]) <= float(row["median_us"])
        ratio = float(rows["filterpy"]["median_us"]) / float(row["median_us"])
        assert float(row["filterpy_over_this"]) == pytest.approx(ratio, rel=0.1)
