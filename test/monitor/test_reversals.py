"""A slip or slide that ends, or is reversed, on three contacts is no stall."""

from functools import cache

import numpy as np
import pytest

from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.sim.measure import measure
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.truth import integrate
from tiers import nightly


@cache
def reversed_motion():
    """Touch down, close while slide and slip go one way, then open while they go the other."""
    told = from_parameters(
        {
            "scene.hole_diameter": 0.016,
            "scene.peg_diameter": 0.01597,
            "scene.peg_height": 0.04,
            "scene.peg_mass": 0.15,
            "scene.friction": 0.22,
            "wrench.sensor_xyz": [0.0, 0.0, 0.09],
        }
    )
    touching = {"kind": "contact", "duration": 0.3, "offset": [-0.001, 0.0, -0.0025]}
    phases = {
        "approach": {
            "kind": "free", "duration": 0.3, "angles": [0.2, 0.0, 0.1], "rates": [0.0, 0.2, 0.8],
            "offset": [0.0, 0.0, 0.0],
        },
        "touch_down": {**touching, "rates": [-0.02, 0.4, 1.0]},
        "forth": {"kind": "contact", "duration": 0.3, "rates": [-0.12, -0.6, 2.0]},
        "back": {"kind": "contact", "duration": 0.3, "rates": [0.06, 0.6, -2.0]},
    }  # fmt: skip
    tree = {
        "settle": 0.06,
        "holder": {
            "stiffness": 1e4, "rotational_stiffness": 300.0, "damping_ratio": 0.7,
            "force_limit": 200.0, "torque_limit": 15.0,
        },
        "start": {"angles": [0.21, 0.0, 0.0], "offset": [0.0, 0.0, 0.003]},
        "phases": phases,
    }  # fmt: skip
    return integrate(plan_from_tree(told, tree))


@pytest.mark.parametrize("seed", [0, *nightly(1, 2, 3)])
def test_a_reversal_is_no_stall(seed):
    truth = reversed_motion()
    assert truth.ended_by == "end"
    back = (truth.phase == "back") & truth.closed.all(axis=1)
    # Turning passes through zero, at some speed of closing, while all contacts stay closed.
    assert (np.diff(np.sign(truth.rates[back, 2])) != 0).any()
    rows = list(Pipeline(truth.plan.configuration).play(measure(truth, seed)))
    assert max(row.alarms[0].level for row in rows) == 0
