"""What of a filter's memory outlives a start, letting go of the wrench, and forgetting."""

from dataclasses import replace

import numpy as np
import pytest
from peg_on_hole_ros.estimation.filters.methods import make_filter
from peg_on_hole_ros.estimation.kernel import memory
from peg_on_hole_ros.estimation.kernel.memory import CLEARED, part

from peg_on_hole_ros.configuration import from_parameters
from peg_on_hole_ros.edges.config_file import read_parameters
from peg_on_hole_ros.estimation.measurement import WrenchReduction
from side_by_side import bag_steps
from simulated import ROOT

NAMES = tuple(memory._SIZES)
# What is set once, by scene and options.
SETTING = (
    *("LEARNT", "OFFSETS", "METHOD", "NOISE", "WEIGHT"),
    *("LOAD", "UNLOAD", "HANGING", "MASSES", "GRAVITY", "TURN"),
)


@pytest.fixture(scope="module")
def configuration():
    return from_parameters(read_parameters(ROOT / "config" / "closing_without_slip.yaml"))


@pytest.fixture(scope="module")
def steps(configuration):
    # From slip to where no slip is told from none.
    every = bag_steps(ROOT / "bags" / "closing_without_slip.mcap", configuration)
    return every[120:320]


@pytest.fixture(params=["plain", "bias", "every step"])
def new_filter(configuration, request):
    if request.param == "bias":
        wrench = replace(configuration.wrench, bias_force_stddev=0.3)
        configuration = replace(configuration, wrench=wrench)
    if request.param == "every step":
        options = replace(configuration.filter, slow_slip=0.0)
        configuration = replace(configuration, filter=options)
    reduction = WrenchReduction(configuration.wrench, configuration.scene)
    offsets = reduction.offsets(configuration)
    return lambda: make_filter(
        configuration.scene, configuration.filter, reduction.covariance, offsets
    )


def act(kalman, name, first):
    arguments = (first.q, first.R) if name == "start" else ()
    getattr(kalman, name)(*arguments)


@pytest.mark.parametrize("name", CLEARED._fields)
def test_what_is_named_begins_anew_and_all_else_stays(new_filter, steps, name):
    kalman, first = new_filter(), next(step for step in steps if step.q is not None)
    cleared = getattr(CLEARED, name)
    kalman.memory[:] = np.random.default_rng(1).uniform(0.1, 1.0, len(kalman.memory))
    for each in cleared:
        part(kalman.memory, each)[:] = np.nan
    before = kalman.memory.copy()
    act(kalman, name, first)
    for each in NAMES:
        if each in cleared:
            assert np.isfinite(part(kalman.memory, each)).all(), each
        else:
            assert (part(kalman.memory, each) == part(before, each)).all(), each


def test_nothing_else_of_the_past_is_in_what_comes(new_filter, steps):
    first = next(step for step in steps if step.q is not None)
    found = []
    for junk in (None, 0.7):
        kalman = new_filter()
        for each in set(NAMES) - set(SETTING) if junk else ():
            part(kalman.memory, each)[:] = junk
        for name in ("let_go", "forget", "start"):
            act(kalman, name, first)
        for step in steps:
            kalman.hold(step.u)
            kalman.predict(step.dt, True)
            if step.q is not None:
                kalman.correct(step.q, step.R)
            found.append((*kalman.x, *kalman.P.ravel(), *kalman.friction, kalman.react()))
    old, new = np.split(np.array(found), 2)
    np.testing.assert_array_equal(new, old)
