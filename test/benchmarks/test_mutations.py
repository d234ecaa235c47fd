"""Mutants: what is changed, what is left alone, and all of them compiled once."""

import ast
import sys

import pytest

from benchmarks.mutations.copies import Copy
from benchmarks.mutations.draw import drawn, places, switched
from peg_on_hole_ros.mechanics.whitney import jamming_margin

# A module whose own text is not looked at.
MODULE = "errors.py"
MARGIN = (0.01, 0.02, 0.3, 1.0, 10.0, 0.05)
PRINT = f"from peg_on_hole_ros.mechanics.whitney import *; print(jamming_margin(*{MARGIN}))"


def mutants(*lines):
    text = "\n    ".join(["def changed(a, b, x):", *lines])
    found = []
    switched(MODULE, text, found.append)
    return {(each.kind, each.new) for each in found}


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("x = a * b", {("factor", "a")}),
        ("x = a / b", {("factor", "a * b")}),
        ("x = a + b", {("sign", "a - b")}),
        ("x = -a", {("sign", "a")}),
        ("x -= a", {("sign", "x -= -a")}),
        ("x = 0.5", {("constant", "5.0")}),
        ("x = a <= b", {("comparison", "a > b")}),
        ("x = a and b", {("half", "a"), ("half", "b")}),
        ("x = min(a, b)", {("bound", "max(a, b)")}),
        ("x.y = a", {("statement left out", "pass")}),
        ("x = a if b else 0", {("condition", "a if not b else 0")}),
        ("if a: x = b", {("condition", "if not (a)")}),
        (
            "if a == b: return x",
            {("condition", "if not (a == b)"), ("early exit", "pass"), ("comparison", "a != b")},
        ),
    ],
)
def test_a_mutant_is_one_change(line, expected):
    assert mutants(line) == expected


@pytest.mark.parametrize(
    "line",
    [
        '"""Half of 0.5 < 1.0."""',
        "raise ValueError(f'{a * 0.5} < {-b}')",
        "x: 'a < b' = a",
        "x = f'{a + b}'",
        "x = a[1 + b]",
        "x = 1e-24",
        "x = b if a is None else x",
        "def inner(y=0.5): return y",
    ],
)
def test_what_changes_no_behaviour_is_left_alone(line):
    assert mutants(line) == set()


def test_a_draw_has_every_kind_and_begins_a_larger_one():
    few, more = drawn("monitor", 5, 9), drawn("monitor", 5, 30)
    assert more[:9] == few and len(set(more)) == 30
    assert {each.kind for each in few} == {each.kind for each in places("monitor")}
    assert drawn("monitor", 6, 9) != few


def test_mutants_stand_in_one_another():
    text = "def changed(a, b):\n    return a * (b + 0.5) < 1.0"
    numbers = iter(range(1, 20))
    tree = ast.parse(switched(MODULE, text, lambda _: next(numbers)))
    tree.body = [each for each in tree.body if not isinstance(each, ast.ImportFrom)]

    def values(number):
        space = {"mutation": lambda: number}
        exec(compile(tree, "switched", "exec"), space)
        return [space["changed"](a, b) for a, b in ((0.5, 1.0), (1.5, 1.0), (0.5, -9.0))]

    assert values(0) == [True, False, True] and next(numbers) == 6
    on = [values(number) for number in range(1, 6)]
    # Only one of them turns the comparison.
    assert on.count([False, True, False]) == 1 and on.count(values(0)) < 2


def test_one_compilation_serves_all_mutants(tmp_path):
    some = [m for m in places("mechanics") if m.path == "mechanics/whitney.py"]
    some = [m for m in some if m.old in ("1.0 + ratio", "M / radius")]
    copy = Copy(tmp_path, some)
    copy.write()

    def margin(number):
        done = copy.run(number, [sys.executable, "-c", PRINT], 300.0)
        assert done.returncode == 0, done.stdout
        return float(done.stdout), sorted(tmp_path.rglob("*.nbc"))

    off, compiled = margin(0)
    assert off == pytest.approx(jamming_margin(*MARGIN), rel=1e-15) and len(compiled) > 0
    on = [margin(number) for number in range(1, len(some) + 1)]
    assert len({off, *(value for value, _ in on)}) == 1 + len(some) > 2
    assert all(files == compiled for _, files in on)
