"""The covariance is a promise: errors over noise seeds that no tuning has seen."""

import numpy as np
import pytest

from benchmarks.grid.consistency import score
from simulated import SAMPLES, truth

# Of a few seeds, test_other_pegs and test_open_quantities.
pytestmark = pytest.mark.nightly
# The closing scenes are short: with fewer seeds chance alone moves an error by a tenth.
SEEDS = {"working_cycle": range(7000, 7003)}
MANY_SEEDS = range(7000, 7020)
# Where nothing is promised: contacts stand still only without the slip that carries them, and
# reactions are told from a few wrenches on.
UNPROMISED = {
    "closing_without_slip": {"reversal", "singular"},
    "closing_with_slip": {"singular"},
    "working_cycle": {"reversal", "singular"},
}


@pytest.fixture(scope="module", params=SAMPLES)
def scored(request):
    seeds = SEEDS.get(request.param, MANY_SEEDS)
    return request.param, *score(truth(request.param), seeds)


def test_errors_keep_to_what_is_stated(scored, request):
    name, found, finite = scored
    if name == "closing_without_slip":
        reason = "bounds are too wide while several frictions live"
        request.applymarker(pytest.mark.xfail(strict=True, reason=reason))
    assert finite
    steady = found["steady"]
    assert steady["samples"] > 100 * len(SEEDS.get(name, MANY_SEEDS))
    reactions = slice(6, 9)
    assert (steady["ratio"][reactions] <= 1.3).all(), steady["ratio"]
    assert (steady["relative"] <= 0.05).all(), steady["relative"]
    # 95 % bounds; errors are correlated over some 10 ms, so that a few thousand samples count as
    # a few hundred, with a standard deviation of 1 to 2 %.
    assert (steady["coverage95"] >= 0.90).all(), steady["coverage95"]
    assert (steady["coverage95"][reactions] <= 0.99).all(), steady["coverage95"]


def test_angles_are_better_than_they_are_measured(scored):
    name, found, _ = scored
    result = truth(name)
    stddev = result.plan.configuration.joints.position_stddev
    rms = found["steady"]["rms"][:3]
    assert rms[0] < stddev
    # psi and phi alone are measured to stddev / sin(gamma).
    sine = np.sin(result.q[result.mode == "three_point", 0])
    assert (rms[1:] < stddev * np.sqrt((1 / sine**2).mean())).all()


def test_nothing_diverges_where_nothing_is_promised(scored):
    name, found, _ = scored
    assert found.keys() - {"steady"} == UNPROMISED[name]
    for kind in UNPROMISED[name]:
        assert found[kind]["rms"][0] < 1e-3
        assert (found[kind]["rms"][1:3] < 0.02).all()
