"""A tilt has no sign: that of an upright peg is published as zero, where noise has it below."""

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.messages.beside_estimates import smoothed_messages
from peg_on_hole_ros.records import JointSample, WrenchSample


def test_no_tilt_below_zero_is_published():
    """A peg swings upright and stops there; between two joint states the filter goes on."""
    line, tilts, below = Pipeline(Configuration()), [], 0
    for k in range(400):
        t_ns = 10**9 + k * 1_000_000
        if k % 10 == 0:
            tilt = max(0.05 - 2.5e-4 * k, 0.0)
            line.on_joints(JointSample(t_ns, ("gamma", "psi", "phi"), (tilt, 0.3, 0.2)))
        outputs = line.on_wrench(WrenchSample(t_ns, (0.0, 0.0, 4.903), (0.0, 0.0, 0.0)))
        if outputs is not None:
            tilts.append(outputs.state[0])
            below += line.filter.x[0] < 0.0
    assert below > 3
    assert len(tilts) > 350 and min(tilts) == 0.0


def test_no_smoothed_tilt_below_zero_is_published():
    state = np.array([-1e-5, 0.3, 0.2, 0.0, 0.0, 0.0])
    (_, _, fields), _ = smoothed_messages(10**9, state, np.eye(6))
    assert fields["position"] == [0.0, 0.3, 0.2]
