"""The covariance stays symmetric positive definite over many steps without a restart."""

from dataclasses import replace

import numpy as np
import pytest
from peg_on_hole_ros.estimation.kernel.memory import SIZE, Z

import long_run
from peg_on_hole_ros.configuration import from_parameters
from peg_on_hole_ros.edges.config_file import read_parameters
from simulated import ROOT, SAMPLES


def run(name, steps, **options):
    configuration = from_parameters(read_parameters(ROOT / "config" / f"{name}.yaml"))
    configuration = replace(configuration, filter=replace(configuration.filter, **options))
    return long_run.long_run(configuration, ROOT / "bags" / f"{name}.mcap", steps)


@pytest.mark.parametrize("name", SAMPLES)
def test_covariance_stays_symmetric_positive_definite(name):
    # Closing without slip has steps that are believed only where a slow slip is.
    for options in ({}, {"slow_slip": 0.0}):
        found = run(name, 100_000, **options)
        assert found.asymmetry == 0.0 and found.not_finite == 0
        # A pivot near rounding, 1e-13 or so, would be one that a longer run may lose.
        assert found.pivot > 1e-10
    assert found.contact > 50_000


def test_a_covariance_that_is_lost_is_found():
    C, memory = np.zeros((14, 14)), np.zeros(SIZE)
    P = memory[Z : Z + 144].reshape(12, 12)
    P[:] = np.eye(12)
    assert long_run._check(memory, C) == (1.0, 0.0)
    P[0, 3] = P[3, 0] = 1.001
    assert long_run._check(memory, C)[0] == -1.0
    P[3, 0] = 0.5
    assert long_run._check(memory, C)[1] == pytest.approx(0.501)
