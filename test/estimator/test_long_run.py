"""The covariance stays symmetric positive definite over many steps without a restart."""

import numpy as np
import pytest

from benchmarks.cost import long_run
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.parameters_file import read_parameters
from simulated import ROOT, SAMPLES
from tiers import at_push


@pytest.mark.parametrize("name", at_push(SAMPLES[:1], SAMPLES))
def test_covariance_stays_symmetric_positive_definite(name):
    configuration = from_parameters(read_parameters(ROOT / "config" / f"{name}.yaml"))
    found = long_run.long_run(configuration, ROOT / "bags" / f"{name}.mcap", 20_000)
    assert found.asymmetry < 1e-12 and found.not_finite == 0
    # A pivot near rounding, 1e-13 or so, would be one that a longer run may lose.
    assert found.pivot > 1e-10


def test_a_covariance_that_is_lost_is_found():
    P = np.tile(np.eye(4), (2, 1, 1))
    assert long_run.check(P) == (1.0, 0.0)
    P[1, 0, 3] = P[1, 3, 0] = 1.001
    assert long_run.check(P)[0] == -1.0
    P[1, 3, 0] = 0.5
    assert long_run.check(P)[1] == pytest.approx(0.501)
