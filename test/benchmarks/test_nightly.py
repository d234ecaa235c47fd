"""What runs at night: a table of what fell, mutations of one change each, and a short hour."""

import importlib.util

import pytest

from benchmarks import mutations
from benchmarks.cost.hour import hour
from benchmarks.mutations import Mutation, mutated, sites
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


@pytest.mark.parametrize(
    ("line", "kind", "becomes"),
    [
        ("x = a * b", "swap", "x = a / b"),
        ("x = a * b", "drop", "x = a"),
        ("x = 0.5", "times", "x = 5.0"),
        ("x = a <= b", "swap", "x = a > b"),
        ("x = a and b", "drop", "x = a"),
        ("x = a and b", "swap", "x = a or b"),
    ],
)
def test_a_mutation_is_one_change(line, kind, becomes):
    assert mutated(f"y = 1\n{line}\n", Mutation("a.py", 2, 4, kind)) == f"y = 1\n{becomes}"


def test_every_place_has_its_mutations_and_each_changes_something():
    path = ROOT / mutations.PACKAGE / "monitor" / "jamming.py"
    found, text = sites(path), path.read_text(encoding="utf-8")
    assert len(found) > 100 and {m.kind for m in found} == {"swap", "drop", "times"}
    assert len({mutated(text, m) for m in found[:40]} - {text}) == 40


@pytest.mark.nightly
def test_a_minute_leaves_all_as_it_was():
    found = hour(60.0)
    assert found.sound and found.rounds >= 4 and found.pivot < 1.0
