"""A wrench that is far off for one sample costs that sample, and is counted."""

import numpy as np
import pytest

from late_samples import ordered, pipeline
from peg_on_hole_ros.records import WrenchSample
from tiers import nightly

MS = 1_000_000


@pytest.mark.parametrize("size", [10.0, 50.0, 500.0])
@pytest.mark.parametrize("seed", [0, *nightly(1, 2)])
def test_a_spike_of_one_wrench_is_forgotten_within_milliseconds(size, seed):
    """50, 250 and 2500 deviations of the noise, in a direction that is drawn."""
    random = np.random.default_rng(seed)
    samples = ordered(400)
    wrenches = [i for i, each in enumerate(samples) if isinstance(each, WrenchSample)]
    at = int(random.choice(wrenches[150:300]))
    off = random.normal(size=6) * [1.0, 1.0, 1.0, 0.025, 0.025, 0.025]
    off *= size / np.linalg.norm(off[:3])
    struck = samples[at]
    struck = struck._replace(
        force=tuple(np.add(struck.force, off[:3])), torque=tuple(np.add(struck.torque, off[3:]))
    )
    plain, line = pipeline(), pipeline()
    expected = {each.t_ns: each for each in plain.play(samples)}
    found = list(line.play([*samples[:at], struck, *samples[at + 1 :]]))
    assert line.counts["wrench_spike"] == 1 and plain.counts["wrench_spike"] == 0
    assert line.counts["filter_restarted"] == line.counts["joints_gated"] == 0
    after = [each for each in found if each.t_ns > struck.t_ns + 5 * MS]
    assert len(after) > 90
    for each in after:
        without = expected[each.t_ns]
        spread = np.sqrt(np.diagonal(without.state_covariance))
        # A spike that points along the motion leaves some of itself: within the bounds.
        assert np.all(np.abs(each.state - without.state) < 4.0 * spread)
        assert np.all(np.abs(each.normal - without.normal) < 4.0 * without.normal_stddev)
        assert each.contact_mode == without.contact_mode
