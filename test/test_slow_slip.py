"""Where no slip is told from none: friction by force balance, rates that follow innovations."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from grid_cells import Motion, truth_of, with_noise
from peg_on_hole_ros.estimation.kernel import Process
from peg_on_hole_ros.estimation.memory import SIZE, part
from peg_on_hole_ros.estimation.slip import stops_by_chance
from peg_on_hole_ros.estimation.slow import (
    ADAPTATION,
    MOST_RATE_NOISE,
    MOST_SURPRISE,
    adapt_rate_noise,
    learn_from_balance,
)
from peg_on_hole_ros.mechanics.kernel import WIDTH, scene_of, scene_scalars
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.records import JointSample
from peg_on_hole_ros.simulation.measure import measure

LEAST = 0.2


@cache
def slow_motion():
    """3 mm/s, at some 400 N: a friction that is wrong by 0.01 stops the peg within a step."""
    return truth_of(Motion(1e-4, 0.2, 0.01, "slip"))[0]


@pytest.mark.parametrize("start", [0.1, 0.3])
@pytest.mark.parametrize("noise", ["low", "nominal"])
def test_friction_is_found_from_either_side(start, noise):
    truth = with_noise(slow_motion(), noise, 0.05)
    configuration = truth.plan.configuration
    scene = replace(configuration.scene, friction=start)
    pipeline = Pipeline(replace(configuration, scene=scene))
    found = []
    for sample in measure(truth, 3):
        if isinstance(sample, JointSample):
            pipeline.on_joints(sample)
        elif (outputs := pipeline.on_wrench(sample)) is not None:
            found.append((outputs.monitor["friction"], outputs.monitor["friction_stddev"]))
    value, stddev = np.array(found).T
    # What is asked of the estimate: 5 % after 0.3 s, 1 % after 1 s.
    assert np.abs(value[300:] - 0.2).max() < 0.01
    assert abs(value[-1] - 0.2) < 0.002
    assert (np.abs(value - 0.2) < 4 * stddev)[300:].mean() > 0.95


@pytest.fixture
def memory():
    """A peg that slides at 50 mm/s, its friction not known."""
    m = np.zeros(SIZE)
    part(m, "SCENE")[:] = scene_scalars(Scene())
    part(m, "X")[:] = 0.15, 0.0, 0.0, -0.1, 0.0, 2.0
    part(m, "U")[:] = 0.0, 0.0, -50.0, 0.0, -3.0, 0.0
    Z = part(m, "Z", (12, 12))
    Z[range(6), range(6)] = [1e-8] * 3 + [1e-2] * 3
    Z[range(6, 12), range(6, 12)] = [0.04] * 3 + [2.5e-5] * 3
    part(m, "SCALES")[:] = 2e-5
    part(m, "SPREAD")[0] = 0.05**2
    part(m, "LEARNT")[:] = 1.0
    process = dict.fromkeys(Process._fields, 0.0) | {"slow_rate_noise": LEAST}
    part(m, "PROCESS")[:] = list(process.values())
    part(m, "RATE_NOISE")[0] = LEAST
    return m


def scratch():
    return np.zeros((6, WIDTH))


def test_nothing_is_learnt_of_a_direction_that_is_not_sure(memory):
    assert learn_from_balance(memory.copy(), scratch(), 1e-3, 20.0)
    blurred = memory.copy()
    part(blurred, "Z", (12, 12))[range(3, 6), range(3, 6)] = 1.0
    before = blurred.copy()
    assert not learn_from_balance(blurred, scratch(), 1e-3, 20.0)
    assert part(blurred, "SPREAD")[0] == part(before, "SPREAD")[0]
    still = memory.copy()
    part(still, "X")[3:] = 0.0
    assert not learn_from_balance(still, scratch(), 1e-3, 20.0)


def test_friction_that_is_only_considered_is_not_learnt(memory):
    part(memory, "LEARNT")[0] = 0.0
    assert not learn_from_balance(memory, scratch(), 1e-3, 20.0)


def test_accelerations_count_as_independent_only_after_a_while(memory):
    """As much is learnt in 20 ms, whether it is asked 20 times or twice."""
    spreads = []
    for count in (20, 2):
        m = memory.copy()
        for _ in range(count):
            # All else is known.
            part(m, "Z")[:] = part(m, "CROSS")[:] = 0.0
            part(m, "Z", (12, 12))[range(3, 6), range(3, 6)] = 1e-18
            friction = part(m, "SCENE")[7]
            assert learn_from_balance(m, scratch(), 0.02 / count, 20.0)
            part(m, "SCENE")[7] = friction
        spreads.append(part(m, "SPREAD")[0])
    # Information adds up, but for the slopes' own change, of which there is none here.
    assert spreads[0] == pytest.approx(spreads[1], rel=1e-6)
    assert spreads[0] < 0.5 * 0.05**2


def test_rates_follow_the_innovations(memory):
    noise = part(memory, "RATE_NOISE")
    adapt_rate_noise(memory, 0.0)
    assert noise[0] == LEAST
    adapt_rate_noise(memory, 6.0)
    assert noise[0] == pytest.approx(LEAST * np.exp(ADAPTATION))
    adapt_rate_noise(memory, 0.0)
    assert noise[0] == pytest.approx(LEAST)
    adapt_rate_noise(memory, 1e6)
    assert noise[0] == pytest.approx(LEAST * np.exp(ADAPTATION * (MOST_SURPRISE - 1)))
    for _ in range(1000):
        adapt_rate_noise(memory, 50.0)
    assert noise[0] == MOST_RATE_NOISE


def test_a_stop_is_sure_only_if_friction_surely_is_that_large(memory):
    # Without a press nothing stops 50 mm/s within 1 ms.
    free = memory.copy()
    part(free, "U")[:] = 0.0
    assert stops_by_chance(scene_of(free), free, scratch(), 1e-3, 2.5)
    slow = memory.copy()
    part(slow, "X")[3:] *= 0.02
    part(slow, "Z", (12, 12))[range(3, 6), range(3, 6)] = 1e-8
    part(slow, "U")[2] = -500.0
    part(slow, "SPREAD")[0] = 1e-6
    assert not stops_by_chance(scene_of(slow), slow.copy(), scratch(), 1e-2, 2.5)
    # The same stop is by chance where friction may as well be none.
    part(slow, "SPREAD")[0] = 1.0
    assert stops_by_chance(scene_of(slow), slow.copy(), scratch(), 1e-2, 2.5)
