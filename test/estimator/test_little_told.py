"""A steady slide hardly tells friction, bias and tilt apart: no more is to be told."""

from itertools import product

import numpy as np
import pytest

from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from steady_slide import CONFIGURATION, motion, orientation, wrench
from tiers import at_push

BIAS = {"wrench.bias_force_stddev": 1.0}
TILT = {"joints.hole_tilt_stddev": 0.01}
SEEDS = range(3)


def played(settings, load, seed, count=500):
    """Yield how long it slides [ms], the output, and the estimate as it stands."""
    line, random = Pipeline(from_parameters(settings)), np.random.default_rng(seed)
    for k in range(count):
        if k % 2 == 0:
            line.on_sample(orientation(k, random))
        out = line.on_sample(wrench(k, random, k, load=load))
        if k >= 50:
            yield k, out, line.filter.friction


OPEN = {"none": {}, "bias": BIAS, "tilt": TILT, "both": BIAS | TILT}
PUSH = [("both", 6.0)]


@pytest.mark.parametrize(("what", "load"), at_push(PUSH, product(OPEN, (6.0, 25.0, 60.0))))
def test_neither_friction_nor_reactions_are_surely_wrong(what, load):
    at_rim, inside = np.array([load, load / 2, load / 2]), []
    for seed in SEEDS:
        for k, out, (friction, stddev) in played(OPEN[what], load, seed):
            assert abs(friction - CONFIGURATION.scene.friction) < 4 * stddev
            assert abs(out.state[0] - motion(k)[0][0]) < 4 * out.state_covariance[0, 0] ** 0.5
            if out.monitor["reactions_determined"]:
                inside.append(np.abs(out.normal - at_rim) <= 1.96 * out.normal_stddev)
    # What is called determined is within its bounds, as is promised of any truth; a few samples
    # of one moment tell no share.
    out = np.sum(~np.array(inside, bool).reshape(-1, 3), axis=0)
    assert out.max() <= 0.15 * max(len(inside), 100)


def test_a_bias_that_no_motion_tells_leaves_friction_open():
    """It is stated to 0.05; half a second of a light slide does not tell it from 1 N of bias."""
    for seed in SEEDS:
        *_, (_, _, (_, stddev)) = played(BIAS, 6.0, seed, 300)
        assert stddev > 0.02
