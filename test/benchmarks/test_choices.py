"""`benchmarks choices`: what counts as a promise that was kept."""

import shutil
from argparse import Namespace

import pytest

from benchmarks import choices
from benchmarks.robot_cells.arms import ARMS
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.study.choice import Tried
from peg_on_hole_ros.study.motions import LONGEST
from simulated import ROOT


def made_up(method, rate, reactions=0.01):
    return Tried(method, rate, reactions, 0.05, 0.95, 1.0, 0.005, 0.0, 10.0, 100.0, 12)


def test_a_promise_is_kept_where_fresh_seeds_say_so():
    found = [made_up("mixture", 1000.0), made_up("balance", 100.0), made_up("two_dof", 100.0, 0.2)]
    again = choices.came_of(found, found)
    assert again == ("balance at 100 Hz", True, 1, 1, [], 0.0)
    fresh = [found[0], made_up("balance", 100.0, 0.05), made_up("two_dof", 100.0, 0.01)]
    came = choices.came_of(found, fresh)
    assert came[:4] == ("balance at 100 Hz", False, 1, 0)
    # Each that is otherwise is told with its figures.
    named, little = came.broken
    assert named.startswith("balance at 100 Hz: reactions 0.01, afresh 0.05")
    assert little.startswith("two_dof at 100 Hz: reactions 0.2, afresh 0.01")


def test_what_is_next_to_a_tolerance_may_fall_on_either_side():
    near = [made_up("mixture", 1000.0, 0.029), made_up("balance", 1000.0, 0.031)]
    other = [made_up("mixture", 1000.0, 0.031), made_up("balance", 1000.0, 0.029)]
    assert choices.came_of(near, other)[:4] == ("mixture at 1000 Hz", True, 1, 1)
    # So may a flag, which is told by whole wrenches: 10 ms are asked for.
    late, early = ([made_up("mixture", 100.0)._replace(flag=flag)] for flag in (0.0101, 0.009))
    assert choices.came_of(late, early)[:4] == ("", True, 1, 1)
    assert choices.came_of([late[0]._replace(flag=0.02)], early)[:4] == ("", False, 1, 0)


def test_where_nothing_is_enough_nothing_is_afterwards():
    little = [made_up("mixture", 1000.0, 0.2)]
    assert choices.came_of(little, little)[:4] == ("", True, 1, 1)
    assert choices.came_of(little, [made_up("mixture", 1000.0)])[:4] == ("", False, 1, 0)


def test_a_cell_has_noise_of_its_own_and_the_same_number_is_the_same_cell():
    one, other = choices.cell_of(1), choices.cell_of(2)
    assert one == choices.cell_of(1) and one.wrench.force_stddev != other.wrench.force_stddev


def test_the_report_counts_cells_with_a_motion():
    rows = [
        (choices.Numbered(0, 2), tree("mixture at 100 Hz", True, 3, 3)),
        (choices.Numbered(1, 2), tree(choices.NONE, True, 0, 0, ["no motion keeps its limits"])),
        (choices.Numbered(2, 2), tree("", False, 4, 3, ["balance at 50 Hz: otherwise"])),
    ]
    text = choices.report(rows, None).text
    assert "2 of 3 drawn cells have a motion. What was named holds afresh in 1" in text
    assert "is so in 1" in text and "- 002: balance at 50 Hz: otherwise" in text
    assert "no motion keeps" not in text and "engine" not in text


def tree(named, kept, too_little, again, broken=(), engine=None):
    one = {"came": [named, kept, too_little, again, list(broken), 20.0], "engine": engine}
    return {"told": [one] * len(choices.ASKED)}


def test_robot_cells_are_told_by_themselves_with_what_the_engine_says():
    robot = choices.Numbered(0, 2, "ur_like", "damped")
    rows = [
        (choices.Numbered(0, 2), tree("mixture at 100 Hz", True, 3, 3)),
        (robot, tree("one_level at 500 Hz", True, 2, 2, engine=[0.123, 0.97])),
    ]
    text = choices.report(rows, None).text
    assert "1 of 1 drawn cells" in text and "1 of 1 robot cells of another engine" in text
    assert "| one_level at 500 Hz | 1 | 1 | 12 % | 97 % |" in text


def test_robots_are_drawn_with_every_arm_and_contact():
    options = Namespace(first=5, cells=2, robots=10, first_robot=0, seeds=12)
    found = choices.members(options)
    assert [str(member) for member in found[:3]] == ["005", "006", "ur_like_hard_000"]
    assert len(found) == 12 and len({str(member) for member in found}) == 12
    assert {(member.arm, member.contact) for member in found[2:]} == {
        (arm, contact) for arm in ARMS for contact in choices.SHARP
    }


def test_a_robot_cell_has_the_motion_of_its_recording(monkeypatch, tmp_path):
    # As MuJoCo's rows are not at hand, those of a bag that is shipped are taken for them.
    monkeypatch.setattr(choices.drawn, "recorded", shipped)
    truth = choices.motion(choices.Numbered(0, 2, "franka_like", "hard"), tmp_path)
    assert truth.plan.wrench_rate == 1000
    # What the replay determines without a gap is 0.45 s, less the time in which the peg settles.
    assert 0.2 < truth.t_ns[-1] * 1e-9 <= LONGEST
    assert not list(tmp_path.iterdir())


def shipped(cell, folder, noise):
    bag = folder / "cell.mcap"
    shutil.copy(ROOT / "bags" / f"cell_{cell.arm}.mcap", bag)
    configuration, _ = load(str(ROOT / "config" / f"cell_{cell.arm}.yaml"))
    return choices.drawn.Recording(bag, configuration, None)


@pytest.mark.nightly
def test_what_is_named_for_a_robot_cell_is_tried_on_the_engine(tmp_path):
    pytest.importorskip("mujoco")
    cell = choices.Numbered(0, 2, "franka_like", "damped")
    chosen = made_up("mixture", 500.0)
    found = choices.on_engine(cell, chosen, 2, tmp_path)
    # Gears, filters and zeros are no noise: it is further off than choose says, and covered.
    assert 0.0 < found.reactions < 0.5 and found.covered > 0.9
