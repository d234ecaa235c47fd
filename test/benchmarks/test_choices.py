"""`benchmarks choices`: what counts as a promise that was kept."""

from benchmarks import choices
from peg_on_hole_ros.study.choice import Tried


def made_up(method, rate, reactions=0.01):
    return Tried(method, rate, reactions, 0.05, 0.95, 1.0, 0.005, 0.0, 10.0, 100.0)


def test_a_promise_is_kept_where_fresh_seeds_say_so():
    found = [made_up("mixture", 1000.0), made_up("balance", 100.0), made_up("two_dof", 100.0, 0.2)]
    again = choices.came_of(found, found)
    assert again == ("balance at 100 Hz", True, 1, 1)
    broken = [found[0], made_up("balance", 100.0, 0.05), made_up("two_dof", 100.0, 0.01)]
    assert choices.came_of(found, broken) == ("balance at 100 Hz", False, 1, 0)


def test_what_is_next_to_a_tolerance_may_fall_on_either_side():
    near = [made_up("mixture", 1000.0, 0.029), made_up("balance", 1000.0, 0.031)]
    other = [made_up("mixture", 1000.0, 0.031), made_up("balance", 1000.0, 0.029)]
    assert choices.came_of(near, other) == ("mixture at 1000 Hz", True, 1, 1)


def test_where_nothing_is_enough_nothing_is_afterwards():
    little = [made_up("mixture", 1000.0, 0.2)]
    assert choices.came_of(little, little) == ("", True, 1, 1)
    assert choices.came_of(little, [made_up("mixture", 1000.0)]) == ("", False, 1, 0)


def test_a_cell_has_noise_of_its_own_and_the_same_number_is_the_same_cell():
    one, other = choices.cell_of(1), choices.cell_of(2)
    assert one == choices.cell_of(1) and one.wrench.force_stddev != other.wrench.force_stddev


def test_the_report_counts_cells_with_a_motion():
    rows = [
        (choices.Numbered(0, 2), ["mixture at 100 Hz", True, 3, 3]),
        (choices.Numbered(1, 2), [choices.NONE, True, 0, 0]),
        (choices.Numbered(2, 2), ["", False, 4, 3]),
    ]
    text = choices.report(rows, None).text
    assert "2 of 3 cells have a motion. What was named holds afresh in 1" in text
    assert "is so in 1" in text
