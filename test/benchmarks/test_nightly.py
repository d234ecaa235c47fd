"""What runs at night: a table of what fell, and a short hour."""

import importlib.util

import pytest

from benchmarks.cost.hour import hour
from simulated import ROOT

SPEC = importlib.util.spec_from_file_location("nightly", ROOT / "tools" / "nightly.py")
nightly = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(nightly)


def test_what_fell_is_in_the_table_and_the_exit_code(tmp_path, monkeypatch, capsys):
    parts = {
        "tests": ["echo", "all | well"],
        "hour": ["sh", "-c", "echo it grew; exit 3"],
    }
    monkeypatch.setattr(nightly, "parts", lambda seconds, out: parts)
    assert nightly.main(["--out", str(tmp_path)]) == 1
    table = (tmp_path / "table.md").read_text(encoding="utf-8")
    assert "| tests | held | 0.0 | all / well |" in table
    assert "| hour | **fell, exit code 3** | 0.0 | it grew |" in table
    assert (tmp_path / "hour.txt").read_text() == "it grew\n" and table in capsys.readouterr().out
    assert nightly.main(["--out", str(tmp_path), "--only", "tests"]) == 0


@pytest.mark.nightly
def test_a_minute_leaves_all_as_it_was():
    found = hour(60.0)
    assert found.sound and found.rounds >= 4 and found.pivot < 1.0
