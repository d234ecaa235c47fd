"""The one harness: members run once, their figures are kept, and tables go into pages."""

from dataclasses import replace

import numpy as np
import pytest

import benchmarks.families
from benchmarks.__main__ import main, parser_of
from benchmarks.families import FAMILIES, family_of
from benchmarks.harness import runner
from benchmarks.harness.errors import coverage
from benchmarks.harness.family import Family, Member, Report
from benchmarks.harness.player import Record
from benchmarks.harness.tables import put_between, table
from simulated import ROOT


def number(value, seeds=1):
    return Member(f"number/{value}", value, seeds)


COMPUTED: list[int] = []


def squared(member, folder):
    COMPUTED.append(member.of)
    return {"square": member.of**2 * member.seeds}


def of_squares(found, options):
    rows = [(member.of, tree["square"]) for member, tree in found]
    wrong = [f"{value} is odd" for value, _ in rows if value % 2]
    return Report(table(("n", "square"), rows), {"squares": rows}, problems=wrong)


@pytest.fixture
def squares(monkeypatch):
    """A family of made-up members, in the place of another."""
    family = Family(
        lambda options: [number(value, options.seeds) for value in options.values],
        squared,
        of_squares,
        lambda parser: parser.add_argument("--values", type=int, nargs="+", default=[2, 4]),
        lambda options: "too many" if len(options.values) > 5 else "",
        seeds=3,
    )
    monkeypatch.setattr(runner, "family_of", lambda name: family)
    monkeypatch.setattr("benchmarks.__main__.family_of", lambda name: family)
    COMPUTED.clear()
    return family


@pytest.mark.parametrize("name", FAMILIES)
def test_every_family_states_members_that_are_named_apart(name):
    family = family_of(name)
    members = family.members(parser_of(name).parse_args([]))
    assert len(members) == len({str(member) for member in members}) > 0
    store = runner.Kept(name, runner.Path())
    files = {store.file(member) for member in members}
    assert len(files) == len(members), "the figures of one would overwrite another's"
    asked = store.asked(members[0])
    assert len(asked["key"]) == 16 and asked != store.asked(members[-1])


def test_members_run_once_and_again_for_other_settings(squares, tmp_path, capsys):
    arguments = ["grid", "--workers", "1", "--out", str(tmp_path)]
    assert main(arguments) == 0 and sorted(COMPUTED) == [2, 4]
    assert "| 2 | 12 |\n| 4 | 48 |" in capsys.readouterr().out
    assert (tmp_path / "squares.csv").read_text().split() == ["2,12", "4,48"]
    assert main(arguments) == 0 and sorted(COMPUTED) == [2, 4]
    assert main([*arguments, "--seeds", "1"]) == 0 and sorted(COMPUTED) == [2, 2, 4, 4]
    assert "| 4 | 16 |" in (tmp_path / "grid.md").read_text()
    # What is not there is not computed when only a summary is asked for.
    capsys.readouterr()
    assert main([*arguments, "--seeds", "1", "--values", "4", "6", "--summary"]) == 0
    assert "| 6 |" not in capsys.readouterr().out and 6 not in COMPUTED
    with pytest.raises(SystemExit):
        main([*arguments, "--values", "8", "--summary"])


def test_some_members_are_chosen_by_their_names(squares, tmp_path, capsys):
    arguments = ["grid", "--workers", "1", "--out", str(tmp_path)]
    assert main([*arguments, "--only", "number/4", "/6"]) == 0 and COMPUTED == [4]
    with pytest.raises(SystemExit):
        main([*arguments, "--only", "/8", "/9"])
    assert "no member's name holds /8 or /9" in capsys.readouterr().err


def test_another_checkout_has_figures_of_its_own(squares, tmp_path, capsys, monkeypatch):
    arguments = ["grid", "--workers", "1", "--out", str(tmp_path), "--values", "2"]
    monkeypatch.setattr(
        "benchmarks.__main__.family_of", lambda name: replace(squares, against=True)
    )
    with pytest.raises(SystemExit):
        main([*arguments, "--against", str(tmp_path)])
    assert "no folder peg_on_hole_ros there" in capsys.readouterr().err
    assert main([*arguments, "--against", str(ROOT)]) == 0 and COMPUTED == [2, 2]
    names = sorted(path.name for path in (tmp_path / "runs").iterdir())
    assert names == ["number_2.json", "number_2_other.json"]


def test_figures_of_other_sources_are_not_taken(squares, tmp_path, monkeypatch):
    runner.run("grid", [number(2)], tmp_path)
    monkeypatch.setattr(runner, "sources_key", lambda *given: "of other sources")
    runner.run("grid", [number(2)], tmp_path)
    assert COMPUTED == [2, 2]


def test_problems_and_wrong_options_end_with_an_error(squares, tmp_path, capsys):
    arguments = ["grid", "--workers", "1", "--out", str(tmp_path)]
    assert main([*arguments, "--values", "2", "3"]) == 1
    assert capsys.readouterr().out.endswith("3 is odd\n")
    with pytest.raises(SystemExit):
        main([*arguments, "--values", *"123456"])
    assert "too many" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["no_family"])


def test_tables_go_between_the_marks_of_a_page(tmp_path):
    assert table(("a", ""), [(1, ""), ("x", 2.5)]) == "| a | |\n|---|---|\n| 1 | |\n| x | 2.5 |"
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- a -->\nold\n<!-- end of a -->\nafter\n")
    put_between(page, "a", "new")
    assert page.read_text() == "before\n<!-- a -->\n\nnew\n\n<!-- end of a -->\nafter\n"
    with pytest.raises(ValueError, match="put both where the text shall be"):
        put_between(page, "b", "new")


def test_errors_come_to_shares_within_their_bounds():
    error, stddev = np.array([[1.0, 2.0], [-1.0, -2.0]]), np.array([[1.0, 1.0], [1.0, 3.0]])
    found = coverage(error, stddev)
    assert found.rms.tolist() == [1.0, 2.0] and found.covered.tolist() == [1.0, 0.5]
    assert found.stated == pytest.approx([1.0, 5.0**0.5])
    assert np.isnan(coverage(error[:0], stddev[:0]).covered).all()


def test_a_record_has_a_row_for_each_stamp_of_a_truth():
    t_ns = np.arange(4) * 10
    record = Record(
        np.array([110, 130]), np.ones((2, 6)), np.ones((2, 6, 6)), np.ones((2, 3)),
        np.ones((2, 3)), np.array(["open", "open"]), np.array([True, False]),
        {"jamming": np.array([2, 1])}, {"reactions_determined": np.array([1.0, 0.0])},
    ).rows_at(t_ns, 100)  # fmt: skip
    assert record.mode.tolist() == ["", "open", "", "open"]
    assert record.alarms["jamming"].tolist() == [0, 2, 0, 1]
    assert record.flag.tolist() == [False, True, False, False]
    assert record.determined.tolist() == [False, True, False, False]
    assert np.isnan(record.state[[0, 2]]).all() and (record.state[[1, 3]] == 1.0).all()


def test_the_table_of_families_is_what_is_documented():
    text = (runner.Path(benchmarks.families.__file__).parent / "README.md").read_text()
    assert all(f"`{name}`" in text for name in FAMILIES)
