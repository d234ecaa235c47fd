"""What a node costs is told for the wrenches that it answers."""

import pytest

from benchmarks.cost.node_cost import Turn, table


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
