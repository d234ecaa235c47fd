"""One wrench far above any cell's that is still admitted, and what is published behind it."""

from dataclasses import replace

import numpy as np
import pytest

from late_samples import ordered, pipeline, play
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.records import WrenchSample


@pytest.mark.parametrize("times", [1000.0, 10_000.0])
def test_a_load_no_peg_carries_does_not_open_a_hole_that_gives_way(times):
    """The clearance gives by the load times the compliance, which is open."""
    samples, stated = ordered(), pipeline().configuration
    scene = replace(stated.scene, compliance_stddev=1e-5)
    at = [i for i, each in enumerate(samples) if isinstance(each, WrenchSample)][150]
    heavy = samples[at]
    samples[at] = heavy._replace(
        force=tuple(times * each for each in heavy.force),
        torque=tuple(times * each for each in heavy.torque),
    )
    found = play(Pipeline(replace(stated, scene=scene)), samples)
    # A motion that is lost for want of any number gives nothing until the next orientation.
    assert len(found) >= sum(isinstance(each, WrenchSample) for each in samples) - 2
    for outputs in found:
        assert (outputs.state_stddev > 0.0).all()
        assert (outputs.normal_stddev > 0.0).all()
        assert np.isfinite(outputs.position).all()
        # Least of all a clearance beyond the factor of e^3 that is estimated at most.
        assert outputs.clearance < 21.0 * (scene.hole_diameter - scene.peg_diameter)
