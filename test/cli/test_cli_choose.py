"""`choose`: a cell's own motion, what is enough for it, and what limits it."""

from dataclasses import replace

import numpy as np
import pytest

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.cli import choose
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.config.options import Configuration, JointInput
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.study import choice, motions
from peg_on_hole_ros.study.choice import Limit, Measured, Seeds, Tolerances, Tried
from simulated import ROOT

CELL = str(ROOT / "config" / "plan_cell.yaml")
CLOSING = str(ROOT / "config" / "closing_with_slip.yaml")
WITHIN = Tolerances()


def clock():
    """A clock that goes on by a second a look."""
    clock.now = getattr(clock, "now", 0.0) + 1.0
    return clock.now


@pytest.fixture(scope="module")
def planned():
    return motions.planned_motion(motions.simulated_cell(load(CELL)[0]), 500)


def made_up(method, rate, **changed):
    good = Tried(method, rate, 0.02, 0.05, 0.95, 1.0, 0.005, 0.0, 10.0, 100.0, 12)
    return good._replace(**changed)


def test_the_lowest_rate_that_is_enough_and_then_the_cheapest_step():
    dear, cheap = made_up("mixture", 250.0), made_up("one_level", 250.0, step=3.0)
    fast = made_up("balance", 1000.0, step=1.0)
    assert choice.cheapest([fast, dear, cheap], WITHIN) is cheap
    for lacks in (
        {"reactions": 0.04}, {"tilt_rate": 0.2}, {"covered": 0.8}, {"determined": 0.3},
        {"flag": 0.02}, {"flag": float("inf")}, {"lost": 0.1},
    ):  # fmt: skip
        assert choice.cheapest([dear, cheap._replace(**lacks)], WITHIN) is dear
    # A motion without a transition has no flag to be late.
    assert made_up("mixture", 250.0, flag=float("nan")).enough(WITHIN)
    assert choice.cheapest([fast], Tolerances(reactions=0.01)) is None


def test_nearest_is_one_whose_bounds_hold():
    sure = made_up("mixture", 500.0, reactions=0.2)
    wrong = made_up("unscented", 500.0, reactions=0.1, covered=0.5)
    assert choice.nearest([wrong, sure], Tolerances()) is sure
    assert choice.nearest([wrong], Tolerances()) is wrong
    # By what it lacks most: its tilt's rate, whatever its reactions are.
    near = made_up("balance", 500.0, reactions=0.025, tilt_rate=0.11)
    assert choice.nearest([made_up("mixture", 500.0, tilt_rate=0.3), near], Tolerances()) is near


def test_orientations_come_with_wrenches():
    assert [motions.joint_rate_of(rate) for rate in (100, 500, 1000, 7000, 750)] == [
        100, 500, 500, 500, 375,
    ]  # fmt: skip


def test_joints_of_an_arm_are_noise_of_the_orientation():
    arm = Configuration(
        joints=JointInput(source="robot", names=tuple("abcdef"), position_stddev=1e-4)
    )
    # Six joints, each about an axis of its own: a third of each about any axis.
    assert motions.simulated_cell(arm).joints.position_stddev == pytest.approx(1e-4 * 2**0.5)
    angles = Configuration(joints=JointInput(position_stddev=1e-4))
    assert motions.simulated_cell(angles).joints.position_stddev == 1e-4


def test_a_planned_motion_goes_through_the_transition(planned):
    count = motions.on_three(planned)
    assert 100 < count < len(planned.t_ns)
    assert (planned.normal[:count] > 0).all()
    assert planned.q[count, 0] == pytest.approx(planned.plan.configuration.scene.gamma0, rel=0.02)


def test_of_a_long_motion_the_end_is_taken():
    cell = motions.simulated_cell(load(CELL)[0])
    slow = replace(cell.plan, max_closing_rate=0.03, min_closing_rate=0.02)
    truth = motions.planned_motion(replace(cell, plan=slow), 500)
    assert truth.t_ns[0] == 0 and motions.on_three(truth) == motions.LONGEST * 500
    # From some tilt on, and through gamma0 as a short one.
    gamma0 = cell.scene.gamma0
    assert truth.q[0, 0] < gamma0 + 1.1 * 0.03 * motions.LONGEST < slow.start_tilt
    assert truth.q[-1, 0] < gamma0


def test_a_recorded_motion_is_followed(planned):
    count = motions.on_three(planned)
    force = planned.contact_force[:count].sum(axis=1)
    c, s = np.cos(planned.q[:count, 1]), np.sin(planned.q[:count, 1])
    push = -np.column_stack(
        [c * force[:, 0] + s * force[:, 1], c * force[:, 1] - s * force[:, 0], force[:, 2]]
    )
    t = planned.t_ns[:count] * 1e-9
    recorded = motions.Recorded(t, planned.q[:count], planned.rates[:count], push)
    again = motions.recorded_motion(planned.plan.configuration, recorded, 500)
    # By the lead-in later; the holder bends by some mrad under the torque of the load.
    at = again.t_ns * 1e-9 + motions.CLOSING_LEAD_IN
    for k in (0, 2):
        there = np.interp(at, t, planned.q[:count, k])
        assert np.abs(again.q[:, k] - there).max() < 0.02
    load = np.median(again.normal[motions.on_three(again) // 2])
    assert 0.5 < load / np.median(planned.normal[count // 2]) < 2.0


def test_what_is_tried_is_the_method_with_its_cost(planned):
    motion = Measured(planned, Seeds(1, 2))
    default, balance = (choice.tried(motion, name, 1, clock) for name in ("mixture", "balance"))
    assert default.rate == balance.rate == 500.0
    assert default.reactions < balance.reactions and default.holds
    # By a clock that tells looks, a run takes a second, and all steps of a motion too.
    assert default.whole == pytest.approx(1e6 / (planned.t_ns[-1] * 1e-6))
    assert default.flag < 0.02
    slower = choice.tried(motion, "mixture", 4, clock)
    assert slower.rate == 125.0 and slower.step > default.step


def test_what_is_far_off_is_given_no_more_draws(planned):
    motion = Measured(planned, Seeds(1, choice.FEW + 2))
    every, near, far = (
        choice.tried(motion, "balance", 4, clock, within)
        for within in (None, Tolerances(1.0, 10.0), Tolerances(1e-4, 10.0))
    )
    assert every.draws == near.draws == choice.FEW + 2 and far.draws == choice.FEW
    # What is cut short is the same for as long as it lasts, and not enough.
    assert every._replace(step=0.0) == near._replace(step=0.0)
    assert far.reactions == pytest.approx(every.reactions, rel=0.5)
    row = choose._row(far, Tolerances(1e-4, 10.0), every.draws)
    assert row[-1] == f"far off after {choice.FEW} draws"


def test_without_a_clock_there_is_no_cost_and_the_same_numbers(planned):
    motion = Measured(planned, Seeds(1, 2))
    timed = choice.tried(motion, "mixture", 4, clock)
    free = choice.tried(motion, "mixture", 4, None)
    assert np.isnan(free.step) and np.isnan(free.whole)
    # Samples one by one, as a node takes them, and all at once are the same bit for bit.
    assert free._replace(step=timed.step, whole=timed.whole) == timed


def test_draws_of_a_motion_differ_and_begin_with_an_orientation(planned):
    motion = Measured(planned, Seeds(1, 2))
    one, other = motion.thinned(0, 4), motion.thinned(1, 4)
    assert one != other and one == motion.thinned(0, 4)
    # As many orientations as wrenches, each before its own.
    for samples in (one, other):
        stamps = [sample.t_ns for sample in samples]
        assert stamps[::2] == stamps[1::2] and set(np.diff(stamps[::2])) == {8_000_000}
    assert one[0].t_ns != other[0].t_ns


def test_half_of_a_noise_is_stated_and_true(planned):
    half = choice._with_half(planned, "force_stddev")
    assert half.plan.configuration.wrench.force_stddev == pytest.approx(
        0.5 * planned.plan.configuration.wrench.force_stddev
    )
    halves = list(choice.limits(planned, made_up("mixture", 250.0), Seeds(1, 1), clock))
    assert [limit.what.split()[-1] for limit in halves] == ["force", "torque", "orientation", "Hz"]
    assert "500 Hz" in halves[-1].what


def test_words_say_what_would_give_more():
    best = made_up("mixture", 250.0, reactions=0.02)
    known = [
        Limit("half of the noise of the force", 0.01, 0.05),
        Limit("a wrench at 500 Hz", 0.0199, 0.05),
    ]
    (line,) = choose._limit_lines(best, known, Tolerances())
    assert "half of the noise of the force would reduce it from 2 % to 1 %" in line
    assert "a wrench at 500 Hz changes nothing" in line
    # Where the tilt's rate is what falls short, it is what is told of.
    (line,) = choose._limit_lines(best._replace(tilt_rate=0.2), known, Tolerances())
    assert line.startswith("what limits the error of the tilt's rate: ")
    assert "half of the noise of the force would reduce it from 20 % to 5 %" in line


@pytest.fixture
def few(monkeypatch):
    monkeypatch.setattr(choose, "COMPARED", ("mixture", "balance"))
    monkeypatch.setattr(choose, "THINNED", (1, 10))


def test_choose_writes_the_setting(few, tmp_path, capsys):
    assert main(["choose", "--config", CLOSING, "--seeds", "2", "--out", str(tmp_path)]) == 0
    text = capsys.readouterr().out
    assert "set filter.method: mixture" in text and "what limits the " in text
    configuration, _ = load(str(tmp_path / "choose.yaml"))
    assert configuration.filter.method == "mixture"
    assert (tmp_path / "choose.png").stat().st_size > 10_000


def test_choose_says_what_is_nearest(few, capsys):
    given = ["choose", "--config", CLOSING, "--seeds", "2", "--within", "0.05%"]
    assert main(given) == 0
    text = capsys.readouterr().out
    assert "no combination is enough for reactions within 0.05 %" in text and "nearest is " in text
    assert "the flag within 10 ms (not tested: this motion ends before the transition)" in text


def test_choose_takes_the_motion_of_a_recording(few, capsys):
    bag = str(ROOT / "bags" / "closing_with_slip.mcap")
    assert main(["choose", "--config", CLOSING, "--bag", bag, "--seeds", "2"]) == 0
    text = capsys.readouterr().out
    assert f"the motion of {bag} from" in text and "set filter.method" in text


@pytest.mark.parametrize(("lasts", "bridged"), [(0.0, True), (0.015, True), (0.04, False)])
def test_a_stretch_goes_on_over_a_few_wrenches_without_reactions(lasts, bridged, monkeypatch):
    """A recording is followed in pieces of 20 ms: less than that leaves no piece out."""

    class WithAGap(choose._Rows):
        def take(self, columns):
            super().take(columns)
            t = (columns.t_ns - first_ns) * 1e-9
            self.parts[-1][-1][(t >= 0.4) & (t <= 0.4 + lasts)] = False

    bag = Bag(ROOT / "bags" / "closing_with_slip.mcap")
    first_ns = bag.topics["/wrench"].first_ns
    monkeypatch.setattr(choose, "_Rows", WithAGap)
    found = choose.motion_of(bag, load(CLOSING)[0])
    # Nothing longer is told after it.
    assert found.begin < 0.1 and (found.end > 0.6 if bridged else found.end < 0.4)
    assert found.doubts == []


def test_a_recording_of_another_peg_is_told(few, tmp_path, capsys):
    bag, heavier = str(ROOT / "bags" / "closing_with_slip.mcap"), tmp_path / "heavier.yaml"
    heavier.write_text(
        "peg_on_hole: {ros__parameters: {scene: {peg_mass: 0.6}, wrench: {force_stddev: 0.3}}}"
    )
    assert main(["choose", "--config", str(heavier), "--bag", bag, "--seeds", "2"]) == 0
    lines = capsys.readouterr().out.splitlines()
    # Noise is no other peg.
    assert lines[1] == "the recording states another peg or hole: scene.peg_mass = 0.5 for 0.6"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--within", "3"], None),
        (["--within", "much"], "--within much is not a share"),
        (["--within", "-3%"], "--within -3% is not a share"),
        (["--rate-within", "200%"], "--rate-within 200% is not a share"),
        (["--flag-within", "0"], "--flag-within = 0 ms is not within"),
        (["--seeds", "1"], "--seeds = 1 is not within 2 to 100"),
        (["--rate", "1"], "--rate = 1 Hz is not within"),
    ],
)
def test_what_cannot_be_asked_for_is_refused(options, said, monkeypatch, capsys):
    monkeypatch.setattr(choose, "_motion", _none)
    code = main(["choose", "--config", CLOSING, *options])
    assert code == 2
    assert (said or "no motion here") in capsys.readouterr().err


def _none(arguments):
    raise PegOnHoleError("no motion here")


def test_a_motion_that_begins_in_the_air_is_refused(capsys):
    cycle = str(ROOT / "config" / "working_cycle.yaml")
    assert main(["choose", "--config", cycle]) == 2
    assert "does not begin on three contacts" in capsys.readouterr().err


def test_a_cell_without_a_plan_is_told_what_else_would_do():
    configuration = load(CELL)[0]
    weak = replace(configuration, monitor=replace(configuration.monitor, max_normal=(1.0,) * 3))
    with pytest.raises(PegOnHoleError, match="give a recording with --bag"):
        motions.planned_motion(weak, 500)
