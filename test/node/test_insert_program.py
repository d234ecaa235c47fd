"""The deciding part of examples/insert.py, in a small world and without ROS."""

from dataclasses import replace

import numpy as np
import pytest

from peg_world import DT, OPTIONS, World, insert, while_aligning


def test_the_program_inserts_and_says_what_it_does():
    world = World(off=(0.001, -0.0012))
    program = world.run(insert.Program(OPTIONS))
    assert (program.outcome, program.tried, program.stops) == ("inserted", 1, [])
    assert world.stages() == ["hang", "touch", "search", "align", "go_in", "inserted"]
    assert [command.expect for command in world.commands if command.expect] == ["insertion"]
    # Tared once, in the air.
    tared = [command for command in world.commands if command.tare]
    assert [command.stage for command in tared] == ["hang"]
    assert tared[0].position[2] > world.plate + 0.005


def test_an_error_stops_the_try_and_the_peg_is_lifted_off_before_the_next():
    world = World(alarms=while_aligning(2, "the peg wedges"))
    program = world.run(insert.Program(OPTIONS))
    (_, stage, why), = program.stops  # fmt: skip
    assert (program.outcome, program.tried) == ("inserted", 2)
    assert (stage, why) == ("align", "jamming: the peg wedges")
    assert world.stages()[3:7] == ["align", "back_off", "hang", "touch"]
    said = [command.expect for command in world.commands if command.expect]
    assert said == ["insertion", "lift_off", "insertion"]
    lifted = [c.position[2] for c in world.commands if c.stage == "back_off"]
    assert max(lifted) > world.plate + 0.003


def test_an_error_is_passed_over_where_it_is_turned_off():
    world = World(alarms=while_aligning(2, "the peg wedges"))
    program = world.run(insert.Program(replace(OPTIONS, stop_on_error=False)))
    assert (program.outcome, program.tried) == ("inserted", 1)


@pytest.mark.parametrize("follows", [True, False])
def test_a_warning_slows_turns_and_presses_less_by_its_advice(follows):
    text = "push with at most 30%, close at 0.02 rad/s, turn at 0.14 rad/s so that the load stays"
    world = World(alarms=while_aligning(1, text))
    options = replace(OPTIONS, follow_warn=follows, stop_on_error=False)
    assert world.run(insert.Program(options)).outcome == "inserted"
    leans = np.array([np.linalg.norm(c.lean) for c in world.commands])
    spins = np.array([c.spin for c in world.commands])
    # Between two tilts within which the warning lasts, a step away from its ends.
    during = np.flatnonzero((leans < 0.148) & (leans > 0.102))
    during = during[:-1][np.diff(during) == 1]
    closing = -np.diff(np.arcsin(leans))[during].mean() / DT
    turning = np.diff(spins)[during].mean() / DT
    assert closing == pytest.approx(0.02 if follows else OPTIONS.closing_rate, rel=0.02)
    assert turning == pytest.approx(0.14 if follows else 0.0, abs=1e-6)


def test_a_search_that_finds_nothing_is_given_up_after_the_tries():
    world = World(off=(0.02, 0.0))
    program = world.run(insert.Program(OPTIONS), seconds=90.0)
    assert program.outcome == "given up"
    assert [why for _, _, why in program.stops] == ["no hole found"] * OPTIONS.tries


def test_the_controllers_force_limit_ends_a_try_of_the_plain_program():
    world = World()
    options = replace(OPTIONS, stop_on_error=False, follow_warn=False, force_limit=8.0)
    program = world.run(insert.Program(options))
    assert [why for _, _, why in program.stops] == ["force limit: 10 N"] * OPTIONS.tries


def test_by_a_plan_the_program_turns_where_the_plan_does():
    still = {"gamma": -0.2, "psi": 0.0, "phi": 0.0}
    plan = {
        "start": {"tilt": 0.2},
        "stages": [{"tilt": 0.1, "rates": still}, {"tilt": 0.06, "rates": still | {"phi": 0.3}}],
    }
    # From where the monitor sees the peg in the hole, at 0.06 rad here, it closes half as fast.
    lasts = 0.04 / 0.2 + 0.06 / 0.1
    for follows, early in ((False, 0.0), (True, 0.05)):
        world = World()
        options = replace(OPTIONS, plan=plan, follow_warn=follows)
        assert world.run(insert.Program(options)).outcome == "inserted"
        aligned = [c for c in world.commands if c.stage == "align"]
        turned = [c.spin for c in aligned if np.linalg.norm(c.lean) > 0.1 + early]
        assert max(turned) - min(turned) < 1e-9
        # A monitor that is followed foresees the present motion: it has to see the turn first.
        assert aligned[-1].spin == pytest.approx(0.3 * (lasts + early / 0.2), rel=0.1)
