"""Each rule can be switched off by the sources as they are, and what that does is told."""

import ast
from pathlib import Path

import pytest

import peg_on_hole_ros
from grid_cells import Motion
from rules import RULES
from rules_off import PROMISES, copy_without, switched_off, table

PACKAGE = Path(peg_on_hole_ros.__file__).parent


@pytest.mark.parametrize("name", [name for name in RULES if RULES[name].file])
def test_a_rule_is_switched_off_by_one_place_of_a_source(name):
    text = (PACKAGE / RULES[name].file).read_text(encoding="utf-8")
    without = switched_off(text, RULES[name])
    assert ast.dump(ast.parse(without)) != ast.dump(ast.parse(text))


def test_a_rule_that_is_no_longer_there_is_an_error():
    with pytest.raises(ValueError, match=r"bridging.py has 0 times: 'GROWS = 0.8'"):
        switched_off("GROWS = 0.9", RULES["growth"])


def test_a_copy_is_the_package_but_for_the_rule(tmp_path):
    copy_without("growth", tmp_path / "copy")
    sources = {path.relative_to(PACKAGE) for path in PACKAGE.rglob("*.py")}
    copied = tmp_path / "copy" / PACKAGE.name
    assert {path.relative_to(copied) for path in copied.rglob("*.py")} == sources
    changed = [p for p in sources if (copied / p).read_bytes() != (PACKAGE / p).read_bytes()]
    assert [path.as_posix() for path in changed] == [RULES["growth"].file]


def cell(coverage, rms):
    figures = {
        "ratio": [1.0] * 9, "ratio_error": [0.1] * 9, "coverage": [coverage] * 9,
        "coverage_error": [0.01] * 9, "nees_median": 6.0, "nees_error": 0.1, "rms": rms,
    }  # fmt: skip
    return {
        "motion": Motion(1e-4, 0.2, 0.16, "slip")._asdict(), "noise": "low", "end": "",
        "seeds": 4, "nis": 3.0, "nis_error": 0.1, "diverged": 0, "start_diverged": 0,
        "classes": {"outside": figures},
    }  # fmt: skip


def test_what_a_rule_earns_is_kept_promises_and_errors_over_those_of_all():
    all_rules = [cell(0.95, [1.0] * 9), cell(0.95, [2.0] * 9)]
    without = [cell(0.95, [1.0] * 9), cell(0.90, [*[2.0] * 3, *[4.0] * 3, *[1.0] * 3])]
    head, _, as_is, off = table({"all": all_rules, "growth": without})
    names = [name.strip() for name in head.strip("|").split("|")]
    assert names[1 : 1 + len(PROMISES)] == list(PROMISES)
    cells = dict(zip(names, (text.strip() for text in off.strip("|").split("|")), strict=True))
    assert cells["without"] == "growth: the least walk grows with the rates"
    assert cells["cells near the bound: states; reactions"] == "2; 2"
    assert cells["covered: states; reactions"] == "1; 1"
    # In one cell twice as far off, in the other as before.
    assert cells["errors of rates: outside; in windows"] == "1.41 (1 to 2)"
    assert cells["errors of reactions: outside; in windows"] == "0.71 (0.5 to 1)"
    assert as_is.count("1.00 (1 to 1)") == 2
