"""What a node costs is stated for the wrenches that it answers; ways that are timed take turns."""

import pytest

from benchmarks.cost.node_cost import Turn, table
from benchmarks.cost.turns import in_turns


def test_a_cost_is_that_of_a_wrench_answered_and_losses_are_told():
    turns = {
        "node": [Turn(300e-6, [0.2e-3] * 99 + [0.9e-3], 100, 9.0)],
        "bare": [Turn(100e-6, [0.1e-3] * 200, 0, 9.0)],
    }
    *_, node, bare, ratio = table(turns).splitlines()
    assert "| 300 | 0.20 | 0.90 | 100 of 200 |" in node
    assert "| 0 of 200 |" in bare
    assert "3.00 times" in ratio and "at 99 % its states are 9.0 times as old" in ratio


@pytest.mark.parametrize("silent", ["node", "bare"])
def test_a_node_that_answers_nothing_has_no_cost(silent):
    turns = {name: [Turn(1e-4, [1e-4], 0, 9.0)] for name in ("node", "bare")}
    turns[silent] = [Turn(1.0, [], 60_000, 0.0)]
    assert table(turns) == f"{silent}: no wrench was answered"


def test_ways_take_turns_and_what_comes_before_is_not_timed():
    now, order = [0.0], []

    def taking(seconds, result):
        now[0] += seconds
        order.append(result)
        return result

    ways = {"a": lambda: taking(1.0 + len(order), "a"), "b": lambda: taking(2.0, "b")}
    turns = in_turns(ways, 3, lambda: now[0], lambda name: taking(100.0, name.upper()))
    assert order == ["A", "a", "B", "b"] * 3 and turns.results == {"a": "a", "b": "b"}
    assert turns.seconds["a"] == [2.0, 6.0, 10.0] and turns.least("b") == turns.median("b") == 2.0
    assert (turns.least("a"), turns.median("a")) == (2.0, 6.0)
