"""The mean direction of friction where the slip is uncertain, against draws of that slip."""

import numpy as np
import pytest

from peg_on_hole_ros.estimator.friction_direction import slip_statistics
from peg_on_hole_ros.estimator.state import RATE

# Two rates that are the slip's two components, and one that does not move the contact.
ROWS = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0))


def moments(slip, variances, share=1.0):
    x, P = np.zeros(RATE + 3), np.zeros((RATE + 3, RATE + 3))
    x[RATE : RATE + 2] = slip
    P[RATE : RATE + 2, RATE : RATE + 2] = np.diag(variances)
    return slip_statistics(ROWS, x, P, share)


def drawn(slip, variances):
    rng = np.random.default_rng(3)
    v = rng.standard_normal((200_000, 2)) * np.sqrt(variances) + slip
    return v / np.linalg.norm(v, axis=1)[:, None]


@pytest.mark.parametrize("ratio", [0.1, 1.0, 4.0, 30.0])
def test_the_mean_direction_of_an_even_spread(ratio):
    """Its length is below one, and by the scale: within 1.3 %, and the draws within 0.3 %."""
    slip, variance = np.array([0.6, -0.8]) * np.sqrt(ratio), (1.0, 1.0)
    _, _, scale2 = moments(slip, variance)
    mean = drawn(slip, variance).mean(axis=0)
    assert slip / np.sqrt(slip @ slip + scale2) == pytest.approx(mean, rel=0.02, abs=5e-3)


def test_a_fast_slip_points_elsewhere_by_what_lies_across_it():
    """The sine is the part across over the speed; along it the spread turns nothing."""
    slip = np.array([6.0, 8.0])
    for variances in ((0.04, 0.04), (0.16, 0.01)):
        turned, left, _ = moments(slip, variances)
        directions = drawn(slip, variances)
        sines = directions @ [-0.8, 0.6]
        assert turned == pytest.approx(np.mean(sines**2), rel=0.03)
        # Nearly all of the friction follows the slip.
        assert 0.0 <= left < 2e-3


def test_the_share_of_the_spread_scales_the_scale():
    whole, half = (moments((0.3, 0.1), (1.0, 0.25), share)[2] for share in (1.0, 0.5))
    assert half == pytest.approx(0.5 * whole, rel=1e-12) and whole > 0.0
