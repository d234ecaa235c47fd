"""The alarm on jamming states a friction that has stepped."""

import re

import numpy as np
import pytest

from benchmarks.grid.friction_steps import UNTIL, stepping
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.sim.measure import START_NS, measure


def outputs(number, steps):
    truth, friction = stepping(number, steps)
    found = list(Pipeline(truth.plan.configuration).play(measure(truth, 7)))
    t = np.array([each.t_ns - START_NS for each in found]) * 1e-9
    return t, found, friction


# Up by 0.07, down by 0.13, up by 0.2.
@pytest.mark.parametrize("number", [6, 3, 16])
def test_a_step_of_friction_is_named_with_both_values(number):
    t, found, friction = outputs(number, True)
    before = np.array([each.friction_before for each in found])
    assert np.isnan(before[t < UNTIL]).all()
    # From 0.2 s after the step on, by the friction that was true before and that is true after.
    late = t > UNTIL + 0.2
    assert before[late] == pytest.approx(friction[0], abs=0.01)
    message = found[-1].alarms[0].message
    how = "risen" if friction[-1] > friction[0] else "fallen"
    named = re.search(rf"friction has {how} from ([0-9.]+) to ([0-9.]+)$", message)
    # Of two digits behind the point.
    assert float(named[1]) == pytest.approx(friction[0], abs=0.015)
    assert float(named[2]) == pytest.approx(friction[-1], abs=0.015)


@pytest.mark.parametrize("number", [1, 2])
def test_a_friction_that_stays_has_not_stepped(number):
    _, found, _ = outputs(number, False)
    assert all(np.isnan(each.friction_before) for each in found)
    assert not any("friction has" in each.alarms[0].message for each in found)
